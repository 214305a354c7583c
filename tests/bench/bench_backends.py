"""Time of the back ends on a problem the size of the Intel Lab log: `python tests/bench/bench_backends.py`.

1,000 poses on three laps of a square corridor, 150 splines of 10 control points, 7,900 observations of 4-12 of
them, odometry and loop edges; starting values off by what odometry drift leaves.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, process_time

import numpy as np

from bspline_slam import se2
from bspline_slam.backends import BACK_ENDS, ONE_PASS, back_end
from bspline_slam.backends.protocol import Estimate, Marginals
from bspline_slam.graph import Graph, PoseFactor, PosePrior, ShapePrior, SplineFactor

ITERATING = tuple(name for name in BACK_ENDS if name not in ONE_PASS)
"""The others take minutes, or need beams."""
SIDE, LAPS, SPACING, POINTS, RANGE_NOISE = 24.0, 3, 0.4, 10, 0.012
PLACE_NOISE = 0.5
"""How well a view says where along a wall its control points lie (m); without it straight walls slide for ever."""
UNIFORM_CUBIC = np.array([[1, 4, 1, 0], [-3, 0, 3, 0], [3, -6, 3, 0], [-1, 3, -3, 1]]) / 6
"""Weights of four control points by powers of the parameter."""


def intel_sized(rng: np.random.Generator, poses: int = 1000, splines: int = 150, observations: int = 7900) -> Graph:
    """The synthetic problem; smaller numbers give a smaller one of the same shape."""
    truth = square_laps(poses)
    walls = scattered_walls(rng, splines)
    factors = nearest_views(rng, truth, walls, observations)
    edges = [measured_edge(rng, truth, i, i + 1, None) for i in range(poses - 1)]
    lap = poses // LAPS
    edges += [measured_edge(rng, truth, i, i + lap, 2.0) for i in range(poses - lap)]
    start = truth + np.cumsum(rng.normal(size=truth.shape) * [1e-3, 1e-3, 2e-4], axis=0)
    return Graph(
        np.arange(poses),
        np.column_stack([start[:, :2], se2.wrap(start[:, 2])]),
        np.arange(splines),
        POINTS * np.arange(splines + 1),
        walls + 0.03 * rng.normal(size=walls.shape),
        tuple(factors),
        tuple(edges),
        (PosePrior(0, start[0], 1e5 * np.eye(3)),),
        tuple(smoothness(POINTS * k) for k in range(splines)),
    )


def square_laps(poses: int) -> np.ndarray:
    """Poses along the corridor, as many on each lap."""
    way = np.arange(poses) / poses * LAPS * 4 * SIDE
    side, along = np.divmod(way, SIDE)
    heading = se2.wrap(side * np.pi / 2)
    corners = np.array([[0.0, 0.0], [SIDE, 0.0], [SIDE, SIDE], [0.0, SIDE]])
    ahead = np.column_stack([np.cos(heading), np.sin(heading)])
    return np.column_stack([corners[side.astype(int) % 4] + along[:, None] * ahead, heading])


def scattered_walls(rng: np.random.Generator, splines: int) -> np.ndarray:
    """Straight and slightly bent walls beside the corridor, control points stacked."""
    beside = square_laps(splines * LAPS)[:splines]
    offset = rng.uniform(1.0, 4.0, splines) * rng.choice([-1, 1], splines)
    centre = se2.transform(beside, np.column_stack([np.zeros(splines), offset]))
    heading = beside[:, 2] + rng.choice([0.0, np.pi / 2], splines) + 0.1 * rng.normal(size=splines)
    along = SPACING * (np.arange(POINTS) - POINTS / 2)
    across = rng.normal(size=(splines, 1)) * 0.02 * along**2
    local = np.stack([np.broadcast_to(along, across.shape), across], axis=-1)
    return (centre[:, None] + local @ np.swapaxes(se2.rotation(heading), 1, 2)).reshape(-1, 2)


def nearest_views(rng: np.random.Generator, poses: np.ndarray, walls: np.ndarray, count: int) -> list[SplineFactor]:
    """Each pose sees about as many of the walls around it as the others, a window of 4-12 control points each."""
    by_spline = walls.reshape(-1, POINTS, 2)
    seen = np.diff(np.linspace(0, count, len(poses) + 1).astype(int))
    factors = []
    for i, pose in enumerate(poses):
        distance = np.linalg.norm(by_spline.mean(axis=1) - pose[:2], axis=1)
        for spline in rng.permutation(np.argsort(distance)[:20])[: seen[i]]:
            width = int(rng.integers(4, min(12, POINTS) + 1))
            shift = int(rng.integers(0, POINTS - width + 1))
            factors.append(compressed_view(rng, i, pose, spline * POINTS + shift, by_spline[spline, shift:][:width]))
    return factors


def compressed_view(rng: np.random.Generator, i: int, pose: np.ndarray, first: int, points: np.ndarray) -> SplineFactor:
    """Six beams per span, each measuring the distance across the wall, and a rough place of each control point."""
    span, parameter = np.divmod(np.arange(6 * (len(points) - 3)) / 6, 1.0)
    around = span.astype(int)[:, None] + np.arange(4)
    weights = parameter[:, None] ** np.arange(4) @ UNIFORM_CUBIC
    slopes = parameter[:, None] ** np.arange(3) @ (UNIFORM_CUBIC[1:] * [[1], [2], [3]])
    tangents = np.einsum("jk,jka->ja", slopes, points[around])
    normals = np.column_stack([-tangents[:, 1], tangents[:, 0]]) / np.linalg.norm(tangents, axis=1)[:, None]
    rows = np.zeros((len(span), len(points), 2))
    whitened = weights[:, :, None] * (normals @ se2.rotation(pose[2]))[:, None] / RANGE_NOISE
    rows[np.arange(len(span))[:, None], around] = whitened
    rows = np.concatenate([rows.reshape(len(span), -1), np.eye(2 * len(points)) / PLACE_NOISE])
    q = se2.transform(se2.inverse(pose), points).ravel()
    Q, A = np.linalg.qr(rows)
    measured = rows @ q + rng.normal(size=len(rows))
    b = Q.T @ measured
    return SplineFactor(i, first, A, b, len(rows), float(measured @ measured - b @ b))


def measured_edge(rng: np.random.Generator, truth: np.ndarray, i: int, j: int, kernel: float | None) -> PoseFactor:
    """Scan matching to 1 cm and 0.2 degrees."""
    sigma = np.array([0.01, 0.01, 0.0035])
    measured = se2.compose(se2.between(truth[i], truth[j]), sigma * rng.normal(size=3))
    return PoseFactor(i, j, measured, np.diag(1 / sigma), "matching" if kernel is None else "loop", kernel)


def smoothness(first: int, sigma: float = 0.5) -> ShapePrior:
    """Second differences of the control points of one spline."""
    second = np.diff(np.eye(POINTS), 2, axis=0) / sigma
    return ShapePrior(first, np.kron(second, np.eye(2)), np.zeros(2 * (POINTS - 2)))


@dataclass(frozen=True)
class Timed:
    """Best wall and processor time (s) of a job over its repeats."""

    wall: float
    processor: float


def timed(job: Callable[[], object], repeats: int) -> Timed:
    """Run a job some times."""
    walls, processors = [], []
    for _ in range(repeats):
        wall, processor = perf_counter(), process_time()
        job()
        walls.append(perf_counter() - wall)
        processors.append(process_time() - processor)
    return Timed(min(walls), min(processors))


@dataclass(frozen=True, eq=False)
class Solved:
    """An optimum and covariances there."""

    estimate: Estimate
    marginals: Marginals


def measure(name: str, graph: Graph, repeats: int) -> tuple[dict[str, float | str], Solved]:
    """One row of the table, and what was found. `sam` is asked for 20 covariances, for all take it minutes; the others
    for all."""
    solver = back_end(name)
    estimate = solver.solve(graph)
    steps = len(estimate.iterations) - 1
    count = 10 if name == "sam" else max(len(graph.poses), len(graph.spline_ids))
    poses, splines = range(len(graph.poses))[:count], [int(k) for k in graph.spline_ids[:count]]
    solving = timed(lambda: solver.solve(graph), repeats)
    marginals = timed(lambda: solver.covariances(estimate, poses=poses, splines=splines), repeats)
    row: dict[str, float | str] = {
        "back_end": name,
        "iterations": steps,
        "iteration_s": estimate.iterations[-1].seconds / steps,
        "solve_s": solving.wall,
        "solve_processor_s": solving.processor,
        "covariances": len(poses) + len(splines),
        "covariances_s": marginals.wall,
        "covariances_processor_s": marginals.processor,
        "cost": estimate.iterations[-1].cost,
    }
    return row, Solved(estimate, solver.covariances(estimate, poses=poses, splines=splines))


def compare(rows: list[dict[str, float | str]], found: dict[str, Solved]) -> None:
    """Say of `direct` how far from and how much faster than gtsam it is, where both ran."""
    by_name = {row["back_end"]: row for row in rows}
    if not {"direct", "sam"} <= found.keys():
        return
    a, b, direct, sam = found["direct"].estimate, found["sam"].estimate, by_name["direct"], by_name["sam"]
    direct["largest_difference_from_sam"] = max(
        float(np.abs(a.control_points - b.control_points).max()), float(np.abs(a.poses - b.poses).max())
    )
    direct["times_faster_than_sam"] = float(sam["solve_processor_s"]) / float(direct["solve_processor_s"])
    each = [float(row["covariances_processor_s"]) / float(row["covariances"]) for row in (direct, sam)]
    direct["covariance_times_faster_than_sam"] = each[1] / each[0]
    direct["largest_covariance_difference_from_sam"] = covariance_difference(
        found["direct"].marginals, found["sam"].marginals
    )


def covariance_difference(ours: Marginals, theirs: Marginals) -> float:
    """Largest difference of a covariance, as a share of its largest entry."""
    pairs = [(ours.poses[k], other) for k, other in theirs.poses.items()]
    pairs += [(ours.splines[k], other) for k, other in theirs.splines.items()]
    return max(float(np.abs(one - other).max() / np.abs(other).max()) for one, other in pairs)


def shown(value: float | str) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def main(argv: list[str] | None = None) -> list[dict[str, float | str]]:
    """Print the table and return its rows; `--json FILE` keeps them too."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--back-ends", nargs="+", choices=ITERATING, default=list(ITERATING))
    parser.add_argument("--json", type=Path)
    options = parser.parse_args(argv)
    small = intel_sized(np.random.default_rng(1), 30, 9, 90)
    first = timed(lambda: back_end("direct").solve(small), 1)
    print(f"first small solve (kernels compiled, or read from their cache): {first.wall:.2f} s")
    graph = intel_sized(np.random.default_rng(0))
    print(f"{len(graph.poses)} poses, {len(graph.spline_factors)} observations, {graph.unknowns} unknowns")
    rows, found = [], {}
    for name in options.back_ends:
        row, found[name] = measure(name, graph, 1 if name == "sam" else options.repeats)
        rows.append(row)
    compare(rows, found)
    for row in rows:
        print("  ".join(f"{key} {shown(value)}" for key, value in row.items()))
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    return rows


if __name__ == "__main__":
    main()
