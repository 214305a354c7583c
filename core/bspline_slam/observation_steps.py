"""The chord-length observation of one segment, step by step (paper, eqs 4–15 and section 4): what figures and the page
show of it.

All in the frame of the sensor.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.bspline import BSpline, clamped_knots
from bspline_slam.fitting import FittingConfig, chord_length_parameters, cumulated_chords, fit_chord_length
from bspline_slam.observation import ChordLengthNoise, chord_length
from bspline_slam.relation import RelationConfig, SplineRelation, relate

NOTHING = 1e-12
"""A variance (m²) that adds nothing but keeps a covariance regular."""
LARGEST_CONDITION = 30.0
"""Condition number of the basis matrix above which points do not determine all control points."""


@dataclass(frozen=True, eq=False, slots=True)
class ObservedSpline:
    """Control points seen from the robot and their covariance P = P_s + P_t1 + P_t2 (paper, eq. 15), in one frame."""

    curve: BSpline
    covariance: Float[np.ndarray, "d d"]

    @property
    def blocks(self) -> Float[np.ndarray, "n 2 2"]:
        """Covariance of each control point."""
        at = np.arange(len(self.curve.control_points))
        return self.covariance.reshape(len(at), 2, len(at), 2)[at, :, at]

    def seen_from(self, pose: Float[np.ndarray, "3"]) -> ObservedSpline:
        """The same in the frame that `pose` is given in, the pose taken as certain."""
        turn = np.kron(np.eye(len(self.curve.control_points)), se2.rotation(pose[2]))
        curve = self.curve.moved(pose)
        return ObservedSpline(curve, turn @ self.covariance @ turn.T)


@dataclass(frozen=True, eq=False, slots=True)
class CovarianceTerms:
    """What the covariance of each control point is made of (m²): the noise of the beams (P_s, eqs 11–12), the
    resolution of the sensor (P_t1, eq. 13) and the error of taking chords for arcs (P_t2, eq. 14)."""

    noise: Float[np.ndarray, "n 2 2"]
    resolution: Float[np.ndarray, "n 2 2"]
    chord_error: Float[np.ndarray, "n 2 2"]

    @property
    def total(self) -> Float[np.ndarray, "n 2 2"]:
        return self.noise + self.resolution + self.chord_error


@dataclass(frozen=True, eq=False, slots=True)
class ObservationSteps:
    """A segment on its way to control points.

    `lengths` are the cumulated chords (m), `parameters` their shares of the whole (eqs 8–10), `basis` has a row for
    each point and a column for each control point (eq. 7), `curve` is the least-squares fit (eq. 6), `noise` what the
    terms were made with.
    """

    points: Float[np.ndarray, "m 2"]
    lengths: Float[np.ndarray, "m"]
    parameters: Float[np.ndarray, "m"]
    basis: Float[np.ndarray, "m n"]
    curve: BSpline
    terms: CovarianceTerms
    noise: ChordLengthNoise

    @property
    def rms(self) -> float:
        """Root mean square of what the fit leaves between each point and the curve at its parameter (m)."""
        off = self.curve(self.parameters) - self.points
        return float(np.sqrt(np.mean(np.sum(off**2, axis=1))))


@dataclass(frozen=True, eq=False, slots=True)
class ObservedRelation:
    """Data held against the full spline they were given to, both as the sensor sees them, and the decision."""

    full_spline: BSpline
    points: Float[np.ndarray, "m 2"]
    config: RelationConfig
    decision: SplineRelation


def observe_spline(
    points: Float[np.ndarray, "m 2"], frame: BSpline, fitting: FittingConfig, noise: ChordLengthNoise
) -> ObservedSpline:
    """Ordered points as an observation of all control points of a curve with the knots of `frame`."""
    seen = chord_length(frame, chord_length_parameters(points), points, fitting, noise)
    control_points = np.linalg.solve(seen.A, seen.b).reshape(-1, 2)
    return ObservedSpline(frame.with_control_points(control_points), np.linalg.inv(seen.A.T @ seen.A))


def covariance_terms(
    points: Float[np.ndarray, "m 2"], frame: BSpline, fitting: FittingConfig, noise: ChordLengthNoise
) -> CovarianceTerms:
    """The terms of the covariance apart: each is what the observation's covariance grows by when it comes in."""
    none = replace(noise, resolution=NOTHING, cons=0.0)
    beams, resolved, whole = (
        observe_spline(points, frame, fitting, terms).blocks for terms in (none, replace(noise, cons=0.0), noise)
    )
    return CovarianceTerms(beams, resolved - beams, whole - resolved)


def observation_steps(
    points: Float[np.ndarray, "m 2"],
    fitting: FittingConfig | None = None,
    noise: ChordLengthNoise | None = None,
    control_points: int | None = None,
) -> ObservationSteps:
    """Every step from the points of a segment, in order, to control points and their covariance.

    The curve is clamped, with so many control points, or (None) one for each knot spacing of its length, as far as the
    points determine them.
    Raises GeometryError with fewer than two distinct points.
    """
    fitting, noise = fitting or FittingConfig(), noise or ChordLengthNoise()
    t = chord_length_parameters(points)
    wanted = control_points or len(fit_chord_length(points, fitting).curve.control_points)
    frame = determined_frame(t, wanted, fitting.degree)
    apart = replace(noise, unseen=0.0)
    observed = observe_spline(points, frame, fitting, apart)
    terms = covariance_terms(points, frame, fitting, apart)
    return ObservationSteps(points, cumulated_chords(points), t, frame.basis(t), observed.curve, terms, noise)


def determined_frame(t: Float[np.ndarray, "m"], wanted: int, degree: int) -> BSpline:
    """A clamped curve without shape, of as many control points as wanted or as data at these parameters determine."""
    count = max(min(wanted, len(t)), degree + 1)
    frame = BSpline(degree, clamped_knots(count, degree), np.zeros((count, 2)))
    if count == degree + 1 or np.linalg.cond(frame.basis(t)) <= LARGEST_CONDITION:
        return frame
    return determined_frame(t, count - 1, degree)


def observed_relation(
    full_spline: BSpline, points: Float[np.ndarray, "m 2"], config: RelationConfig
) -> ObservedRelation:
    """Full, part or extension (paper, section 4); a full spline that runs the other way is turned first.

    Raises GeometryError when the data pass the full spline without a beam in common.
    """
    first, last = full_spline.foot_points(points[[0, -1]])
    curve = full_spline if first <= last else full_spline.reversed()
    return ObservedRelation(curve, points, config, relate(curve, points, config))
