"""The figures of an evaluation as plain data and as text for a terminal."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np
from jaxtyping import Float

from bspline_slam.lab.evaluation import Figures, TrajectoryErrors
from bspline_slam.lab.relations import RelationErrors


def relation_figures(errors: RelationErrors) -> dict[str, Any]:
    """Counts and figures of relation errors; translations in m, rotations in degrees."""
    figures: dict[str, Any] = {
        "relations": len(errors.scored),
        "scored": int(errors.scored.sum()),
        "interpolated": int(errors.interpolated.sum()),
        "outside_trajectory": int((~errors.scored).sum()),
    }
    if figures["scored"]:
        figures |= {
            "translation_m": _figures(errors.translation),
            "translation_with_lever_arm_m": _figures(errors.translation_with_lever_arm),
            "rotation_deg": _figures(np.degrees(errors.rotation)),
        }
    return figures


def trajectory_figures(errors: TrajectoryErrors) -> dict[str, Any]:
    """Counts and figures of ATE and RPE; translations in m, rotations in degrees."""
    figures: dict[str, Any] = {
        "compared": errors.compared,
        "outside_trajectory": errors.left_out,
        "ate_m": _figures(errors.absolute_translation),
        "ate_deg": _figures(np.degrees(errors.absolute_rotation)),
    }
    if len(errors.relative_translation):
        figures |= {
            "rpe_distance_m": errors.distance,
            "rpe_m": _figures(errors.relative_translation),
            "rpe_deg": _figures(np.degrees(errors.relative_rotation)),
        }
    return figures


def relation_text(figures: dict[str, Any]) -> str:
    """The figures of relations, both definitions of the translation error."""
    lines = [f"relations    {figures['scored']} of {figures['relations']} scored{_between(figures)}"]
    if figures["outside_trajectory"]:
        lines.append(f"not scored   {figures['outside_trajectory']}: a stamp lies outside the time of the trajectory")
    if figures["scored"]:
        lines += [
            f"translation  {_line(figures['translation_m'], 'm')}   Kümmerle: ‖t − t*‖",
            f"             {_line(figures['translation_with_lever_arm_m'], 'm')}   "
            "Cartographer: with lever arm × rotation error",
            f"rotation     {_line(figures['rotation_deg'], '°')}   |θ − θ*|",
        ]
    return "\n".join(lines)


def trajectory_text(figures: dict[str, Any]) -> str:
    """ATE and RPE against a reference trajectory."""
    lines = [
        f"reference    {figures['compared']} poses compared, {figures['outside_trajectory']} outside the trajectory"
    ]
    lines += [
        f"ATE          {_line(figures['ate_m'], 'm')}   rms {figures['ate_m']['rms']:.4f} m",
        f"             {_line(figures['ate_deg'], '°')}",
    ]
    if "rpe_m" in figures:
        lines += [
            f"RPE          {_line(figures['rpe_m'], 'm')}   over {figures['rpe_distance_m']:g} m of path",
            f"             {_line(figures['rpe_deg'], '°')}",
        ]
    return "\n".join(lines)


def _figures(errors: Float[np.ndarray, "n"]) -> dict[str, float]:
    return asdict(Figures.of(errors))


def _line(figures: dict[str, float], unit: str) -> str:
    return f"{figures['mean']:.4f} ± {figures['std']:.4f} {unit}, at most {figures['maximum']:.4f} {unit}"


def _between(figures: dict[str, Any]) -> str:
    count = figures["interpolated"]
    return f", {count} of them with an end between two records" if count else ""
