"""A map on trial: its curves fitted to every other beam, and held against the beams that they never saw."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from bspline_slam.adjustment.spline_graph import build_graph
from bspline_slam.backends import solve_control_points
from bspline_slam.lab.crispness import Crispness, crispness, nearest_curves
from bspline_slam.lab.wall_beams import WallBeams
from bspline_slam.sights import KeyObservations, Sights
from bspline_slam.slam_config import SlamConfig, model_of
from bspline_slam.spline_map import SplineMap


def held_out(beams: WallBeams, splines: SplineMap, config: SlamConfig) -> Crispness:
    """Poses and knots as they are, control points from the even beams, crispness of the odd ones."""
    odd = beams.beam % 2 == 1
    return crispness(beams.part(odd), refitted(beams.part(~odd), splines, config))


def refitted(beams: WallBeams, splines: SplineMap, config: SlamConfig) -> SplineMap:
    """The map with control points from these beams alone, each given to its nearest curve; poses and knots stay.

    Curves that no beam reaches are left out.
    """
    sights, ids = nearest_sights(beams, splines), np.array([spline.id for spline in splines])
    keys = [KeyObservations(int(scan), (), (), 1, np.zeros(2)) for scan in beams.scans]
    places = np.arange(len(splines))
    for gate in config.adjustment.gates:
        graph = build_graph(keys, beams.poses, splines, (), sights, config.adjustment, model_of(config), gate)
        control_points = solve_control_points(graph, beams.poses)
        places, fitted = np.searchsorted(ids, graph.spline_ids), list(splines.splines)
        for place, (a, b) in zip(places, pairwise(graph.spline_first), strict=True):
            curve = fitted[place].curve.with_control_points(control_points[a:b])
            fitted[place] = replace(fitted[place], curve=curve)
        splines = SplineMap(tuple(fitted))
    return SplineMap(tuple(splines.splines[place] for place in places))


def nearest_sights(beams: WallBeams, splines: SplineMap) -> Sights:
    """Every beam given to its nearest curve; one piece for each scan and curve."""
    _, curve = nearest_curves(beams, splines)
    order = np.lexsort((beams.beam, beams.pose, curve))
    order = order[curve[order] >= 0]
    curve, pose = curve[order], beams.pose[order]
    piece = np.cumsum((np.diff(curve, prepend=-1) != 0) | (np.diff(pose, prepend=-1) != 0)) - 1
    columns = (beams.beam[order], beams.points[order], beams.directions[order], beams.ranges[order])
    return Sights(curve, pose, piece, *columns)
