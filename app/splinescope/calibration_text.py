"""What the calibration of wheels and laser means, figure by figure, in plain sentences."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bspline_slam.calibration.laser import LaserCalibration
from bspline_slam.calibration.odometry import OdometryBias
from splinescope.lost_scans import listed
from splinescope.quality import LaserNoise

SAME = 0.005
"""Scales that differ from 1 by less are as good as 1."""
FAIR, FAIR_SPREAD = (0.8, 1.25), (0.9, 1.1)
"""χ²/dof, and a spread of residuals, between which the noise assumed is about right."""
LEAST_DRIFT, LEAST_LEVER = 0.005, 5e-5
"""A turn per metre (°) and a lever (m) below these are none."""


class Finding(NamedTuple):
    """A figure: its name, its value with the unit, and what it means."""

    name: str
    value: str
    sentence: str


def laser_findings(noise: LaserNoise, chi2_per_dof: float | None, calibration: LaserCalibration) -> list[Finding]:
    """What beams were corrected by, the noise of ranges, and the fit of the whole."""
    spread = [_spread(noise.spread)] if noise.spread is not None else []
    return [*_corrections(calibration), _range_noise(noise), *spread, _fit(chi2_per_dof)]


def odometry_findings(
    bias: OdometryBias | None, has_odometry: bool, unfit: Sequence[int] = (), untold: Sequence[int] = ()
) -> list[Finding]:
    """The bias of odometry and its lag, after where it was not believed and where nothing tells the way (scans by
    index); one sentence where there is nothing to tell."""
    open_ways = [Finding("", "", open_in_words(untold))] if untold else []
    if not has_odometry:
        return [Finding("", "", "This log has no odometry."), *open_ways]
    disbelieved = [*([Finding("", "", unfit_in_words(unfit))] if unfit else []), *open_ways]
    if bias is None:
        return disbelieved or [Finding("", "", "The robot moved too little to tell how odometry errs.")]
    return [
        *disbelieved,
        Finding("distance scale", f"{bias.distance_scale:.3f}", _scale(bias.distance_scale, "metre", "driven")),
        Finding("turn scale", f"{bias.turn_scale:.3f}", _scale(bias.turn_scale, "degree", "turned")),
        _drift(bias.turn_per_metre),
        _lever(bias.lever),
        _lag(bias.lag),
    ]


def unfit_in_words(unfit: Sequence[int]) -> str:
    """A sentence on the scans whose odometry did not fit (indices of the log, increasing)."""
    count = "1 scan" if len(unfit) == 1 else f"{len(unfit):,} scans"
    return (
        f"Odometry does not tell of the motion that the scans show: at {count} it was not believed, and beams alone "
        f"said where the robot is ({listed(unfit)})."
    )


def open_in_words(scans: Sequence[int]) -> str:
    """A sentence on the key scans that nothing told the way to in every direction (indices of the log, increasing)."""
    count = "1 key scan" if len(scans) == 1 else f"{len(scans):,} key scans"
    return (
        f"Neither beams nor odometry tell how far the robot went in some direction before {count}: the map may be too "
        f"long or too short there, as covariances say ({listed(scans)})."
    )


def _corrections(told: LaserCalibration) -> list[Finding]:
    """Those that the log tells for sure; one sentence where it tells none."""
    found = []
    if told.sweep:
        ends = ("right", "left") if told.sweep > 0.0 else ("left", "right")
        sentence = f"From its {ends[0]}most beam to its {ends[1]}most a sweep takes so long, while the robot goes on."
        found.append(Finding("sweep", _ms(abs(told.sweep), told.sweep_sigma), sentence))
    if told.interlace:
        which = ("odd", "even") if told.interlace > 0.0 else ("even", "odd")
        sentence = f"Beams of {which[0]} number are taken so much later than those of {which[1]} number."
        found.append(Finding("interlace", _ms(abs(told.interlace), told.interlace_sigma), sentence))
    if told.offset:
        value = f"{_mm(abs(told.offset))} ± {_mm(told.offset_sigma)}"
        how = "long" if told.offset > 0.0 else "short"
        found.append(
            Finding("range bias", value, f"All ranges were so much too {how}; the map is made of corrected ones.")
        )
    none = "Neither a bias of ranges nor the time that a sweep takes shows in this log."
    return found or [Finding("", "", none)]


def _range_noise(noise: LaserNoise) -> Finding:
    if noise.estimated is None:
        value, sentence = f"{_mm(noise.configured)} configured", "Too few beams meet a curve steeply to estimate it."
    else:
        value = f"{_mm(noise.estimated)} (configured {_mm(noise.configured)})"
        sentence = "Standard deviation of one range, from the beams that meet their curve head-on, outliers aside."
    return Finding("range noise", value, sentence)


def _spread(spread: float) -> Finding:
    how = "as" if FAIR_SPREAD[0] <= spread <= FAIR_SPREAD[1] else "less than" if spread < 1.0 else "more than"
    sentence = f"Beams at all angles scatter {how} the noise configured lets expect (1 σ)."
    return Finding("spread of residuals", f"{spread:.2f} σ", sentence)


def _fit(chi2_per_dof: float | None) -> Finding:
    if chi2_per_dof is None:
        return Finding("χ²/dof", "–", "It comes with the first solved map.")
    if chi2_per_dof < FAIR[0]:
        meaning = "The measurements agree better than the noise assumed: covariances are on the careful side."
    elif chi2_per_dof > FAIR[1]:
        meaning = "The measurements agree worse than the noise assumed: covariances claim too much."
    else:
        meaning = "The measurements agree about as well as the noise assumed."
    return Finding("χ²/dof", f"{chi2_per_dof:.2f}", meaning)


def _scale(scale: float, unit: str, done: str) -> str:
    if abs(scale - 1.0) < SAME:
        return f"A {unit} of odometry is a {unit} {done}."
    if scale == 0.0:
        return f"Odometry says nothing of what was {done}."
    if scale < 0.0:
        return f"Odometry counts with the wrong sign: a {unit} of it is {scale:.3f} {unit}s {done}."
    return f"Odometry counts {abs(1.0 / scale - 1.0):.1%} too {'much' if scale < 1.0 else 'little'} of what was {done}."


def _drift(turn_per_metre: float) -> Finding:
    degrees = float(np.degrees(turn_per_metre))
    if abs(degrees) < LEAST_DRIFT:
        return Finding("turn per metre", "none", "Where odometry says straight on, the robot went straight on.")
    side = "left" if degrees > 0.0 else "right"
    return Finding(
        "turn per metre",
        f"{degrees:.2f}°",
        f"Where odometry says straight on, the robot turned {abs(degrees):.2f}° to the {side} each metre.",
    )


def _lever(lever: float) -> Finding:
    if abs(lever) < LEAST_LEVER:
        return Finding("lever", "none", "The robot's frame lies where the wheels turn it about.")
    where = "ahead of" if lever >= 0.0 else "behind"
    sentence = f"The robot's frame lies {_mm(abs(lever))} {where} the point that the wheels turn it about."
    return Finding("lever", _mm(lever), sentence)


def _lag(lag: float) -> Finding:
    if lag == 0.0:
        return Finding("lag", "none", "Odometry is in step with the laser, or nothing tells otherwise.")
    where = "behind" if lag > 0.0 else "ahead of"
    return Finding("lag", f"{lag:.2f} records", f"Odometry is {where} the scan it is recorded with.")


def _ms(seconds: float, sigma: float) -> str:
    return f"{1000 * seconds:.1f} ± {1000 * sigma:.1f} ms"


def _mm(metres: float) -> str:
    return f"{1000 * metres:.1f} mm"
