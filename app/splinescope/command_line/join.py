"""The command `join`: local point-feature maps made elsewhere, joined into one, and the result as a file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

from bspline_slam.backends.protocol import IterationRecord
from bspline_slam.joining import join_point_maps, read_point_maps

Progress = Callable[[str, float], None]
Cancelling = Callable[[], bool]


def join_and_write(maps_file: Path, out: Path, *, progress: Progress, cancelled: Cancelling) -> dict[str, Any]:
    """Join the local maps of the file and write `joint.npz` into `out`; returns the figures.

    Raises the library's errors; Cancelled leaves no file.
    """
    began = perf_counter()
    maps = read_point_maps(maps_file)
    progress(f"Joining {len(maps)} local maps", 0.0)

    def watch(record: IterationRecord) -> None:
        progress(f"Joining {len(maps)} local maps", 1.0 - 0.9**record.index)

    joint = join_point_maps(maps, progress=watch, cancelled=cancelled)
    out.mkdir(parents=True, exist_ok=True)
    joint.to_npz(out / "joint.npz")
    return {
        "maps": len(maps),
        "features": len(joint.feature_ids),
        "states": joint.unknowns,
        "iterations": len(joint.iterations) - 1,
        "converged": joint.converged,
        "chi2": joint.chi2,
        "dof": joint.dof,
        "seconds": round(perf_counter() - began, 3),
    }


def joined_text(figures: dict[str, Any], out: Path) -> str:
    """What a person wants to know of a joint map."""
    fit = f"χ² {figures['chi2']:.1f} with {figures['dof']} degrees of freedom"
    ratio = f" (χ²/dof {figures['chi2'] / figures['dof']:.2f})" if figures["dof"] > 0 else ""
    end = "converged" if figures["converged"] else "NOT converged (are equal ids always the same feature?)"
    return (
        f"{figures['maps']} maps, {figures['features']} features, {figures['states']} states; "
        f"{end} after {figures['iterations']} iterations; {fit}{ratio}; {figures['seconds']:.1f} s\n"
        f"{out}/ joint.npz"
    )
