"""The scene: draws a View, and of it only what has changed since the last one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from splinescope.browser.page import Page
from splinescope.browser.values import Bounds
from splinescope.grades import UNKNOWN, WIDTHS, Scale, scale_of
from splinescope.palette import Theme, theme
from splinescope.scene import ghost_layers, map_layers, scan_layers
from splinescope.scene.detail import OVERVIEW, Detail
from splinescope.scene.legend import legend
from splinescope.scene.nodes import LineNode
from splinescope.scene.strokes import Strokes
from splinescope.typeset import typeset
from splinescope.view import GhostView, Layer, MapView, ScanView, Selection, View

Sources = tuple[object, ...]
"""What a node was drawn from: the same objects again, the same picture again."""


@dataclass(frozen=True, slots=True)
class Frame:
    """A View with how it is to be drawn."""

    view: View
    theme: Theme
    detail: Detail


@dataclass(frozen=True, slots=True)
class Drawing:
    """One class of things: the layer that switches it (None: always on), its line width in pixels, what it depends
    on besides theme and detail, and how it is drawn. The order of the drawings is from the floor upwards."""

    name: str
    layer: Layer | None
    width: float
    sources: Callable[[View], Sources]
    draw: Callable[[Frame], Strokes]


def _of_map(draw: Callable[[MapView, Theme, Detail], Strokes]) -> Callable[[Frame], Strokes]:
    return lambda f: Strokes.none() if f.view.map is None else draw(f.view.map, f.theme, f.detail)


def _of_scan(draw: Callable[[ScanView, Theme, Detail], Strokes]) -> Callable[[Frame], Strokes]:
    return lambda f: Strokes.none() if f.view.scan is None else draw(f.view.scan, f.theme, f.detail)


def _of_ghost(draw: Callable[[GhostView, Theme, Detail], Strokes]) -> Callable[[Frame], Strokes]:
    return lambda f: Strokes.none() if f.view.ghost is None else draw(f.view.ghost, f.theme, f.detail)


def _of_compared(f: Frame) -> Strokes:
    return Strokes.none() if f.view.compared is None else map_layers.compared(f.view.compared, f.theme, f.detail)


def _halo(f: Frame) -> Strokes:
    arguments = (f.view.selection, f.theme, f.detail)
    return Strokes.joined([map_layers.halo(f.view.map, *arguments), scan_layers.halo(f.view.scan, *arguments)])


def _scan(view: View) -> Sources:
    return (view.scan,)


def _map(*parts: str) -> Callable[[View], Sources]:
    """These parts of the map: a path that has grown does not draw the splines again."""
    return lambda view: tuple(getattr(view.map, part, None) for part in parts)


def _map_and_selection(*parts: str) -> Callable[[View], Sources]:
    return lambda view: (*_map(*parts)(view), view.selection)


def _splines(f: Frame) -> Strokes:
    """All splines, or while grades are in colour what these leave out."""
    if f.view.map is None:
        return Strokes.none()
    if graded_by(f.view) is not None:
        return map_layers.graded(f.view.map, f.theme, f.detail, f.view.colouring, UNKNOWN)
    return map_layers.splines(f.view.map, f.theme, f.detail)


def graded_by(view: View) -> Scale | None:
    """The scale that curves are coloured by, None where each has its own colour."""
    return scale_of(view.map, view.colouring)


def _coloured(view: View) -> Sources:
    return (view.colouring, *_map("map", "stretches", "sigmas")(view))


def _graded(grade: int, width: float) -> Drawing:
    def draw(f: Frame) -> Strokes:
        if f.view.map is None:
            return Strokes.none()
        return map_layers.graded(f.view.map, f.theme, f.detail, f.view.colouring, grade)

    return Drawing(f"graded {grade}", Layer.SPLINES, width, _coloured, draw)


def _ruler(f: Frame) -> Strokes:
    measured = f.view.measured
    return Strokes.none() if measured is None or not len(measured) else map_layers.ruler(measured, f.theme, f.detail)


DRAWINGS = (
    Drawing("no return", Layer.NO_RETURN, 1.0, _scan, _of_scan(scan_layers.no_return_beams)),
    Drawing("beams", Layer.BEAMS, 1.0, _scan, _of_scan(scan_layers.beams)),
    Drawing("odometry", Layer.ODOMETRY, 1.5, _map("odometry"), _of_map(map_layers.odometry)),
    Drawing("truth", Layer.TRUTH, 1.8, _map("truth"), _of_map(map_layers.truth)),
    Drawing("estimate", Layer.ESTIMATE, 1.4, _map("estimate", "key_poses"), _of_map(map_layers.estimate)),
    Drawing("loops", Layer.LOOPS, 1.4, _map("loop_closures", "key_poses"), _of_map(map_layers.loop_closures)),
    Drawing("halo", None, 11.0, lambda v: (*_map("map")(v), v.scan if _segment(v) else None, v.selection), _halo),
    Drawing("segments", Layer.SEGMENTS, 6.0, _scan, _of_scan(scan_layers.segments)),
    Drawing(
        "ellipses",
        Layer.ELLIPSES,
        1.2,
        _map_and_selection("map", "covariances"),
        lambda f: _with_selection(f, map_layers.map_ellipses),
    ),
    Drawing("splines", Layer.SPLINES, 2.6, _coloured, _splines),
    *(_graded(grade, width) for grade, width in enumerate(WIDTHS)),
    Drawing("compared", Layer.COMPARED, 1.8, lambda v: (v.compared,), _of_compared),
    Drawing(
        "control points",
        Layer.CONTROL_POINTS,
        1.4,
        _map_and_selection("map"),
        lambda f: _with_selection(f, map_layers.control_points),
    ),
    Drawing("fit ellipses", Layer.FIT_ELLIPSES, 1.2, _scan, _of_scan(scan_layers.fit_ellipses)),
    Drawing("fits", Layer.FITS, 1.4, _scan, _of_scan(scan_layers.fits)),
    Drawing("fit points", Layer.FIT_POINTS, 1.4, _scan, _of_scan(scan_layers.fit_points)),
    Drawing("ends", Layer.BREAKS, 1.8, _scan, _of_scan(scan_layers.ends)),
    Drawing(
        "associations",
        Layer.ASSOCIATIONS,
        1.8,
        lambda v: (v.scan, *_map("map")(v)),
        lambda f: (
            Strokes.none() if f.view.scan is None else scan_layers.ties(f.view.scan, f.view.map, f.theme, f.detail)
        ),
    ),
    Drawing(
        "pointed at",
        None,
        2.2,
        _map_and_selection("map", "key_poses", "loop_closures"),
        lambda f: map_layers.pointed_at(f.view.map, f.view.selection, f.theme, f.detail),
    ),
    Drawing("ruler", None, 2.0, lambda v: (None if v.measured is None else tuple(v.measured.ravel()),), _ruler),
    Drawing("ghost", None, 2.2, lambda v: (v.ghost,), _of_ghost(ghost_layers.changed)),
    Drawing("ghost scan", None, 2.6, lambda v: (v.ghost,), _of_ghost(ghost_layers.scan)),
    Drawing("moves", None, 1.6, lambda v: (v.ghost,), _of_ghost(ghost_layers.moves)),
    Drawing("by hand", None, 2.0, lambda v: (v.ghost,), _of_ghost(ghost_layers.by_hand)),
    Drawing("robot", None, 2.4, _scan, _of_scan(scan_layers.robot)),
)


def _segment(view: View) -> bool:
    return view.selection is not None and view.selection.kind in ("segment", "pieces")


def _with_selection(f: Frame, draw: Callable[..., Strokes]) -> Strokes:
    return Strokes.none() if f.view.map is None else draw(f.view.map, f.theme, f.detail, f.view.selection)


FROM_NEAR_ON_SCAN = {
    Layer.FIT_POINTS: "control points",
    Layer.FIT_ELLIPSES: "ellipses",
    Layer.BREAKS: "breakpoints",
}
FROM_NEAR_ON_MAP = {Layer.CONTROL_POINTS: "map control points", Layer.ELLIPSES: "map ellipses"}
FROM_NEAR = FROM_NEAR_ON_SCAN | FROM_NEAR_ON_MAP


class Scene:
    """Holds the nodes of one page. Call `draw` whenever the View has changed, or when `stale` says that somebody
    zoomed or panned so far that the picture should be made finer, coarser or elsewhere."""

    def __init__(self, page: Page) -> None:
        self.page = page
        server = page.server
        self._nodes = {d.name: LineNode(server, d.name, i + 1, d.width) for i, d in enumerate(DRAWINGS)}
        self._drawn: dict[str, Sources] = {}
        self._detail = OVERVIEW
        self._legend_of: tuple[Theme, Scale | None] | None = None
        self._dark: bool | None = None
        self._told: dict[str, object] = {}

    @property
    def stale(self) -> bool:
        """Whether the view has moved beyond what the last drawing was made for."""
        return self._wanted_detail() != self._detail

    @property
    def segment_counts(self) -> dict[str, int]:
        """How many line segments each node shows just now."""
        return {name: len(node) for name, node in self._nodes.items()}

    def draw(self, view: View) -> None:
        """Make every page show this View; what it shares with the last one is not sent again."""
        self._detail = self._wanted_detail()
        scale = graded_by(view)
        frame = Frame(view, theme(view.dark, view.comparing, scale is not None), self._detail)
        if (frame.theme, scale) != self._legend_of:
            self._legend_of = (frame.theme, scale)
            self.page.send("legend", legend(frame.theme, scale))
        if view.dark != self._dark:
            self._dark = view.dark
            self.page.set_dark(view.dark)
        self._tell("grid", Layer.GRID in view.layers)
        self._tell("hint", typeset(hint(view, self._detail)))
        with self.page.server.atomic():
            for drawing in DRAWINGS:
                self._update(drawing, frame)

    def _tell(self, topic: str, value: object) -> None:
        if topic not in self._told or self._told[topic] != value:
            self._told[topic] = value
            self.page.send(topic, value)

    def _update(self, drawing: Drawing, frame: Frame) -> None:
        node = self._nodes[drawing.name]
        if drawing.layer is not None and drawing.layer not in frame.view.layers:
            node.hide()
            self._drawn.pop(drawing.name, None)
            return
        sources = (frame.theme, frame.detail, *drawing.sources(frame.view))
        before = self._drawn.get(drawing.name)
        if before is None or not _same(before, sources):
            node.show(drawing.draw(frame))
            self._drawn[drawing.name] = sources

    def _wanted_detail(self) -> Detail:
        viewport = self.page.viewport
        return OVERVIEW if viewport is None else Detail.of(viewport)


def hint(view: View, detail: Detail) -> str:
    """What a person is asked, else what is switched on but too small to be drawn at this scale; empty when nothing
    is."""
    if view.asks:
        return view.asks
    small = [layer for layer in FROM_NEAR_ON_SCAN if view.scan is not None and not detail.readable]
    small += [layer for layer in FROM_NEAR_ON_MAP if view.map is not None and not detail.close]
    names = [FROM_NEAR[layer] for layer in small if layer in view.layers]
    return f"Zoom in to see {', '.join(names)}" if names else ""


def _same(before: Sources, now: Sources) -> bool:
    """Small values count by what they hold, large ones by identity."""
    pairs = zip(before, now, strict=True)
    return all(a is b or (isinstance(a, (Detail, Selection, tuple)) and a == b) for a, b in pairs)


def bounds_of(view: View) -> Bounds | None:
    """The rectangle that holds the map, the path and the scan of a View; None when it holds nothing."""
    points = [np.zeros((0, 2))]
    if view.map is not None:
        points += [spline.curve.control_points for spline in view.map.map]
        points.append(view.map.estimate[:, :2])
    if view.scan is not None:
        points.append(view.scan.pose[None, :2])
    together = np.concatenate(points)
    together = together[np.isfinite(together).all(axis=1)]
    if len(together) == 0:
        return None
    low, high = together.min(axis=0), together.max(axis=0)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])
