"""What the map and the paths look like: a MapView as line work."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from bspline_slam.bspline import BSpline
from bspline_slam.spline_map import MapSpline
from splinescope.grades import UNKNOWN, pieces
from splinescope.palette import COMPARED_HUE, GREEN, GREY, PURPLE, SKY, VERMILION, YELLOW, Glyph, LineStyle, Theme
from splinescope.scene.curves import sampled
from splinescope.scene.detail import Detail
from splinescope.scene.ellipses import blocks, ellipses
from splinescope.scene.paths import simplified
from splinescope.scene.strokes import Strokes, broken, dashed, glyphs, polyline
from splinescope.view import Colouring, MapView, Selection

MOST_ELLIPSES = 120
OUTSIDE = 0.05  # m: what a path may be off outside of the window
HALO = 0.35  # share of the ink in the halo around what is selected


def splines(view: MapView, theme: Theme, detail: Detail) -> Strokes:
    """Every spline of the map, in the colour of its id."""
    chosen = view.map.splines
    segments, owner = sampled([s.curve for s in chosen], [s.span for s in chosen], detail)
    return Strokes(segments, theme.splines([s.id for s in chosen])[owner])


def graded(view: MapView, theme: Theme, detail: Detail, colouring: Colouring, grade: int) -> Strokes:
    """The stretches of curve that have this grade; those of UNKNOWN dotted."""
    curves = {spline.id: spline.curve for spline in view.map}
    chosen = [(curves[number], span) for number, span in pieces(view, colouring, grade) if number in curves]
    segments, _ = sampled([curve for curve, _ in chosen], [span for _, span in chosen], detail)
    if grade == UNKNOWN:
        near = detail.inside(segments[:, 0])
        dots = broken(segments[near], LineStyle.DOTTED, detail.pixel)
        return Strokes.of(np.concatenate([dots, segments[~near]]), theme.spline(0))
    return Strokes.of(segments, theme.graded(grade))


def compared(view: MapView, theme: Theme, detail: Detail) -> Strokes:
    """Splines and path of the result laid over the one shown: all in one hue, the splines dashed, the path dotted."""
    hue = theme.legible(COMPARED_HUE)
    segments, _ = sampled([s.curve for s in view.map], [s.span for s in view.map], detail)
    path = _path(view.estimate, LineStyle.DOTTED, hue, detail)
    return Strokes.joined([path, Strokes.of(broken(segments, LineStyle.DASHED, detail.pixel), hue)])


def control_points(view: MapView, theme: Theme, detail: Detail, selection: Selection | None) -> Strokes:
    """Control points as small squares where they can be told apart, and always those of the selected spline."""
    chosen = _close_or_selected(view.map, detail, selection)
    centres, colours = _points(chosen, theme)
    seen = detail.inside(centres)
    marks = glyphs(Glyph.SQUARE, centres[seen], colours[seen], 3.5 * detail.pixel)
    polygons = [
        Strokes.of(dashed(spline.curve.control_points, LineStyle.DOTTED, detail.pixel), theme.faint(theme.ink, 0.55))
        for spline in chosen
        if _selected(spline, selection)
    ]
    return Strokes.joined([*polygons, marks])


def map_ellipses(view: MapView, theme: Theme, detail: Detail, selection: Selection | None) -> Strokes:
    """2σ ellipses of the control points, of the nearest ones where there are many."""
    chosen = [s for s in _close_or_selected(view.map, detail, selection) if s.id in view.covariances]
    if not chosen:
        return Strokes.none()
    centres, colours = _points(chosen, theme)
    covariances = np.concatenate([blocks(view.covariances[s.id]) for s in chosen])
    order = np.argsort(np.linalg.norm(centres - detail.centre, axis=1))[:MOST_ELLIPSES]
    warning = theme.legible(VERMILION)
    return ellipses(centres[order], covariances[order], colours[order], detail.pixel, warning)


def estimate(view: MapView, theme: Theme, detail: Detail) -> Strokes:
    """The estimated path, solid, with a dot at every key pose where they can be told apart."""
    colour = theme.legible(theme.faint(theme.ink, 0.42))
    line = _path(view.estimate, LineStyle.SOLID, colour, detail)
    if not detail.close:
        return line
    poses = view.key_poses[detail.inside(view.key_poses[:, :2]), :2]
    dots = glyphs(Glyph.DIAMOND, poses, np.tile(colour, (len(poses), 1)), 3.0 * detail.pixel)
    return Strokes.joined([line, dots])


def odometry(view: MapView, theme: Theme, detail: Detail) -> Strokes:
    """Dead reckoning, dashed and quiet: it is mostly wrong."""
    quiet = theme.faint(theme.legible(GREY), 0.6)
    return _path(view.odometry, LineStyle.DASHED, quiet, detail) if view.odometry is not None else NONE


def truth(view: MapView, theme: Theme, detail: Detail) -> Strokes:
    """The true path, dotted."""
    return _path(view.truth, LineStyle.DOTTED, theme.legible(GREEN), detail) if view.truth is not None else NONE


def loop_closures(view: MapView, theme: Theme, detail: Detail) -> Strokes:
    """Ties between poses that saw the same place: whole where accepted, broken in the middle where rejected."""
    where = {scan: pose[:2] for scan, pose in zip(view.key_scans, view.key_poses, strict=True)}
    known = [c for c in view.loop_closures if c.earlier in where and c.scan in where]
    if not known:
        return NONE
    ends = np.array([[where[c.earlier], where[c.scan]] for c in known])
    accepted = np.array([c.accepted for c in known])
    rejected = ends[~accepted]
    step = 0.36 * (rejected[:, 1] - rejected[:, 0])
    halves = [
        np.stack([rejected[:, 0], rejected[:, 0] + step], 1),
        np.stack([rejected[:, 1] - step, rejected[:, 1]], 1),
    ]
    return Strokes.joined(
        [
            Strokes.of(np.concatenate(halves), theme.legible(VERMILION)),
            Strokes.of(ends[accepted], theme.legible(PURPLE)),
        ]
    )


def halo(view: MapView | None, selection: Selection | None, theme: Theme, detail: Detail) -> Strokes:
    """The selected spline once more, for a broad line beneath it."""
    if view is None or selection is None or selection.kind not in ("spline", "control point"):
        return NONE
    chosen = [s for s in view.map if s.id == selection.id]
    segments, _ = sampled([s.curve for s in chosen], [s.span for s in chosen], detail)
    return Strokes.of(segments, theme.faint(theme.ink, HALO))


def pointed_at(view: MapView | None, selection: Selection | None, theme: Theme, detail: Detail) -> Strokes:
    """A ring around the selected control point or key pose, or the selected tie with a ring around both its ends."""
    if view is not None and selection is not None and selection.kind == "closure":
        return _tie(view, selection.id, theme, detail)
    point = None
    if view is not None and selection is not None and selection.kind == "control point":
        curves: Iterable[BSpline] = (s.curve for s in view.map if s.id == selection.id)
        point = next((c.control_points[selection.sub] for c in curves if selection.sub < len(c.control_points)), None)
    if view is not None and selection is not None and selection.kind == "key pose" and selection.id in view.key_scans:
        point = view.key_poses[view.key_scans.index(selection.id), :2]
    if point is None:
        return NONE
    return glyphs(Glyph.CIRCLE, point[None], theme.legible(SKY)[None], 9.0 * detail.pixel)


def ruler(places: Float[np.ndarray, "k 2"], theme: Theme, detail: Detail) -> Strokes:
    """A ring around each picked place, and a line from the first to the second."""
    hue = theme.legible(YELLOW)
    rings = glyphs(Glyph.DIAMOND, places, np.tile(hue, (len(places), 1)), 7.0 * detail.pixel)
    return Strokes.joined([Strokes.of(polyline(places), hue), rings])


NONE = Strokes.none()


def _tie(view: MapView, number: int, theme: Theme, detail: Detail) -> Strokes:
    tied = view.loop_closures[number : number + 1]
    where = dict(zip(view.key_scans, view.key_poses[:, :2], strict=True))
    ends = [where[scan] for closure in tied for scan in (closure.earlier, closure.scan) if scan in where]
    if not ends:
        return NONE
    rings = glyphs(Glyph.CIRCLE, np.array(ends), np.tile(theme.legible(SKY), (len(ends), 1)), 9.0 * detail.pixel)
    return Strokes.joined([loop_closures(replace(view, loop_closures=tied), theme, detail), rings])


def _path(path: Float[np.ndarray, "m 3"], style: LineStyle, colour: np.ndarray, detail: Detail) -> Strokes:
    """A path in its style within the window; outside of it as coarse as an overview, and whole."""
    inside = detail.inside(path[:, :2])
    parts = [np.zeros((0, 2, 2))]
    for run in np.split(np.arange(len(path)), np.flatnonzero(np.diff(inside)) + 1) if len(path) else ():
        reach = path[run[0] : run[-1] + 2, :2]
        if inside[run[0]]:
            parts.append(dashed(simplified(reach, detail.pixel), style, detail.pixel))
        else:
            parts.append(polyline(simplified(reach, max(detail.pixel, OUTSIDE))))
    return Strokes.of(np.concatenate(parts), colour)


def _selected(spline: MapSpline, selection: Selection | None) -> bool:
    return selection is not None and selection.kind in ("spline", "control point") and selection.id == spline.id


def _close_or_selected(splines: Iterable[MapSpline], detail: Detail, selection: Selection | None) -> list[MapSpline]:
    return [s for s in splines if detail.close or _selected(s, selection)]


def _points(splines: list[MapSpline], theme: Theme) -> tuple[Float[np.ndarray, "n 2"], np.ndarray]:
    if not splines:
        return np.zeros((0, 2)), np.zeros((0, 3), dtype=np.uint8)
    counts = [len(s.curve.control_points) for s in splines]
    centres = np.concatenate([s.curve.control_points for s in splines])
    return centres, np.repeat(theme.splines([s.id for s in splines]), counts, axis=0)
