"""The calibration in plain sentences."""

from __future__ import annotations

from dataclasses import replace

import pytest

from bspline_slam.calibration.laser import LaserCalibration
from bspline_slam.calibration.odometry import OdometryBias
from splinescope.calibration_text import laser_findings, odometry_findings
from splinescope.quality import LaserNoise

BIAS = OdometryBias(100, 0.963, 0.98, 0.05, 0.04, -0.3)


def test_every_figure_of_odometry_has_its_sentence() -> None:
    found = {finding.name: finding for finding in odometry_findings(BIAS, True)}
    assert "3.8% too much of what was driven" in found["distance scale"].sentence
    assert "2.86° to the left" in found["turn per metre"].sentence
    assert "40.0 mm ahead of" in found["lever"].sentence
    assert "ahead of the scan" in found["lag"].sentence


@pytest.mark.parametrize(
    ("scale", "said"),
    [(1.001, "A metre of odometry is a metre"), (1.25, "20.0% too little"), (-1.0, "wrong sign"), (0.0, "nothing")],
)
def test_a_scale_is_put_in_words(scale: float, said: str) -> None:
    assert said in odometry_findings(replace(BIAS, distance_scale=scale), True)[0].sentence


def test_other_directions_have_other_words() -> None:
    found = {
        f.name: f.sentence for f in odometry_findings(replace(BIAS, turn_per_metre=-0.1, lever=-0.02, lag=0.5), True)
    }
    assert "to the right" in found["turn per metre"]
    assert "20.0 mm behind" in found["lever"]
    assert "behind the scan" in found["lag"]


def test_what_is_next_to_nothing_is_none() -> None:
    found = odometry_findings(replace(BIAS, turn_per_metre=-1e-17, lever=4e-15, lag=0.0), True)
    assert [finding.value for finding in found[2:]] == ["none"] * 3


def test_what_is_not_known_is_said() -> None:
    assert "no odometry" in odometry_findings(None, False)[0].sentence
    assert "too little" in odometry_findings(None, True)[0].sentence
    assert "at 3 scans it was not believed" in odometry_findings(None, True, [4, 5, 6])[0].sentence
    for has_odometry in (False, True):
        told = odometry_findings(None, has_odometry, untold=[7, 9])[-1].sentence
        assert "before 2 key scans" in told
        assert "7, 9" in told
    unknown = laser_findings(LaserNoise(0.012, None, None), None, LaserCalibration())
    assert [finding.value for finding in unknown] == ["", "12.0 mm configured", "–"]


def test_odometry_that_was_not_believed_comes_first() -> None:
    first, *others = odometry_findings(BIAS, True, [3, 4, 5, 9])
    assert "at 4 scans it was not believed" in first.sentence
    assert "3–5, 9" in first.sentence
    assert others == odometry_findings(BIAS, True)


@pytest.mark.parametrize(("chi2", "said"), [(0.5, "careful side"), (1.0, "about as well"), (2.0, "claim too much")])
def test_a_fit_is_judged(chi2: float, said: str) -> None:
    assert said in laser_findings(LaserNoise(0.012, 0.009, 0.75), chi2, LaserCalibration())[-1].sentence


def test_estimate_and_assumption_stand_side_by_side() -> None:
    _, noise, spread, _ = laser_findings(LaserNoise(0.012, 0.0091, 0.75), 1.0, LaserCalibration())
    assert noise.value == "9.1 mm (configured 12.0 mm)"
    assert "less than the noise configured" in spread.sentence


def test_what_beams_were_corrected_by_is_told() -> None:
    told = LaserCalibration(0.0124, -0.0131, 0.0094, 0.001, 0.001, 0.0005)
    found = {f.name: f for f in laser_findings(LaserNoise(0.012, None, None), None, told)}
    assert found["sweep"].value == "12.4 ± 1.0 ms"
    assert "rightmost beam to its leftmost" in found["sweep"].sentence
    assert "even number are taken so much later" in found["interlace"].sentence
    assert "9.4 mm ± 0.5 mm" in found["range bias"].value
    assert "too long" in found["range bias"].sentence
