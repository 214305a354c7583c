"""Figs 5 to 7: full, part or extension, decided from the bearings of the ends; a beam that misses is turned."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.bspline import BSpline
from bspline_slam.export import figure as fig
from bspline_slam.lab.reproduction import sight
from bspline_slam.lab.reproduction.reproduced import NOT_GIVEN, Reproduced, Row, write_data
from bspline_slam.relation import EndComparison, Relation, RelationConfig, SplineRelation, extended, relate

if TYPE_CHECKING:
    from matplotlib.axes import Axes

RUNS = 100
SEED = 6
CONFIG = RelationConfig()
KNOWN = (0.25, 0.7)
"""The stretch of the reference spline (its own parameter) that is on the map so far, the "full spline"."""
CASES = {
    "full": ((0.25, 0.7), Relation.FULL),
    "part": ((0.35, 0.6), Relation.PART),
    "extension": ((0.12, 0.85), Relation.EXTENSION),
    "part and extension": ((0.4, 0.9), Relation.EXTENSION),
}
"""Each stretch that is seen anew, and what it is to the full spline."""


@dataclass(frozen=True, eq=False, slots=True)
class Sighting:
    """The full spline, new data (both in the sensor's frame), the decision, and what becomes of the full spline."""

    full_spline: BSpline
    points: Float[np.ndarray, "m 2"]
    decision: SplineRelation
    result: BSpline


def seen_stretch(
    pose: Float[np.ndarray, "3"], stretch: tuple[float, float], rng: np.random.Generator | None
) -> Float[np.ndarray, "m 2"]:
    """The part of a scan of the reference spline that lies on a stretch of it (robot frame); noisy with `rng`."""
    exact = sight.scan_curve(sight.REFERENCE, pose, sight.COARSE)
    points = sight.scan_curve(sight.REFERENCE, pose, sight.COARSE, sight.RANGE_NOISE, rng)
    t = sight.REFERENCE.foot_points(se2.transform(pose, exact))
    return points[(t >= stretch[0]) & (t <= stretch[1])]


def sighting(stretch: tuple[float, float], rng: np.random.Generator) -> Sighting:
    """The stretch KNOWN mapped from the first place, then `stretch` seen from the second one."""
    known = sight.observe(seen_stretch(sight.FIRST_POSE, KNOWN, rng)).curve
    full_spline = known.moved(se2.between(sight.SECOND_POSE, sight.FIRST_POSE))
    points = seen_stretch(sight.SECOND_POSE, stretch, rng)
    decision = relate(full_spline, points, CONFIG)
    grown = decision.relation is Relation.EXTENSION
    result = extended(full_spline, points, decision, sight.CONTROL_POINTS, sight.FITTING) if grown else full_spline
    return Sighting(full_spline, points, decision, result)


def right_decisions(runs: int, rng: np.random.Generator) -> dict[str, float]:
    """The share of noisy sightings of each case that is decided as it was made."""
    return {
        name: sum(sighting(stretch, rng).decision.relation is expected for _ in range(runs)) / runs
        for name, (stretch, expected) in CASES.items()
    }


def reproduce(out: Path, runs: int = RUNS) -> Reproduced:
    """Draw the angles, each case and the turned beams; count how often noise spoils a decision."""
    rng = np.random.default_rng(SEED)
    shown = {name: sighting(stretch, rng) for name, (stretch, _) in CASES.items()}
    both = shown["part and extension"]
    files = fig.draw("Fig. 5 · Bearings of the ends", [lambda axes: _angles(axes, both)], out / "figure_5", height=4.8)
    files += fig.draw(
        "Fig. 6 · What new data are to the full spline",
        [lambda axes, name=name, one=one: _case(axes, name, one) for name, one in shown.items()],
        out / "figure_6",
    )
    files += fig.draw("Fig. 7 · A beam that misses is turned", [lambda axes: _turned(axes, both)], out / "figure_7")
    right = right_decisions(runs, rng)
    data = {
        "seed": SEED,
        "runs": runs,
        "threshold_deg": np.degrees(CONFIG.threshold),
        "resolution_deg": np.degrees(CONFIG.resolution),
        "cases": {name: _as_data(one) for name, one in shown.items()},
        "decided_right": right,
    }
    row = "6", f"decided right, threshold {np.degrees(CONFIG.threshold):g}° ({runs} noisy scans each)"
    rows = [Row(*row, NOT_GIVEN, " · ".join(f"{name} {share:.0%}" for name, share in right.items()))]
    turns = both.decision.start.turns
    rows.append(Row("7", f"turns of {np.degrees(CONFIG.resolution):g}° until the beam hits", NOT_GIVEN, str(turns)))
    return Reproduced(tuple(rows), (*files, write_data(out / "figure_5_to_7", data)))


def _as_data(one: Sighting) -> dict[str, object]:
    decision = one.decision
    return {
        "relation": decision.relation.value,
        "span": decision.span,
        **{
            name: {
                "relation": end.relation.value,
                "data_bearing_deg": np.degrees(end.data_bearing),
                "spline_bearing_deg": np.degrees(end.spline_bearing),
                "turns": end.turns,
            }
            for name, end in (("start", decision.start), ("end", decision.end))
        },
        "full_spline": one.full_spline.control_points,
        "result": one.result.control_points,
        "points": one.points,
    }


def _both(axes: Axes, one: Sighting) -> None:
    """Full spline and data, robot upright."""
    fig.line(axes, _upright(one.full_spline.sample(0.02)[1]), fig.BLUE, "full spline", linewidth=2.2)
    fig.dots(axes, _upright(one.points), fig.RED, "new data", markersize=2.2)
    fig.robot(axes, _UPRIGHT, fig.INK)


_UPRIGHT = np.array([0.0, 0.0, np.pi / 2])


def _upright(points: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "n 2"]:
    return se2.transform(_UPRIGHT, points)


def _ends(one: Sighting) -> Float[np.ndarray, "2 2"]:
    return one.full_spline(np.array(one.full_spline.domain))


def _angles(axes: Axes, one: Sighting) -> None:
    fig.to_scale(axes, "Ends of the data (red) and of the full spline (blue)")
    fig.rays(axes, np.zeros(2), _upright(one.points[[0, -1]]), fig.RED, linewidth=1.2)
    fig.rays(axes, np.zeros(2), _upright(_ends(one)), fig.BLUE, linewidth=1.2)
    _both(axes, one)
    names = {"d_s": one.points[0], "d_e": one.points[-1], "s_s": _ends(one)[0], "s_e": _ends(one)[1]}
    for name, point in names.items():
        x, y = _upright(point[None] * 1.06)[0]
        axes.text(x, y, f"${name}$", ha="center", va="center")
    fig.legend(axes)


def _case(axes: Axes, name: str, one: Sighting) -> None:
    start, end = one.decision.start, one.decision.end
    fig.to_scale(axes, f"{name.capitalize()}: start {start.relation.value}, end {end.relation.value}")
    fig.rays(axes, np.zeros(2), _upright(one.points[[0, -1]]), fig.RED, linewidth=0.9)
    fig.rays(axes, np.zeros(2), _upright(_ends(one)), fig.BLUE, linewidth=0.9)
    if one.decision.relation is Relation.EXTENSION:
        fig.line(axes, _upright(one.result.sample(0.02)[1]), fig.GREEN, "extended full spline", linewidth=5, alpha=0.35)
    _both(axes, one)
    fig.dots(axes, _upright(np.stack([start.hit, end.hit])), fig.ORANGE, "traced ends", markersize=6)
    fig.legend(axes, 4)


def _turned(axes: Axes, one: Sighting) -> None:
    start: EndComparison = one.decision.start
    fig.to_scale(axes, f"Turned {start.turns} × {np.degrees(CONFIG.resolution):g}° to the common range")
    bearings = start.data_bearing + CONFIG.resolution * np.arange(start.turns)
    reach = np.linalg.norm(one.points[0])
    beams = reach * np.stack([np.cos(bearings), np.sin(bearings)], -1)
    fig.rays(axes, np.zeros(2), _upright(beams), fig.GREY)
    fig.rays(axes, np.zeros(2), _upright(start.hit[None]), fig.ORANGE, linewidth=1.6)
    _both(axes, one)
    fig.dots(axes, _upright(start.hit[None]), fig.ORANGE, "first beam that hits", markersize=7)
    fig.legend(axes)
