"""What gets in the way of a laser: it only ever shortens ranges, and comes as often as it was asked to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bspline_slam.lab.disturbances import DisturbanceModel, Disturbances

TIMES = 0.25 * np.arange(4000)
POSITIONS = np.stack([0.4 * TIMES, np.sin(0.1 * TIMES)], -1)
ANGLES = np.radians(np.arange(-90, 90))
RAYS = np.stack([np.cos(ANGLES), np.sin(ANGLES)], -1)


def drawn(model: DisturbanceModel, seed: int = 0) -> Disturbances:
    return Disturbances.drawn(model, TIMES, POSITIONS, np.random.default_rng(seed))


def shortened(around: Disturbances, ranges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All scans at once: ranges and stopped beams."""
    rng = np.random.default_rng(1)
    pairs = [around.shortened(k, ranges, POSITIONS[k], RAYS, rng) for k in range(len(TIMES))]
    return np.array([reach for reach, _ in pairs]), np.array([stopped for _, stopped in pairs])


def test_beams_end_at_the_world_or_before_it() -> None:
    ranges = np.where(np.arange(180) % 3 == 0, np.inf, 5.0)
    reach, stopped = shortened(drawn(DisturbanceModel()), ranges)
    assert np.all(reach <= ranges) and np.array_equal(reach < ranges, stopped)
    assert np.all(reach > 0) and stopped.any()


def test_a_building_without_people_disturbs_nobody() -> None:
    _, stopped = shortened(drawn(DisturbanceModel(blocked_every=0, person_every=0)), np.full(180, 30.0))
    assert not stopped.any()


def test_a_blocked_scan_sees_nearly_nothing_else() -> None:
    model = DisturbanceModel(blocked_every=300, person_every=0)
    around = drawn(model)
    reach, stopped = shortened(around, np.full(180, 8.0))
    blocked = ~np.isnan(around.blocked_at)
    assert 0 < blocked.sum() < 0.1 * len(TIMES)
    assert np.abs(stopped[blocked].mean() - model.blocked_share) < 0.02
    assert not stopped[~blocked].any()
    assert reach[stopped].min() >= model.blocked_range[0] and reach[stopped].max() <= model.blocked_range[1]


def test_events_come_as_often_as_asked_for() -> None:
    model = DisturbanceModel(person_every=50)
    counts = [len(drawn(model, seed).walks) for seed in range(30)]
    assert abs(np.mean(counts) - len(TIMES) / 50) < 5 * np.sqrt(len(TIMES) / 50 / 30)


def test_people_walk_at_their_pace_beside_the_path() -> None:
    model = replace(DisturbanceModel(), pace=0.3)
    for scans, path in drawn(model).walks:
        nearest = np.linalg.norm(path[:, None] - POSITIONS[None], axis=-1).min(1)
        assert np.all(nearest < model.aside + 0.1)
        gone = np.linalg.norm(np.diff(path, axis=0), axis=1)
        assert np.all(gone <= model.pace * np.diff(TIMES[scans]) + 1e-9)
        assert TIMES[scans[-1]] - TIMES[scans[0]] <= model.seconds
