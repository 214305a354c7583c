"""Spline maps as JSON, there and back; docs/map-format.md describes the file."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from bspline_slam.bspline import BSpline
from bspline_slam.corners import Corner, corners_of
from bspline_slam.errors import GeometryError, LogError
from bspline_slam.spline_map import MapSpline, SplineMap

FORMAT = "splinescope-map"
VERSION = 1
Covariances = Mapping[int, Float[np.ndarray, "d d"]]
"""Covariance of the stacked control points (c_1x, c_1y, c_2x, …) by spline id (m²)."""


def map_to_json(spline_map: SplineMap, covariances: Covariances, path: Path) -> None:
    """Write the map; a spline without a covariance gets null there."""
    head = {
        "format": FORMAT,
        "version": VERSION,
        "frame": "world: right-handed, x and y in the plane of the laser, origin at the first pose",
        "units": {"length": "m", "covariance": "m^2"},
    }
    rows = (_spline_to_dict(spline, covariances.get(spline.id)) for spline in spline_map)
    corners = map(_corner_to_dict, corners_of(spline_map))
    text = f'{json.dumps(head)[:-1]}, "splines": [{_lines(rows)}], "corners": [{_lines(corners)}]}}\n'
    path.write_text(text, encoding="utf-8")


def _lines(rows: Iterable[dict[str, Any]]) -> str:
    """A row a line."""
    return "\n" + ",\n".join(json.dumps(row, separators=(",", ":")) for row in rows) + "\n"


def _corner_to_dict(corner: Corner) -> dict[str, Any]:
    turn = float(f"{corner.turn:.9g}")
    return {"before": corner.before, "after": corner.after, "point": _rounded(corner.point), "turn": turn}


def map_from_json(path: Path) -> tuple[SplineMap, dict[int, Float[np.ndarray, "d d"]]]:
    """Read a map and its covariances; raises LogError when the file is none or newer than this program."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise LogError(path, f"is not a readable map ({error})") from None
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise LogError(path, "is not a map of splines")
    if data.get("version") != VERSION:
        raise LogError(path, f"has version {data.get('version')} of the map format, this program reads {VERSION}")
    try:
        splines = tuple(_spline_from_dict(row) for row in data["splines"])
        covariances = {
            row["id"]: np.array(row["covariance"], dtype=float)
            for row in data["splines"]
            if row["covariance"] is not None
        }
    except (KeyError, TypeError, ValueError, GeometryError) as error:
        raise LogError(path, f"holds a spline that cannot be read: {error}") from None
    return SplineMap(splines), covariances


def _spline_to_dict(spline: MapSpline, covariance: Float[np.ndarray, "d d"] | None) -> dict[str, Any]:
    return {
        "id": spline.id,
        "degree": spline.curve.degree,
        "span": _rounded(np.array(spline.span)),
        "knots": _rounded(spline.curve.knots),
        "control_points": _rounded(spline.curve.control_points),
        "born": spline.born,
        "observations": spline.observations,
        "history": list(spline.history),
        "left_out": float(f"{spline.left_out:.9g}"),
        "covariance": None if covariance is None else _rounded(covariance),
    }


def _rounded(array: Float[np.ndarray, "..."]) -> list[Any]:
    """Nested lists with nine significant digits: far below a micrometre, half the bytes of all seventeen."""
    flat = [float(f"{value:.9g}") for value in array.ravel()]
    return np.array(flat).reshape(array.shape).tolist()


def _spline_from_dict(row: dict[str, Any]) -> MapSpline:
    points = np.array(row["control_points"], dtype=float)
    start, end = row["span"]
    return MapSpline(
        id=row["id"],
        curve=BSpline(row["degree"], np.array(row["knots"], dtype=float), points),
        span=(start, end),
        born=row["born"],
        observations=row["observations"],
        history=tuple(row["history"]),
        left_out=float(row.get("left_out", 0.0)),
    )
