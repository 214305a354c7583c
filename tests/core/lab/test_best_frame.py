"""The best frame: its covariances are those of errors after alignment, and do not depend on which pose was held."""

from __future__ import annotations

import numpy as np

from bspline_slam import se2
from bspline_slam.backends import back_end
from bspline_slam.backends.protocol import Estimate
from bspline_slam.graph import Graph, PoseFactor, PosePrior
from bspline_slam.lab.best_frame import BestFrame
from bspline_slam.lab.evaluation import alignment

COUNT = 12
SIGMAS = np.array([0.01, 0.02, 0.01])


def ring(held: int, rng: np.random.Generator | None = None) -> Graph:
    """Key poses round a ring, each tied to the next, the last to the first; steps are off by noise with a generator."""
    angle = 2 * np.pi * np.arange(COUNT) / COUNT
    poses = np.stack([3 * np.cos(angle), 2 * np.sin(angle), angle], -1)
    factors = []
    for i in range(COUNT):
        j = (i + 1) % COUNT
        noise = np.zeros(3) if rng is None else SIGMAS * rng.standard_normal(3)
        step = se2.compose(se2.between(poses[i], poses[j]), noise)
        factors.append(PoseFactor(i, j, step, np.diag(1 / SIGMAS), "odometry"))
    return Graph(
        key_scans=np.arange(COUNT),
        poses=poses,
        spline_ids=np.zeros(0, dtype=np.int64),
        spline_first=np.zeros(1, dtype=np.int64),
        control_points=np.zeros((0, 2)),
        pose_factors=tuple(factors),
        pose_priors=(PosePrior(held, poses[held], np.eye(3) / 1e-5),),
    )


def framed(estimate: Estimate) -> np.ndarray:
    covariances = back_end("direct").covariances(estimate, poses=range(COUNT)).poses
    frame = BestFrame.of(estimate)
    return np.array([frame.pose(estimate, k, covariances[k]) for k in range(COUNT)])


def test_which_pose_is_held_does_not_matter() -> None:
    first, other = (framed(back_end("direct").solve(ring(held))) for held in (0, 7))
    np.testing.assert_allclose(first, other, rtol=1e-4, atol=1e-9)
    assert np.linalg.eigvalsh(first).min() > 0


def test_covariances_are_those_of_errors_after_alignment() -> None:
    rng, truth = np.random.default_rng(3), ring(0).poses
    errors = []
    for _ in range(400):
        found = back_end("direct").solve(ring(0, rng)).poses
        off = found - se2.compose(alignment(truth[:, :2], found[:, :2]), truth)
        off[:, 2] = se2.wrap(off[:, 2])
        errors.append(off)
    sampled = np.einsum("nki,nkj->kij", errors, errors) / len(errors)
    expected = framed(back_end("direct").solve(ring(0)))
    scale = np.sqrt(np.einsum("kii->ki", expected))
    assert np.abs((sampled - expected) / (scale[:, :, None] * scale[:, None, :])).max() < 0.35


def test_a_place_across_its_normal_is_the_pose_seen_in_that_direction() -> None:
    estimate = back_end("direct").solve(ring(0))
    covariance = back_end("direct").covariances(estimate, poses=[4]).poses[4]
    frame, normal = BestFrame.of(estimate), np.array([[0.6, 0.8]])
    given = np.einsum("mi,ij,mj->m", normal, covariance[:2, :2], normal)
    across = frame.across(estimate.poses[4:5, :2], normal, normal, 3 * 4, given)
    expected = normal[0] @ frame.pose(estimate, 4, covariance)[:2, :2] @ normal[0]
    np.testing.assert_allclose(across, [expected], rtol=1e-9)


def test_the_frame_knows_a_pose_far_from_the_held_one_better() -> None:
    estimate = back_end("direct").solve(ring(0))
    alone = back_end("direct").covariances(estimate, poses=[6]).poses[6]
    assert np.trace(framed(estimate)[6][:2, :2]) < 0.5 * np.trace(alone[:2, :2])
