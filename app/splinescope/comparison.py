"""Two results side by side: their figures, and what lies between them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bspline_slam import se2
from splinescope.result import Result


@dataclass(frozen=True, slots=True)
class PoseDifference:
    """The scan whose two poses lie farthest apart: how far (m), and turned by how much (rad)."""

    scan: int
    distance: float
    angle: float


def largest_pose_difference(a: Result, b: Result) -> PoseDifference | None:
    """Where two trajectories of one log, which begin at the same pose, differ most; None without a common scan."""
    count = min(len(a.snapshot.poses), len(b.snapshot.poses))
    if not count:
        return None
    one, other = a.snapshot.poses[:count], b.snapshot.poses[:count]
    apart = np.linalg.norm(one[:, :2] - other[:, :2], axis=1)
    scan = int(apart.argmax())
    return PoseDifference(scan, float(apart[scan]), abs(float(se2.wrap(one[scan, 2] - other[scan, 2]))))


@dataclass(frozen=True, slots=True)
class Figure:
    """A quantity of a result: its name, how it is read off (None: unknown), how it and a difference are written."""

    name: str
    of: Callable[[Result], float | None]
    write: Callable[[float], str]


def _of_solution(read: Callable[..., float | None]) -> Callable[[Result], float | None]:
    return lambda result: None if result.solution is None else read(result.solution)


def _millimetres(metres: float) -> str:
    return f"{1000 * metres:.1f} mm"


FIGURES = (
    Figure("ATE, RMS", _of_solution(lambda s: None if s.ate is None else s.ate.rms), _millimetres),
    Figure("ATE, largest", _of_solution(lambda s: None if s.ate is None else s.ate.maximum), _millimetres),
    Figure("pose NEES / 3", lambda r: r.anees, "{:.2f}".format),
    Figure("χ² / dof", _of_solution(lambda s: s.chi2_per_dof), "{:.3f}".format),
    Figure("splines", lambda r: len(r.snapshot.map), "{:,.0f}".format),
    Figure("control points", lambda r: r.snapshot.map.control_point_count, "{:,.0f}".format),
    Figure("key scans", lambda r: len(r.snapshot.key_scans), "{:,.0f}".format),
    Figure("time", _of_solution(lambda s: s.seconds), "{:.1f} s".format),
)


def choices(result: Result) -> tuple[tuple[str, str], ...]:
    """How a result was made: names and words."""
    recipe = result.recipe
    made = "whole log" if result.origin is None else f"result {result.origin.number} again"
    if result.stopped_after is not None:
        made = f"{result.stopped_after:,} scans"
    return (
        ("estimator", recipe.back_end),
        ("model", recipe.model),
        ("order", str(recipe.order)),
        ("knots", recipe.knots),
        ("made from", made),
    )


def figures(result: Result) -> tuple[str, ...]:
    """All figures of one result, in the order of FIGURES."""
    values = (figure.of(result) for figure in FIGURES)
    return tuple(_written(figure, value) for figure, value in zip(FIGURES, values, strict=True))


def differences(a: Result, b: Result) -> tuple[str, ...]:
    """What `a` has more of each figure than `b`, with its sign; empty where one of the two is unknown."""
    pairs = ((figure, figure.of(a), figure.of(b)) for figure in FIGURES)
    return tuple("" if x is None or y is None else _signed(figure, x - y) for figure, x, y in pairs)


def _written(figure: Figure, value: float | None) -> str:
    return "–" if value is None or not np.isfinite(value) else figure.write(value)


def _signed(figure: Figure, difference: float) -> str:
    text = _written(figure, abs(difference))
    return text if text == "–" or text == figure.write(0.0) else ("+" if difference > 0 else "−") + text
