"""Residuals: signs, curves and noise come out as they were put in."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bspline_slam.fitting import FittingConfig
from bspline_slam.lab.crispness import crispness
from bspline_slam.lab.residuals import BeamResiduals, robust_sigma
from bspline_slam.lab.wall_beams import WallBeams
from bspline_slam.segmentation import segment_scan
from bspline_slam.sights import KeyObservations
from core.lab.walls import beams, drive, room

FITTING = FittingConfig(range_noise=0.01, bearing_noise=1e-3)


def test_the_noise_of_ranges_is_recovered_from_steep_beams() -> None:
    seen, walls = beams(0.012), room()
    found = BeamResiduals.of(seen, walls, FITTING)
    assert found.range_noise == pytest.approx(0.012, rel=0.1)
    assert found.spread == pytest.approx(1.2, rel=0.1)
    assert found.crispness == crispness(seen, walls)


def test_beams_that_end_early_are_in_front_of_their_curve() -> None:
    seen = beams(0.0)
    short = replace(seen, points=seen.points - 0.02 * seen.directions)
    found = BeamResiduals.of(short, room(), FITTING)
    assert np.median(found.across / found.cosine) == pytest.approx(0.02, abs=0.004)


def test_clutter_does_not_change_the_noise() -> None:
    rng, seen = np.random.default_rng(1), beams(0.008)
    clutter = rng.random(len(seen)) < 0.1
    off = np.where(clutter, rng.uniform(-0.04, 0.04, len(seen)), 0.0)[:, None]
    found = BeamResiduals.of(replace(seen, points=seen.points + off * seen.directions), room(), FITTING)
    clean = BeamResiduals.of(seen, room(), FITTING)
    assert found.range_noise is not None and clean.range_noise is not None
    assert found.range_noise == pytest.approx(clean.range_noise, rel=0.25)


def test_each_beam_is_measured_at_its_foot() -> None:
    walls = room()
    found = BeamResiduals.of(beams(0.01), walls, FITTING)
    assert (np.diff(found.spline) >= 0).all()
    assert set(found.spline) == {1, 2, 3}, "the first wall is behind the robot"
    for number in (1, 2, 3):
        t, (low, high) = found.t[found.spline == number], walls.splines[number].span
        assert low <= t.min() < t.max() <= high and np.ptp(t) > 0.3


def test_too_few_beams_tell_no_noise() -> None:
    seen = beams(0.01)
    few = BeamResiduals.of(seen.part(np.arange(len(seen)) < 100), room(), FITTING)
    assert few.range_noise is None and few.spread is None
    none = BeamResiduals.of(seen.part(np.zeros(len(seen), dtype=bool)), room(), FITTING)
    assert len(none.across) == 0 and np.isnan(none.crispness.rms)


def test_segments_of_key_scans_give_the_beams_of_the_log() -> None:
    log, same = drive(0.01), beams(0.01)
    keys = [KeyObservations(k, segment_scan(log[k]), (), 0, log[k].pose_robot_sensor[:2]) for k in range(len(log))]
    seen = WallBeams.from_key_scans(keys, same.poses)
    for name in ("pose", "beam", "points", "directions", "ranges"):
        assert np.allclose(getattr(seen, name), getattr(same, name), atol=1e-9)
    assert len(WallBeams.from_key_scans([], np.zeros((0, 3)))) == 0


@pytest.mark.parametrize("sigma", [1e-3, 2.0])
def test_a_robust_deviation_is_that_of_a_gaussian(sigma: float) -> None:
    assert robust_sigma(5.0 + sigma * np.random.default_rng(2).standard_normal(20000)) == pytest.approx(sigma, rel=0.03)
