"""Local point-feature maps: read with care, joined to the optimum of all of them, written so that NumPy reads them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares

from bspline_slam import se2
from bspline_slam.errors import Cancelled, LocalMapError
from bspline_slam.joining import JointMap, first_guess, join_point_maps, read_information, read_point_maps
from core.point_maps import Survey, arrays, survey

Arrays = dict[str, np.ndarray]


def residuals(unknowns: np.ndarray, made: Survey, ids: np.ndarray) -> np.ndarray:
    """Of all maps, written anew: whitened differences of end poses and features in the frame of each start pose."""
    count = len(made.maps)
    poses = np.vstack([np.zeros(3), unknowns[: 3 * count].reshape(-1, 3)])
    features = unknowns[3 * count :].reshape(-1, 2)
    parts = []
    for k, one in enumerate(made.maps):
        end = se2.between(poses[k], poses[k + 1]) - one.end
        end[2] = se2.wrap(end[2])
        seen = se2.transform(se2.inverse(poses[k]), features[np.searchsorted(ids, one.ids)]) - one.features
        parts.append(np.linalg.solve(np.linalg.cholesky(one.covariance), np.append(end, seen.ravel())))
    return np.concatenate(parts)


def unknowns_of(joint: JointMap) -> np.ndarray:
    return np.append(joint.poses[1:].ravel(), joint.features.ravel())


def test_without_noise_the_joint_map_is_the_truth() -> None:
    made = survey(np.random.default_rng(0), noise=0.0)
    joint = join_point_maps(made.maps)
    assert joint.converged
    assert joint.chi2 == pytest.approx(0.0, abs=1e-12)
    assert np.abs(se2.between(made.poses, joint.poses)).max() < 1e-8
    assert np.abs(joint.features - made.features[(joint.feature_ids - 10) // 3]).max() < 1e-8


@pytest.mark.parametrize("seed", range(2))
def test_the_joint_map_is_the_least_squares_optimum(seed: int) -> None:
    made = survey(np.random.default_rng(seed), maps=6, laps=1)
    joint = join_point_maps(made.maps)
    found = unknowns_of(joint)
    best = least_squares(residuals, found + 0.01, args=(made, joint.feature_ids), xtol=1e-15, ftol=1e-15, gtol=1e-12)
    np.testing.assert_allclose(found, best.x, atol=1e-6)
    assert joint.chi2 == pytest.approx(2 * best.cost, rel=1e-9)
    assert joint.dof == len(best.fun) - len(best.x)
    expected = best.jac.T @ best.jac
    np.testing.assert_allclose(joint.information.toarray(), expected, atol=1e-5 * np.abs(expected).max())


def test_chi_square_is_that_of_the_noise() -> None:
    rng = np.random.default_rng(3)
    ratios = [joint.chi2 / joint.dof for joint in (join_point_maps(survey(rng).maps) for _ in range(4))]
    assert 0.9 < np.mean(ratios) < 1.1


def test_errors_are_those_that_the_information_promises() -> None:
    """NEES of features over runs, N·mean ~ χ² with N·n degrees of freedom, within four of its deviations."""
    rng, total, freedom = np.random.default_rng(4), 0.0, 0
    for _ in range(6):
        made = survey(rng, maps=12, laps=1)
        joint = join_point_maps(made.maps)
        error = (joint.features - made.features[(joint.feature_ids - 10) // 3]).ravel()
        spread = np.linalg.inv(joint.information.toarray())[-len(error) :, -len(error) :]
        total += float(error @ np.linalg.solve(spread, error))
        freedom += len(error)
    assert abs(total - freedom) < 4 * np.sqrt(2 * freedom)


def test_bad_odometry_is_pulled_straight_by_the_features() -> None:
    """With ten times the noise composed odometry folds over itself; the optimum is still found."""
    made = survey(np.random.default_rng(5), maps=60)
    worse = tuple(spoiled(one, np.random.default_rng(k)) for k, one in enumerate(made.maps))
    joint = join_point_maps(worse)
    ids = joint.feature_ids
    dead_reckoned = np.vstack([np.zeros(3), first_guess(worse, ids).poses])
    assert np.abs(se2.between(made.poses, dead_reckoned)[:, :2]).max() > 3.0
    assert np.abs(se2.between(made.poses, joint.poses)[:-1, :2]).max() < 0.5
    assert joint.converged
    assert joint.chi2 / joint.dof < 1.5


def test_a_long_chain_is_straightened_from_odometry_that_turns_five_degrees_a_map() -> None:
    """The way to the optimum of a chain of 300 maps leads uphill; nothing holds its soft bending modes back."""
    made = survey(np.random.default_rng(11), maps=300, laps=1, radius=100.0)
    worse = tuple(spoiled(one, np.random.default_rng(k), (1.0, 1.0, 4.4)) for k, one in enumerate(made.maps))
    joint = join_point_maps(worse)
    assert joint.converged
    assert len(joint.iterations) < 15
    assert joint.chi2 / joint.dof < 1.3  # the odometry keeps its first error beside the added one


def test_maps_known_to_a_nanometre_are_joined_as_well() -> None:
    """Steps that only rounding keeps from descending end the descent."""
    rng, exact = np.random.default_rng(12), survey(np.random.default_rng(12), noise=0.0)
    maps = []
    for one in exact.maps:
        P = 1e-16 * one.covariance
        error = np.linalg.cholesky(P) @ rng.normal(size=len(P))
        maps.append(
            replace(one, end=one.end + error[:3], features=one.features + error[3:].reshape(-1, 2), covariance=P)
        )
    joint = join_point_maps(maps)
    assert joint.converged
    assert joint.chi2 / joint.dof == pytest.approx(1.0, abs=0.2)


def test_maps_that_contradict_each_other_end_soon_and_say_so() -> None:
    made = survey(np.random.default_rng(13), maps=20)
    rng = np.random.default_rng(14)
    mixed = tuple(replace(one, ids=rng.permutation(one.ids)) for one in made.maps)
    joint = join_point_maps(mixed)
    assert joint.chi2 / joint.dof > 100.0
    assert len(joint.iterations) <= 102


def test_one_map_is_its_own_joint_map() -> None:
    one = survey(np.random.default_rng(15)).maps[0]
    joint = join_point_maps([one])
    assert joint.dof == 0
    np.testing.assert_allclose(joint.poses[1], one.end, atol=1e-12)
    np.testing.assert_allclose(joint.features, one.features, atol=1e-12)


def spoiled(one, rng: np.random.Generator, times: tuple[float, float, float] = (10.0, 10.0, 10.0)):
    """The map with its end pose known so many times worse, and independent of the features."""
    scale = np.concatenate([times, np.ones(2 * len(one.ids))])
    P = one.covariance * scale[:, None] * scale
    P[:3, 3:], P[3:, :3] = 0.0, 0.0
    error = np.linalg.cholesky(P[:3, :3]) @ rng.normal(size=3)
    return type(one)(one.end + error, one.features, P, one.ids)


def test_records_tell_a_descent_from_composed_odometry() -> None:
    made, seen = survey(np.random.default_rng(6)), []
    joint = join_point_maps(made.maps, progress=seen.append)
    costs = [record.cost for record in joint.iterations]
    assert [record.index for record in joint.iterations] == list(range(len(costs)))
    assert [record.index for record in seen] == list(range(len(seen)))
    assert [record.cost for record in seen[1 - len(costs) :]] == costs[1:]
    assert np.all(np.diff(costs) <= 1e-9 * (1 + np.array(costs[:-1])))
    np.testing.assert_array_equal(seen[0].poses, first_guess(made.maps, joint.feature_ids).poses)


def test_joining_can_be_cancelled() -> None:
    with pytest.raises(Cancelled, match="0 of 40 local maps"):
        join_point_maps(survey(np.random.default_rng(7)).maps, cancelled=lambda: True)


def test_maps_without_features_are_odometry() -> None:
    maps = tuple(
        type(one)(one.end, one.features[:0], one.covariance[:3, :3], one.ids[:0])
        for one in survey(np.random.default_rng(8), maps=5).maps
    )
    joint = join_point_maps(maps)
    assert joint.features.shape == (0, 2)
    assert joint.dof == 0
    np.testing.assert_allclose(joint.poses[1:], first_guess(maps, joint.feature_ids).poses, atol=1e-12)


def test_files_come_back_as_they_went(tmp_path: Path) -> None:
    made = survey(np.random.default_rng(9), maps=12)
    np.savez(tmp_path / "maps.npz", **arrays(made.maps))  # pyright: ignore[reportArgumentType]
    read = read_point_maps(tmp_path / "maps.npz")
    for one, other in zip(made.maps, read, strict=True):
        np.testing.assert_array_equal(one.ids, other.ids)
        np.testing.assert_allclose(one.features, other.features)
        np.testing.assert_allclose(one.covariance, other.covariance)
    joint = join_point_maps(read)
    joint.to_npz(tmp_path / "joint.npz")
    with np.load(tmp_path / "joint.npz") as written:
        assert set(written.files) == {"poses", "features", "feature_ids", "information"}
        assert written["poses"].shape == (13, 3)
        assert written["information"].shape[1] == 3
        np.testing.assert_array_equal(written["features"], joint.features)
    back = read_information(tmp_path / "joint.npz")
    np.testing.assert_array_equal(back.toarray(), joint.information.toarray())


def test_whole_numbers_may_be_stored_as_floats(tmp_path: Path) -> None:
    parts = arrays(survey(np.random.default_rng(16), maps=2).maps)
    parts["id0"], parts["id1"] = parts["id0"].astype(float), parts["id1"].astype(np.uint64)
    np.savez(tmp_path / "maps.npz", **parts)  # pyright: ignore[reportArgumentType]
    assert all(one.ids.dtype == np.int64 for one in read_point_maps(tmp_path / "maps.npz"))


def without(name: str) -> Callable[[Arrays], None]:
    return lambda parts: parts.__delitem__(name)


def changed(name: str, change: Callable[[np.ndarray], np.ndarray]) -> Callable[[Arrays], None]:
    return lambda parts: parts.__setitem__(name, change(parts[name]))


def renumbered(parts: Arrays) -> None:
    """A gap before the last map."""
    for name in ("x", "P", "id"):
        parts[f"{name}9"] = parts.pop(f"{name}3")


def skewed(P: np.ndarray) -> np.ndarray:
    return P + np.triu(P, 1)


@pytest.mark.parametrize(
    ("spoil", "sentence"),
    [
        (dict.clear, "holds no local map"),
        (without("P1"), "array P1 is missing"),
        (without("id2"), "array id2 is missing"),
        (without("x1"), "array x1 is missing"),
        (without("x3"), "array x3 is missing"),
        (renumbered, "array x3 is missing"),
        (changed("x1", lambda x: x[:-1]), r"x1 must be \(\d+,\) and P1"),
        (changed("P2", lambda P: P[:-1]), r"P2 \(\d+, \d+\), not"),
        (changed("P0", skewed), "P0 is not symmetric"),
        (changed("P1", lambda P: -P), "P1 is not positive definite"),
        (changed("P1", lambda P: P * 0.0), "P1 is not positive definite"),
        (changed("x2", lambda x: x * np.nan), "x2 or P2 holds values that are not finite"),
        (changed("id1", lambda ids: ids + 0.5), "id1 must be a list of integers"),
        (changed("id1", lambda ids: ids[:, None]), "id1 must be a list of integers"),
        (changed("id1", lambda ids: ids.astype(np.uint64) + np.uint64(2**63)), "id1 must be a list of integers"),
        (changed("id1", lambda ids: ids.astype(str)), "id1 must be a list of integers"),
        (changed("id1", lambda ids: np.full_like(ids, 7)), "id1 names feature 7 twice"),
    ],
)
def test_what_is_wrong_with_a_file_is_said_in_a_sentence(
    tmp_path: Path, spoil: Callable[[Arrays], None], sentence: str
) -> None:
    parts = arrays(survey(np.random.default_rng(10), maps=4).maps)
    spoil(parts)
    np.savez(tmp_path / "maps.npz", **parts)  # pyright: ignore[reportArgumentType]
    with pytest.raises(LocalMapError, match=rf"^maps.npz: .*{sentence}"):
        read_point_maps(tmp_path / "maps.npz")


@pytest.mark.parametrize("content", [b"", b"no archive", b"PK\x03\x04 broken", b"\x93NUMPY broken"])
def test_what_is_no_archive_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "maps.npz").write_bytes(content)
    with pytest.raises(LocalMapError, match=r"is no \.npz file"):
        read_point_maps(tmp_path / "maps.npz")
