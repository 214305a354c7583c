"""How soon a hand edit is answered on the largest recording: `python tests/bench/bench_edits.py [LOG]`.

Edits of every kind all over the log, one after another, each in the map that the ones before left: CPU time to the
first corrected state (with all decisions made anew), to the last quick answer, and to the exact optimum (`settled`),
of the explanation, and how far the quick answer lies from the optimum.
"""

from __future__ import annotations

import gc
import json
import sys
from dataclasses import dataclass
from pathlib import Path
from time import process_time

import numpy as np

from bench.recordings import largest_recording
from bspline_slam import se2
from bspline_slam.edits.amend import amended
from bspline_slam.edits.edit import (
    FIRST_MADE_BY_HAND,
    CloseLoop,
    DropLoop,
    Edit,
    Forbid,
    Force,
    Ignore,
    MakeNew,
    MergeSplines,
    PinPose,
    PinSpline,
    SplitSegment,
    SplitSpline,
)
from bspline_slam.edits.explain import explain
from bspline_slam.edits.loop_edits import moved_poses
from bspline_slam.edits.making import edited
from bspline_slam.edits.quick import answer
from bspline_slam.edits.states import States
from bspline_slam.errors import EditError
from bspline_slam.logs import open_log
from bspline_slam.slam import run_slam
from bspline_slam.slam_config import SlamConfig
from bspline_slam.snapshot import Snapshot
from bspline_slam.spline_map import MapSpline, SplineMap
from splinescope.computing.edit_jobs import warm

EDITS = 66
KINDS = (
    "ignore",
    "force",
    "forbid",
    "new",
    "split piece",
    "pin pose",
    "pin spline",
    "split spline",
    "merge",
    "drop loop",
    "close loop",
)
ROOT = ((50.0, 0.0, 0.0), (0.0, 50.0, 0.0), (0.0, 0.0, 200.0))
"""How sure a loop closed by hand is: to 2 cm and a third of a degree."""


