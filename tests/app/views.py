"""Small worlds as Views, for tests of what is drawn: a floor of rooms with a curved wall, a scan in it, decisions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.association import Association, Candidate, Relation, Verdict
from bspline_slam.bspline import BSpline, uniform_knots
from bspline_slam.front_end.loop_closure import LoopClosure
from bspline_slam.lab.certainty import sigmas_along
from bspline_slam.lab.stretches import LENGTH, Stretches
from bspline_slam.scan import LaserScan
from bspline_slam.segmentation import EndKind, ScanSegment
from bspline_slam.spline_map import MapSpline, SplineMap
from splinescope.view import FittedSegment, Layer, MapView, ScanView, View

ALL_LAYERS = frozenset(Layer)
SPACING = 0.4  # m between knots
VERDICTS = (Verdict.MATCHED, Verdict.MATCHED, Verdict.EXTENDED, Verdict.NEW, Verdict.GATED, Verdict.IGNORED)


def spline_along(points: Float[np.ndarray, "n 2"]) -> BSpline:
    """A cubic with its control points evenly along a polyline."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    count = max(int(np.ceil(along[-1] / SPACING)) + 3, 4)
    wanted = np.linspace(-0.1, along[-1] + 0.1, count)
    control_points = np.stack([np.interp(wanted, along, points[:, i]) for i in range(2)], axis=1)
    return BSpline(3, uniform_knots(0.0, SPACING, count), control_points)


def room(x: float, y: float, width: float, depth: float) -> list[Float[np.ndarray, "n 2"]]:
    """Walls of a room with a door in its lower side and a bay in its upper one."""
    bay = np.linspace(np.pi, 0.0, 15)
    middle = x + width / 2
    top = np.stack([middle + 0.8 * np.cos(bay), y + depth + 0.8 * np.sin(bay)], axis=1)
    return [
        np.array([[x, y], [x + 0.35 * width, y]]),
        np.array([[x + 0.65 * width, y], [x + width, y]]),
        np.array([[x, y], [x, y + depth]]),
        np.array([[x + width, y], [x + width, y + depth]]),
        np.concatenate([[[x, y + depth]], top, [[x + width, y + depth]]]),
    ]


def floor_map(
    columns: int = 2, rows: int = 1, wobble: float = 0.004, rng: np.random.Generator | None = None
) -> SplineMap:
    """Rooms on a grid, as splines with ids from 0; with `rng` their control points are off by `wobble` (m)."""
    splines: list[MapSpline] = []
    for row in range(rows):
        for column in range(columns):
            for wall in room(5.2 * column, 6.5 * row, 5.0, 4.0):
                curve = spline_along(wall)
                if rng is not None:
                    noise = rng.normal(0.0, wobble, curve.control_points.shape)
                    curve = curve.with_control_points(curve.control_points + noise)
                splines.append(MapSpline(len(splines), curve, curve.domain, born=len(splines), observations=4))
    return SplineMap(tuple(splines))


def scan_of(
    world: SplineMap, pose: Float[np.ndarray, "3"], index: int, rng: np.random.Generator, beams: int = 181
) -> LaserScan:
    """What a laser at `pose` sees of the world, with 1 cm of noise."""
    bearings = np.radians(np.linspace(-90.0, 90.0, beams))
    angle = bearings + pose[2]
    directions = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    near = [s.curve for s in world if np.linalg.norm(s.curve.control_points - pose[:2], axis=1).min() < 12.0]
    hits = np.stack([curve.ray_hits(pose[:2], directions)[0] for curve in near])
    ranges = np.where(np.isnan(hits).all(axis=0), np.inf, np.nanmin(np.where(np.isnan(hits), np.inf, hits), axis=0))
    ranges = ranges + rng.normal(0.0, 0.01, beams)
    return LaserScan(index, 0.1 * index, ranges, bearings, 0.05, 12.0, np.zeros(3))


def segments_of(scan: LaserScan) -> tuple[ScanSegment, ...]:
    """The scan cut where neighbouring beams lie far apart."""
    valid = np.flatnonzero(scan.valid)
    points = scan.points_robot
    jumps = np.flatnonzero(np.linalg.norm(np.diff(points[valid], axis=0), axis=1) > 0.3) + 1
    runs = [run for run in np.split(valid, jumps) if len(run) >= 6]
    kinds = list(EndKind)
    return tuple(
        ScanSegment(scan.index, i, run, points[run], kinds[i % 5], kinds[(i + 2) % 5]) for i, run in enumerate(runs)
    )


