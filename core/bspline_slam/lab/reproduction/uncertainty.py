"""Fig. 4: noisy scans, their control points with 2σ ellipses, and how often an ellipse holds the truth."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.export import figure as fig
from bspline_slam.lab.reproduction import sight
from bspline_slam.lab.reproduction.reproduced import NOT_GIVEN, Reproduced, Row, write_data
from bspline_slam.observation import ChordLengthNoise
from bspline_slam.observation_steps import NOTHING, ObservedSpline

if TYPE_CHECKING:
    from matplotlib.axes import Axes

RUNS = 500
SEED = 4
MODELS = {
    "P_s": ChordLengthNoise(NOTHING, 0.0),
    "P_s + P_t1": ChordLengthNoise(sight.TERMS.resolution, 0.0),
    "P_s + P_t1 + P_t2": sight.TERMS,
}
INSIDE_2_SIGMA = 1.0 - float(np.exp(-2.0))
"""Share of a Gaussian in the plane inside its 2σ ellipse."""


@dataclass(frozen=True, eq=False, slots=True)
class Coverage:
    """Over many scans from one place: the share of 2σ ellipses that hold the true control point, per control point."""

    runs: int
    by_model: dict[str, Float[np.ndarray, "n"]]


def truth() -> Float[np.ndarray, "n 2"]:
    """The paper's "ground truth": control points of the noise-free scan at 0.1° (robot frame)."""
    fine = sight.scan_curve(sight.REFERENCE, sight.FIRST_POSE, sight.FINE)
    return sight.observe(fine).curve.control_points


def noisy_scan(rng: np.random.Generator) -> Float[np.ndarray, "m 2"]:
    """A scan at 0.5° with 12 mm of noise (robot frame)."""
    return sight.scan_curve(sight.REFERENCE, sight.FIRST_POSE, sight.COARSE, sight.RANGE_NOISE, rng)


def coverage(runs: int, rng: np.random.Generator) -> Coverage:
    """Draw `runs` scans and look which ellipses hold the truth."""
    true = truth()
    inside = {name: np.zeros(len(true)) for name in MODELS}
    for _ in range(runs):
        points = noisy_scan(rng)
        for name, terms in MODELS.items():
            seen = sight.observe(points, terms)
            off = seen.curve.control_points - true
            squared = np.einsum("ni,nij,nj->n", off, np.linalg.inv(seen.blocks), off)
            inside[name] += squared <= 4.0
    return Coverage(runs, {name: counts / runs for name, counts in inside.items()})


def reproduce(out: Path, runs: int = RUNS) -> Reproduced:
    """Draw one noisy scan with its ellipses, and the coverage over many."""
    rng = np.random.default_rng(SEED)
    points, true = noisy_scan(rng), truth()
    seen, covered = sight.observe(points), coverage(runs, rng)
    stem, pose = out / "figure_4", sight.FIRST_POSE
    files = fig.draw(
        "Fig. 4 · Control points from noisy scans",
        [
            lambda axes: _scan(axes, se2.transform(pose, points)),
            lambda axes: _ellipses(axes, seen.seen_from(pose), se2.transform(pose, true)),
            lambda axes: _close_up(axes, seen.seen_from(pose), se2.transform(pose, true)),
            lambda axes: _coverage(axes, covered),
        ],
        stem,
    )
    data = {
        "runs": runs,
        "seed": SEED,
        "range_noise_m": sight.RANGE_NOISE,
        "resolution_deg": np.degrees(sight.COARSE),
        "R_res_m2": sight.TERMS.resolution,
        "cons_m2": sight.TERMS.cons,
        "points": points,
        "control_points": seen.curve.control_points,
        "covariances": seen.blocks,
        "truth": true,
        "inside_2_sigma": covered.by_model,
        "expected_inside": INSIDE_2_SIGMA,
    }
    terms = f"{sight.TERMS.resolution:g} · {sight.TERMS.cons:g}"
    rows = [Row("4b", "R_res of P_t1 · cons of P_t2 (m²)", "free", terms)]
    for name, share in covered.by_model.items():
        quantity = f"truth inside 2σ with {name} ({INSIDE_2_SIGMA:.1%} expected, {runs} runs)"
        rows.append(Row("4b", quantity, "“reasonable”" if "P_t2" in name else NOT_GIVEN, f"{share.mean():.1%}"))
    return Reproduced(tuple(rows), (*files, write_data(stem, data)))


def _scan(axes: Axes, points: Float[np.ndarray, "m 2"]) -> None:
    fig.to_scale(axes, f"(a) {len(points)} points, 0.5° apart, 12 mm noise")
    fig.dots(axes, points, fig.RED, markersize=2.0)
    fig.robot(axes, sight.FIRST_POSE, fig.INK)


def _ellipses(axes: Axes, seen: ObservedSpline, true: Float[np.ndarray, "n 2"]) -> None:
    fig.to_scale(axes, "(b) Control points and 2σ ellipses")
    _estimate(axes, seen, true)
    fig.legend(axes)


def _close_up(axes: Axes, seen: ObservedSpline, true: Float[np.ndarray, "n 2"]) -> None:
    worst = int(np.argmax(np.linalg.norm(seen.curve.control_points - true, axis=1)))
    fig.to_scale(axes, f"(c) Close-up of control point {worst + 1}, the farthest off")
    _estimate(axes, seen, true)
    axes.set_aspect("equal", adjustable="box")
    x, y = true[worst]
    axes.set_xlim(x - 0.3, x + 0.3)
    axes.set_ylim(y - 0.2, y + 0.2)


def _estimate(axes: Axes, seen: ObservedSpline, true: Float[np.ndarray, "n 2"]) -> None:
    fig.line(axes, seen.curve.sample(0.02)[1], fig.PALE)
    for centre, block in zip(seen.curve.control_points, seen.blocks, strict=True):
        fig.ellipse(axes, centre, block, fig.BLUE)
    fig.dots(axes, seen.curve.control_points, fig.BLUE, "from the noisy scan", marker="+", markersize=5)
    fig.dots(axes, true, fig.RED, "“ground truth”", markersize=3)


def _coverage(axes: Axes, covered: Coverage) -> None:
    axes.set_title(f"(d) Truth inside 2σ, share of {covered.runs} scans")
    for (name, share), colour in zip(covered.by_model.items(), (fig.GREY, fig.ORANGE, fig.BLUE), strict=True):
        number = np.arange(1.0, len(share) + 1)
        fig.line(axes, np.stack([number, share], -1), colour, _mathematical(name), marker="o", markersize=4)
    axes.axhline(INSIDE_2_SIGMA, color=fig.INK, linewidth=1.0, linestyle="--", label=f"expected {INSIDE_2_SIGMA:.1%}")
    axes.set_ylim(-0.02, 1.02)
    axes.set_xlabel("control point")
    fig.legend(axes, 2)


def _mathematical(name: str) -> str:
    return name.replace("P_s", "$P_s$").replace("P_t1", "$P_{t1}$").replace("P_t2", "$P_{t2}$")
