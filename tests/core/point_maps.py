"""Simulated local point-feature maps: a walk round a square of features, each map a few steps' sight."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from bspline_slam import se2
from bspline_slam.joining import PointMap


@dataclass(frozen=True, eq=False, slots=True)
class Survey:
    """Local maps and the truth behind them; `features[j]` is the feature numbered 10 + 3 j."""

    maps: tuple[PointMap, ...]
    poses: np.ndarray
    features: np.ndarray


def covariance(rng: np.random.Generator, features: int) -> np.ndarray:
    """Of an end pose and features, everything correlated."""
    deviations = np.concatenate([[0.1, 0.1, 0.02], np.full(2 * features, 0.05)])
    mixing = np.eye(len(deviations)) + 0.3 * rng.normal(size=(len(deviations),) * 2) / np.sqrt(len(deviations))
    return deviations[:, None] * (mixing @ mixing.T) * deviations


def survey(
    rng: np.random.Generator, *, maps: int = 40, noise: float = 1.0, laps: int = 2, radius: float = 10.0
) -> Survey:
    """Laps on a circle of this radius (m), every feature within 5 m of a map's start in that map."""
    angle = 2 * np.pi * laps * np.arange(maps + 1) / maps
    poses = np.column_stack([radius * np.sin(angle), radius - radius * np.cos(angle), se2.wrap(angle)])
    around = np.linspace(0, 2 * np.pi, round(4 * radius), endpoint=False)
    reach = radius + rng.uniform(-3, 3, size=len(around))
    features = np.column_stack([reach * np.sin(around), radius - reach * np.cos(around)])
    made = []
    for start, end in itertools.pairwise(poses):
        near = np.flatnonzero(np.linalg.norm(features - start[:2], axis=1) < 5)
        P = covariance(rng, len(near))
        error = noise * np.linalg.cholesky(P) @ rng.normal(size=len(P))
        odometry = se2.between(start, end) + error[:3]
        seen = se2.transform(se2.inverse(start), features[near]) + error[3:].reshape(-1, 2)
        made.append(PointMap(odometry, seen, P, 10 + 3 * near))
    return Survey(tuple(made), poses, features)


def arrays(maps: tuple[PointMap, ...]) -> dict[str, np.ndarray]:
    """The maps as the arrays of a file."""
    parts: dict[str, np.ndarray] = {}
    for k, one in enumerate(maps):
        parts[f"x{k}"] = np.append(one.end, one.features.ravel())
        parts[f"P{k}"] = one.covariance
        parts[f"id{k}"] = one.ids
    return parts