def fitted(segment: ScanSegment, rng: np.random.Generator) -> FittedSegment:
    """A rough fit, with a covariance of one to two centimetres."""
    curve = spline_along(segment.points[:: max(len(segment.points) // 5, 1)])
    root = rng.normal(0.0, 0.008, (2 * len(curve.control_points),) * 2)
    return FittedSegment(segment, curve, root @ root.T)


def decision(segment: ScanSegment, world: SplineMap, verdict: Verdict, by: str = "rule") -> Association:
    """A verdict on the whole of a segment, with the nearest splines of the world as candidates."""
    gone = verdict in (Verdict.GATED, Verdict.IGNORED)
    chosen = (segment.index * 3) % len(world)
    candidates = (Candidate(chosen, 0.021, 0.9), Candidate((chosen + 1) % len(world), 0.4, 0.3))
    return Association(
        scan=segment.scan,
        segment=segment.index,
        first=int(segment.beams[0]),
        last=int(segment.beams[-1]),
        verdict=verdict,
        spline=None if gone else chosen,
        distance=0.021,
        gate=0.15,
        candidates=candidates,
        relation=None if gone else Relation.PART,
        by=by,
    )


def scan_view(world: SplineMap, pose: Float[np.ndarray, "3"], index: int, rng: np.random.Generator) -> ScanView:
    """A key scan of the world from `pose` with a decision of every kind."""
    scan = scan_of(world, pose, index, rng)
    segments = segments_of(scan)
    placed = [nearest_spline(world, se2.transform(pose, s.points[len(s.points) // 2])) for s in segments]
    associations = []
    for i, (segment, spline) in enumerate(zip(segments, placed, strict=True)):
        made = decision(segment, world, VERDICTS[i % len(VERDICTS)], "hand" if i == 1 else "rule")
        mine = (Candidate(spline, 0.02, 0.9), *made.candidates[1:])
        associations.append(replace(made, candidates=mine, spline=None if made.spline is None else spline))
    return ScanView(scan, pose, True, False, tuple(fitted(s, rng) for s in segments), tuple(associations))


def nearest_spline(world: SplineMap, point: Float[np.ndarray, "2"]) -> int:
    """The id of the spline nearest to a point."""
    return min(world, key=lambda s: np.linalg.norm(s.curve.control_points - point, axis=1).min()).id


def path_through(columns: int, rows: int, length: int, rng: np.random.Generator) -> Float[np.ndarray, "m 3"]:
    """A drive along the corridors in front of the rooms, a little unsteady."""
    corners = [np.array([-1.0, -1.2])]
    for row in range(rows):
        ends = [np.array([-1.0, 6.5 * row - 1.2]), np.array([5.2 * columns, 6.5 * row - 1.2])]
        corners += ends if row % 2 == 0 else ends[::-1]
    nodes = np.array(corners)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(nodes, axis=0), axis=1))])
    wanted = np.linspace(0.0, along[-1], length)
    xy = np.stack([np.interp(wanted, along, nodes[:, i]) for i in range(2)], axis=1)
    xy += 0.1 * np.stack([np.sin(wanted), np.cos(1.3 * wanted)], axis=1) + rng.normal(0.0, 0.004, xy.shape)
    step = np.gradient(xy, axis=0)
    return np.column_stack([xy, np.arctan2(step[:, 1], step[:, 0])])


def drifted(path: Float[np.ndarray, "m 3"], per_pose: float) -> Float[np.ndarray, "m 3"]:
    """The path as dead reckoning would have it: turned a little further with every pose."""
    turned = per_pose * np.arange(len(path))
    steps = np.einsum("nij,nj->ni", se2.rotation(turned[1:]), np.diff(path[:, :2], axis=0))
    xy = path[0, :2] + np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    return np.column_stack([xy, se2.wrap(path[:, 2] + turned)])


def map_view(rng: np.random.Generator, columns: int = 2, rows: int = 1, length: int = 60) -> MapView:
    """The floor with its paths, covariances of one to three centimetres, and loops of both verdicts."""
    world = floor_map(columns, rows, rng=rng)
    path = path_through(columns, rows, length, rng)
    keys = tuple(range(0, length, max(length // 40, 1)))
    covariances = {}
    for spline in world:
        root = rng.normal(0.0, 0.004, (2 * len(spline.curve.control_points),) * 2)
        covariances[spline.id] = root @ root.T
    loops = tuple(
        LoopClosure(a, b, np.zeros(3), np.eye(3), 0.7, 0.8, i % 3 != 0, "seen again")
        for i, (a, b) in enumerate(zip(keys[:-4:2], keys[4::2], strict=False))
    )
    odometry, truth = drifted(path, 0.6 / length), path + 0.01
    stretches, sigmas = stretches_along(world), sigmas_along(world, covariances)
    measured = (stretches, sigmas, 0.1 * np.arange(length))
    return MapView(world, covariances, path[list(keys)], keys, loops, path, odometry, truth, *measured)


def stretches_along(world: SplineMap) -> Stretches:
    """Curves that get worse and worse along themselves, from 3 to 24 mm, and the first of each not measured."""
    spline, start, end, value = [], [], [], []
    for one in world:
        edges, _ = one.sample(LENGTH)
        spline.append(np.full(len(edges) - 1, one.id))
        start.append(edges[:-1])
        end.append(edges[1:])
        value.append(np.concatenate([[np.nan], np.linspace(0.003, 0.024, len(edges) - 2)]))
    return Stretches(*(np.concatenate(column) for column in (spline, start, end, value)))


def office(rng: np.random.Generator, dark: bool = True) -> View:
    """Two rooms and a scan taken in the first, every layer on."""
    shown = map_view(rng)
    scan = scan_view(shown.map, np.array([2.3, 1.3, 1.2]), 12, rng)
    return View(map=shown, scan=scan, layers=ALL_LAYERS, dark=dark)


def large(rng: np.random.Generator, dark: bool = True) -> View:
    """A map of the size of a whole building: about 400 splines, 2,500 control points, 9,000 poses."""
    shown = map_view(rng, columns=9, rows=9, length=9000)
    scan = scan_view(shown.map, np.array([2.3, 1.3, 1.2]), 12, rng)
    return View(map=shown, scan=scan, layers=ALL_LAYERS - {Layer.ODOMETRY}, dark=dark)
