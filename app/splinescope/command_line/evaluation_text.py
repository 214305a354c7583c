"""The figures of an evaluation as plain data and as text for a terminal."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np
from jaxtyping import Float

from bspline_slam.lab.corner_gaps import CornerGaps
from bspline_slam.lab.crispness import Crispness
from bspline_slam.lab.evaluation import Figures, TrajectoryErrors
from bspline_slam.lab.map_size import MapSize
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


def crispness_figures(found: Crispness) -> dict[str, Any]:
    """Beams, root mean square (m) and shares; null where no beam is near a curve."""
    return {
        "beams": found.beams,
        "rms_within_5cm_m": _number(found.rms),
        "share_within_5cm": _number(found.within_5cm),
        "share_within_3cm": _number(found.within_3cm),
    }


def crispness_text(figures: dict[str, Any]) -> str:
    """How near beams end to the map."""
    return f"crispness    {_near(figures)}"


def held_out_text(figures: dict[str, Any]) -> str:
    """The same of beams that the curves were not fitted to."""
    return f"held out     {_near(figures)}   curves fitted to even beams, held against odd ones"


def size_figures(size: MapSize, doubled: float, gaps: CornerGaps) -> dict[str, Any]:
    """Splines, control points and bytes, how many metres of curve show a wall twice, and how well corners meet."""
    return {
        "splines": size.splines,
        "control_points": size.control_points,
        "spline_metres": round(size.metres, 2),
        "double_walls_m": round(doubled, 2),
        "corners": gaps.corners,
        "corners_joined": gaps.joined,
        "corner_gap_mean_m": _number(gaps.mean),
        "corner_gap_95_m": _number(gaps.percentile_95),
        "bytes": size.raw,
        "bytes_gzip": size.packed,
        "grid_bytes": size.grid_raw,
        "grid_bytes_gzip": size.grid_packed,
    }


def size_text(figures: dict[str, Any]) -> str:
    """The map's size, and that of a grid."""
    grid, packed = figures["grid_bytes"], figures["grid_bytes_gzip"]
    packed = "its contents need --log" if packed is None else f"{packed:,} gzip"
    return (
        f"map          {figures['splines']} splines, {figures['control_points']:,} control points, "
        f"{figures['spline_metres']:g} m\n"
        f"double walls {figures['double_walls_m']:.1f} m of curve within 8 cm of a longer one that faces the same way\n"
        f"{_corner_text(figures)}"
        f"size         {figures['bytes']:,} bytes, {figures['bytes_gzip']:,} gzip: "
        "control points and knots as float32\n"
        f"             {grid:,} bytes, {packed}: a grid of 5 cm cells over the same rectangle"
    )


def _corner_text(figures: dict[str, Any]) -> str:
    """How many corners are joined, and how far walls end from the crossing at all of them; nothing without corners."""
    if not figures["corners"]:
        return ""
    mean, worst = 1e3 * figures["corner_gap_mean_m"], 1e3 * figures["corner_gap_95_m"]
    return (
        f"corners      {figures['corners_joined']} of {figures['corners']} joined; "
        f"walls end {mean:.1f} mm from their crossing, 95 % within {worst:.0f} mm\n"
    )


def cost_figures(report: dict[str, Any]) -> dict[str, Any]:
    """Wall time by stage, processor time (s) and memory (MB) of the run, as far as its report tells."""
    names = ("seconds", "seconds_total", "processor_seconds", "peak_memory_mb")
    return {name: report[name] for name in names if name in report}


def cost_text(figures: dict[str, Any]) -> str:
    """Time and memory in one line; nothing where the report is missing."""
    if "seconds_total" not in figures:
        return ""
    stages = ", ".join(f"{stage} {time:.1f}" for stage, time in figures.get("seconds", {}).items())
    processor = f", {figures['processor_seconds']:.1f} s of processor" if "processor_seconds" in figures else ""
    memory = f", {figures['peak_memory_mb']:.0f} MB" if "peak_memory_mb" in figures else ""
    return f"run          {figures['seconds_total']:.1f} s ({stages}){processor}{memory}"


def _near(figures: dict[str, Any]) -> str:
    if figures["rms_within_5cm_m"] is None:
        return f"none of {figures['beams']:,} beams on walls ends within 5 cm of a curve"
    return (
        f"{1e3 * figures['rms_within_5cm_m']:.2f} mm RMS within 5 cm; {100 * figures['share_within_3cm']:.1f} % of "
        f"{figures['beams']:,} beams on walls within 3 cm, {100 * figures['share_within_5cm']:.1f} % within 5 cm"
    )


def _number(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _figures(errors: Float[np.ndarray, "n"]) -> dict[str, float]:
    return asdict(Figures.of(errors))


def _line(figures: dict[str, float], unit: str) -> str:
    return f"{figures['mean']:.4f} ± {figures['std']:.4f} {unit}, at most {figures['maximum']:.4f} {unit}"


def _between(figures: dict[str, Any]) -> str:
    count = figures["interpolated"]
    return f", {count} of them with an end between two records" if count else ""
