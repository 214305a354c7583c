"""What the scan under the cursor looks like: a ScanView as line work."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.association import Association, Verdict
from bspline_slam.segmentation import EndKind, ScanSegment
from splinescope.palette import GREY, PURPLE, SKY, VERDICT_STYLES, VERMILION, YELLOW, Glyph, LineStyle, Theme
from splinescope.pieces import points_of
from splinescope.scene.curves import sampled
from splinescope.scene.detail import Detail
from splinescope.scene.ellipses import blocks, ellipses
from splinescope.scene.strokes import Strokes, dashed, glyphs, polyline
from splinescope.view import FittedSegment, MapView, ScanView, Selection

MOST_DASHES = 12  # on one ray
GHOST_REACH = 6.0  # m: how far beams without an echo are drawn at least
ROBOT_PIXELS = 11.0
ROBOT_LENGTH = 0.2  # m: half of what it is long

END_GLYPHS = {
    EndKind.EDGE: Glyph.BAR,
    EndKind.OCCLUDED: Glyph.OPEN,
    EndKind.CORNER: Glyph.CORNER,
    EndKind.NO_RETURN: Glyph.CROSS,
    EndKind.FIELD_OF_VIEW: Glyph.FAN,
}


def beams(view: ScanView, theme: Theme, detail: Detail) -> Strokes:
    """Thin rays to what the beams hit. Near the sensor only every other one, every fourth, … so they stay apart."""
    scan = view.scan
    hit = np.flatnonzero(scan.valid)
    rays = _rays(view, hit, scan.ranges[hit], detail)
    return Strokes.of(rays, theme.faint(theme.legible(YELLOW), 0.2))


def no_return_beams(view: ScanView, theme: Theme, detail: Detail) -> Strokes:
    """Rays that came back from nowhere: dashed, a little farther than the farthest hit."""
    scan = view.scan
    free = np.flatnonzero(scan.no_return)
    farthest = 1.1 * float(np.max(scan.ranges[scan.valid], initial=0.0))
    reach = min(max(farthest, GHOST_REACH), scan.range_max)
    rays = _rays(view, free, np.full(len(free), reach), detail, apart=8.0)
    pixel = max(detail.pixel, reach / MOST_DASHES / sum(LineStyle.DASHED.pattern))
    dashes = [dashed(ray, LineStyle.DASHED, pixel) for ray in rays]
    return Strokes.joined(Strokes.of(dash, theme.faint(GREY, 0.35)) for dash in dashes)


def _rays(
    view: ScanView, chosen: Int[np.ndarray, "n"], reach: Float[np.ndarray, "n"], detail: Detail, apart: float = 4.0
) -> Float[np.ndarray, "m 2 2"]:
    """Rays of the chosen beams, each from where its neighbours of the same rank are `apart` pixels away."""
    rank = np.minimum(chosen & -chosen, 32)
    rank[chosen == 0] = 32
    start = apart * detail.pixel / (max(view.scan.resolution, 1e-4) * rank)
    seen = start < reach
    directions = se2.rotate(view.pose, view.scan.directions_robot[chosen[seen]])
    ends = [_sensor(view) + r[seen, None] * directions for r in (start, reach)]
    return np.stack(ends, axis=1)


def segments(view: ScanView, theme: Theme, detail: Detail) -> Strokes:
    """Segments as broad lines: in the hue of the verdict on each stretch of beams, broken where it was turned away."""
    plain = theme.legible(theme.faint(theme.ink, 0.55))
    decisions: dict[int, list[Association]] = {}
    for association in view.associations:
        decisions.setdefault(association.segment, []).append(association)
    parts = []
    for fitted in view.segments:
        segment = fitted.segment
        points = se2.transform(view.pose, segment.points)
        mine = decisions.get(segment.index, [])
        covered = np.zeros(len(points), dtype=bool)
        for association in mine:
            stretch = _stretch(segment, association)
            covered |= stretch
            turned_away = association.verdict in (Verdict.GATED, Verdict.IGNORED)
            style = LineStyle.DASHED if turned_away else LineStyle.SOLID
            line = dashed(points[stretch], style, detail.pixel)
            parts.append(Strokes.of(line, theme.verdict(association.verdict)))
        if not covered.any():
            parts.append(Strokes.of(polyline(points), plain))
    return Strokes.joined(parts)


def fits(view: ScanView, theme: Theme, detail: Detail) -> Strokes:
    """The curves fitted to the segments, as thin lines over them."""
    curves = [f.curve.with_control_points(_placed(f, view)) for f in view.segments if f.curve is not None]
    lines, _ = sampled(curves, [curve.domain for curve in curves], detail)
    return Strokes.of(lines, theme.ink)


def fit_points(view: ScanView, theme: Theme, detail: Detail) -> Strokes:
    """Control points of the fitted curves, small circles."""
    placed = [_placed(f, view) for f in view.segments if f.curve is not None]
    if not placed or not detail.readable:
        return Strokes.none()
    points = np.concatenate(placed)
    return glyphs(Glyph.CIRCLE, points, np.tile(theme.ink, (len(points), 1)), 3.0 * detail.pixel)


def fit_ellipses(view: ScanView, theme: Theme, detail: Detail) -> Strokes:
    """2σ ellipses of the control points of the fits."""
    known = [f for f in view.segments if f.curve is not None and f.covariance is not None]
    if not known or not detail.readable:
        return Strokes.none()
    turn = se2.rotation(float(view.pose[2]))
    covariances = np.concatenate([blocks(f.covariance) for f in known if f.covariance is not None])
    centres = np.concatenate([_placed(f, view) for f in known])
    colours = np.tile(theme.legible(SKY), (len(centres), 1))
    return ellipses(centres, turn @ covariances @ turn.T, colours, detail.pixel, theme.legible(VERMILION))


def ends(view: ScanView, theme: Theme, detail: Detail) -> Strokes:
    """Breakpoints and corners: one glyph per kind of end."""
    if not detail.readable:
        return Strokes.none()
    places: dict[EndKind, list[Float[np.ndarray, "2"]]] = {kind: [] for kind in EndKind}
    for fitted in view.segments:
        points = se2.transform(view.pose, fitted.segment.points)
        places[fitted.segment.start].append(points[0])
        places[fitted.segment.end].append(points[-1])
    hue = theme.legible(YELLOW)
    parts = [
        glyphs(END_GLYPHS[kind], np.array(at), np.tile(hue, (len(at), 1)), 5.0 * detail.pixel)
        for kind, at in places.items()
        if at
    ]
    return Strokes.joined(parts)


def ties(view: ScanView, map_view: MapView | None, theme: Theme, detail: Detail) -> Strokes:
    """Each decision: its glyph beside the stretch it is about, and a line on to the spline in question."""
    if not detail.readable:
        return Strokes.none()
    by_index = {fitted.segment.index: fitted.segment for fitted in view.segments}
    parts = []
    for association in view.associations:
        segment = by_index.get(association.segment)
        if segment is not None and _stretch(segment, association).any():
            parts.append(_tie(view, association, segment, map_view, theme, detail))
    return Strokes.joined(parts)


def _tie(
    view: ScanView,
    association: Association,
    segment: ScanSegment,
    map_view: MapView | None,
    theme: Theme,
    detail: Detail,
) -> Strokes:
    points = se2.transform(view.pose, segment.points[_stretch(segment, association)])
    middle = points[len(points) // 2]
    towards = _sensor(view) - middle
    glyph_at = middle + towards / max(float(np.linalg.norm(towards)), 1e-9) * 18.0 * detail.pixel
    style, hue = VERDICT_STYLES[association.verdict], theme.verdict(association.verdict)
    target = middle
    if (nearest := association.candidates[0].spline if association.candidates else association.spline) is not None:
        wanted = association.spline if association.spline is not None else nearest
        if map_view is not None and wanted in map_view.map:
            curve = map_view.map[wanted].curve
            target = curve(curve.foot_points(middle[None]))[0]
    parts = [
        Strokes.of(dashed(np.stack([glyph_at, middle]), style.line, detail.pixel), hue),
        Strokes.of(dashed(np.stack([middle, target]), style.line, detail.pixel), hue),
        glyphs(style.glyph, glyph_at[None], hue[None], 5.5 * detail.pixel),
    ]
    if association.by == "hand":
        parts.append(glyphs(Glyph.DIAMOND, glyph_at[None], theme.legible(PURPLE)[None], 11.0 * detail.pixel))
    return Strokes.joined(parts)


def robot(view: ScanView, theme: Theme, detail: Detail) -> Strokes:
    """The robot as an arrowhead that never gets small: filled for a key scan, with a warning where it is lost."""
    size = max(ROBOT_PIXELS * detail.pixel, ROBOT_LENGTH)
    outline = size * np.array([[1.1, 0.0], [-0.8, 0.66], [-0.45, 0.0], [-0.8, -0.66], [1.1, 0.0]])
    hue = theme.legible(VERMILION) if view.lost else theme.ink
    lines = [polyline(se2.transform(view.pose, outline))]
    if view.key:
        rings = int(np.clip(0.5 * size / detail.pixel / 1.8, 3, 24))
        lines += [polyline(se2.transform(view.pose, outline * share)) for share in (np.arange(rings) + 0.4) / rings]
    drawn = Strokes.of(np.concatenate(lines), hue)
    if not view.lost:
        return drawn
    above = view.pose[None, :2] + np.array([0.0, 1.2 * size + 12.0 * detail.pixel])
    return Strokes.joined([drawn, glyphs(Glyph.WARNING, above, hue[None], 9.0 * detail.pixel)])


def halo(view: ScanView | None, selection: Selection | None, theme: Theme, detail: Detail) -> Strokes:
    """The selected segment, or pieces, once more, for a broad line beneath."""
    if view is None or selection is None:
        return Strokes.none()
    chosen: list[Float[np.ndarray, "m 2"]] = []
    if selection.kind == "segment":
        segments = (f.segment for f in view.segments if f.segment.index == selection.id)
        chosen = [se2.transform(view.pose, segment.points) for segment in segments]
    elif selection.kind == "pieces" and selection.id == view.scan.index:
        chosen = [points for piece in selection.pieces if len(points := points_of(piece, view)) > 1]
    lines = map(polyline, chosen)
    return Strokes.joined(Strokes.of(line, theme.faint(theme.ink, 0.35)) for line in lines)


def _stretch(segment: ScanSegment, association: Association) -> np.ndarray:
    return (segment.beams >= association.first) & (segment.beams <= association.last)


def _sensor(view: ScanView) -> Float[np.ndarray, "2"]:
    return se2.transform(view.pose, view.scan.pose_robot_sensor[:2])


def _placed(fitted: FittedSegment, view: ScanView) -> Float[np.ndarray, "n 2"]:
    assert fitted.curve is not None
    return se2.transform(view.pose, fitted.curve.control_points)
