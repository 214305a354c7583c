"""The ruler: two things are picked, one after the other, and the estimator says how far apart they are."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from bspline_slam.measuring import Measurement, Picked, PickedControlPoint, PickedPlace, PickedPose
from splinescope.view import MapView, ScanView, Selection


@dataclass(frozen=True, slots=True)
class Ruler:
    """What is picked so far, the job that measures it, and what that found: a measurement, or why there is none."""

    first: Picked | None = None
    second: Picked | None = None
    job: int | None = None
    found: Measurement | str | None = None

    @property
    def picked(self) -> tuple[Picked, ...]:
        """What is picked, in its order."""
        return tuple(each for each in (self.first, self.second) if each is not None)

    def picking(self, picked: Picked) -> Ruler:
        """One more thing; after two of them the first of another pair."""
        if self.first is None or self.second is not None:
            return Ruler(picked)
        return replace(self, second=picked)


def picked_from(
    selection: Selection | None,
    scan: ScanView | None,
    world: MapView | None,
    point: Float[np.ndarray, "2"] | None = None,
) -> Picked | None:
    """The thing that a selection means: where `point` is given, the nearest place of a curve, else its middle.

    A segment stands for the spline that it was given to. None where it is nothing to measure from.
    """
    if selection is None or world is None:
        return None
    match selection:
        case Selection("key pose", id=number):
            return PickedPose(number) if number in world.key_scans else None
        case Selection("control point", id=number, sub=sub):
            return PickedControlPoint(number, sub) if number in world.map else None
        case Selection("spline", id=number):
            return _place(world, number, point)
        case Selection("segment", id=number) if scan is not None:
            given = (a.spline for a in scan.associations if a.segment == number and a.spline is not None)
            spline = next(given, None)
            return None if spline is None else _place(world, spline, point)
    return None


def _place(world: MapView, number: int, point: Float[np.ndarray, "2"] | None) -> Picked | None:
    if number not in world.map:
        return None
    spline = world.map[number]
    t = 0.5 * sum(spline.span) if point is None else float(spline.curve.foot_points(point[None])[0])
    return PickedPlace(number, float(np.clip(t, *spline.span)))


def places(ruler: Ruler, world: MapView) -> Float[np.ndarray, "k 2"]:
    """Where the picked things lie in a map (m); those that are gone from it are left out."""
    found = [place for each in ruler.picked if (place := _where(each, world)) is not None]
    return np.array(found).reshape(-1, 2)


def _where(picked: Picked, world: MapView) -> Float[np.ndarray, "2"] | None:
    match picked:
        case PickedPose(scan=scan) if scan in world.key_scans:
            return world.key_poses[world.key_scans.index(scan), :2]
        case PickedPlace(spline=spline, t=t) if spline in world.map:
            return world.map[spline].curve(np.array([t]))[0]
        case PickedControlPoint(spline=spline, number=number) if spline in world.map:
            points = world.map[spline].curve.control_points
            return points[number] if number < len(points) else None
    return None


def in_words(picked: Picked) -> str:
    """A picked thing, named."""
    match picked:
        case PickedPose(scan=scan):
            return f"robot at key scan {scan:,}"
        case PickedPlace(spline=spline):
            return f"place on spline {spline}"
        case PickedControlPoint(spline=spline, number=number):
            return f"control point {number} of spline {spline}"