def edit_on(now: Snapshot, number: int, kind: str, made: int = FIRST_MADE_BY_HAND) -> Edit | None:
    """An edit of the longest piece of a key scan that is given to a spline, of that spline, of the pose, or of a loop
    closure; `made` is the id of a spline that it makes. None where there is nothing to be edited."""
    ids = {spline.id for spline in now.map}
    given = [a for a in now.observations[number].associations if a.spline in ids]
    if not given:
        return None
    piece = max(given, key=lambda a: a.last - a.first)
    assert piece.spline is not None
    spline, where = now.map[piece.spline], (piece.scan, piece.segment, piece.first, piece.last)
    x, y, heading = (now.steps[number].pose + np.array([0.01, 0.0, 0.0])).tolist()
    match kind:
        case "ignore":
            return Ignore(*where)
        case "force":
            return Force(*where, spline.id)
        case "forbid":
            return Forbid(*where, spline.id)
        case "new":
            return MakeNew(*where, made)
        case "split piece":
            return SplitSegment(piece.scan, piece.segment, (piece.first + piece.last) // 2)
        case "pin pose":
            return PinPose(piece.scan, (x, y, heading))
        case "pin spline":
            return PinSpline.at(spline.id, spline.curve, spline.span)
        case "split spline":
            return split(spline, made)
        case "merge":
            return merge(spline, now.map)
        case "drop loop":
            return drop(now, number)
        case _:
            return close(now, number)


def drop(now: Snapshot, number: int) -> DropLoop | None:
    """One of the accepted loop closures dropped."""
    accepted = [closure for closure in now.loop_closures if closure.accepted]
    chosen = accepted[number % len(accepted)] if accepted else None
    return None if chosen is None else DropLoop(chosen.earlier, chosen.scan)


def close(now: Snapshot, number: int) -> CloseLoop:
    """A loop closed with another key scan, a centimetre from where the map has it."""
    first, last = sorted((number, (7 * number + 1) % len(now.steps)))
    x, y, heading = (se2.between(now.steps[first].pose, now.steps[last].pose) + np.array([0.01, 0.0, 0.0])).tolist()
    return CloseLoop(now.steps[first].scan, now.steps[last].scan, (x, y, heading), ROOT, 0.9, 0.9)


def split(spline: MapSpline, made: int) -> SplitSpline:
    """A spline cut in the middle."""
    x, y = spline.curve(np.array([np.mean(spline.span)]))[0].tolist()
    return SplitSpline(spline.id, (x, y), made)


def merge(spline: MapSpline, splines: SplineMap) -> MergeSplines:
    """A spline merged with the one whose end is nearest to one of its own."""
    ends = {other.id: other.curve(np.array(other.span)) for other in splines}
    mine = ends.pop(spline.id)
    nearest = min(ends, key=lambda other: np.linalg.norm(mine[:, None] - ends[other], axis=2).min())
    return MergeSplines(min(spline.id, nearest), max(spline.id, nearest))


@dataclass(frozen=True)
class Times:
    """CPU milliseconds to the first answer, the last quick one and the optimum, and for the explanation; how far (mm)
    the quick answer lies from the optimum."""

    first: float
    quick: float
    settled: float
    explained: float
    off: float


def measure(states: States, edits: tuple[Edit, ...], edit: Edit) -> Times:
    """One edit more. Raises EditError where it cannot be made."""
    footing, first = states.footing(edits), list[float]()
    ground, start = footing.ground, process_time()
    decisions = edited(ground, ground.decisions, edit)
    if isinstance(edit, CloseLoop | DropLoop):
        moved_poses(ground.decisions, decisions, states.config)
    found = answer(footing, decisions, lambda _: first.append(process_time() - start))
    quick, start = process_time() - start, process_time()
    made = amended(states.base, (*edits, edit), states.config, states=states)
    settled, start = process_time() - start, process_time()
    explain(states.base, made.snapshot, (*edits, edit), made.skipped, states.config)
    explained = process_time() - start
    off = np.linalg.norm((made.ground.decisions.poses - found.decisions.poses)[:, :2], axis=1).max()
    return Times(1000 * first[0], 1000 * quick, 1000 * settled, 1000 * explained, 1000 * float(off))


def main(argv: list[str]) -> list[dict[str, object]]:
    """Rows for bench.json: one for each kind of edit, and one for all of them."""
    log = open_log(Path(argv[0]) if argv else largest_recording())
    config = SlamConfig()
    base = run_slam(log, config).snapshot
    states, edits = States(base, config), tuple[Edit, ...]()
    warm(states)
    gc.collect()
    gc.freeze()
    times: dict[str, list[Times]] = {kind: [] for kind in KINDS}
    for number in np.random.default_rng(5).permutation(len(base.key_scans)).tolist():
        if len(edits) == EDITS:
            break
        kind, now = KINDS[len(edits) % len(KINDS)], states[edits].snapshot
        edit = edit_on(now, number, kind, FIRST_MADE_BY_HAND + len(edits))
        if edit is not None:
            try:
                times[kind].append(measure(states, edits, edit))
            except EditError:
                continue  # two sides of a wall cannot be merged
            edits = (*edits, edit)
    rows = [row(kind, of_kind) for kind, of_kind in times.items() if of_kind]
    whole = row("all", [one for of_kind in times.values() for one in of_kind])
    whole |= {"log": log.name, "key_scans": len(base.key_scans), "unknowns": base_unknowns(base)}
    for one in (*rows, whole):
        print(json.dumps(one), flush=True)
    return [*rows, whole]


def base_unknowns(base: Snapshot) -> int:
    """Unknowns of the problem."""
    return 0 if base.estimate is None else base.estimate.graph.unknowns


def row(kind: str, times: list[Times]) -> dict[str, object]:
    """Medians, and what 95 % stay below (CPU ms; mm)."""
    found: dict[str, object] = {"edit": kind, "count": len(times)}
    for name in ("first", "quick", "settled", "explained"):
        values = [getattr(one, name) for one in times]
        found[f"{name}_ms"] = round(float(np.median(values)), 1)
        found[f"{name}_ms_95"] = round(float(np.percentile(values, 95)), 1)
    return found | {"off_mm": round(float(np.median([one.off for one in times])), 3)}


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))
    main(sys.argv[1:])
