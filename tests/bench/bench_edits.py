"""How soon a hand edit is answered on the largest recording: `python tests/bench/bench_edits.py [LOG]`.

For edits of pieces and splines all over the log: CPU time to the first corrected state (with all decisions made anew)
and to the converged one, the same by solving the whole problem exactly, and how far the quick answer lies from that.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from time import process_time

import numpy as np

from bench.recordings import largest_recording
from bspline_slam.edits.amend import amended
from bspline_slam.edits.edit import (
    FIRST_MADE_BY_HAND,
    Edit,
    Forbid,
    Force,
    Ignore,
    MakeNew,
    MergeSplines,
    PinPose,
    SplitSpline,
)
from bspline_slam.edits.ground import Ground
from bspline_slam.edits.making import edited
from bspline_slam.edits.quick import Answer, Footing, answer
from bspline_slam.errors import EditError
from bspline_slam.logs import open_log
from bspline_slam.slam import SlamConfig, Snapshot, run_slam
from bspline_slam.spline_map import MapSpline, SplineMap

EDITS = 56
KINDS = ("ignore", "force", "forbid", "new", "pin", "split", "merge")


def edit_on(base: Snapshot, number: int, kind: str) -> Edit | None:
    """An edit of the longest piece of a key scan that is given to a spline, or of that spline."""
    ids = {spline.id for spline in base.map}
    given = [a for a in base.observations[number].associations if a.spline in ids]
    if not given:
        return None
    piece = max(given, key=lambda a: a.last - a.first)
    assert piece.spline is not None
    where = (piece.scan, piece.segment, piece.first, piece.last)
    x, y, heading = (base.steps[number].pose + np.array([0.01, 0.0, 0.0])).tolist()
    made: dict[str, Edit] = {
        "ignore": Ignore(*where),
        "force": Force(*where, piece.spline),
        "forbid": Forbid(*where, piece.spline),
        "new": MakeNew(*where, FIRST_MADE_BY_HAND),
        "pin": PinPose(piece.scan, (x, y, heading)),
        "split": split(base.map[piece.spline]),
        "merge": merge(base.map[piece.spline], base.map),
    }
    return made[kind]


def split(spline: MapSpline) -> SplitSpline:
    """A spline cut in the middle."""
    x, y = spline.curve(np.array([np.mean(spline.span)]))[0].tolist()
    return SplitSpline(spline.id, (x, y), FIRST_MADE_BY_HAND)


def merge(spline: MapSpline, splines: SplineMap) -> MergeSplines:
    """A spline merged with the one whose end is nearest to one of its own."""
    ends = {other.id: other.curve(np.array(other.span)) for other in splines}
    mine = ends.pop(spline.id)
    nearest = min(ends, key=lambda other: np.linalg.norm(mine[:, None] - ends[other], axis=2).min())
    return MergeSplines(min(spline.id, nearest), max(spline.id, nearest))


def measure(footing: Footing, edit: Edit) -> tuple[float, float, Answer]:
    """Milliseconds to the first and to the last answer, and that."""
    first: list[float] = []
    start = process_time()
    decisions = edited(footing.ground, footing.ground.decisions, edit)
    found = answer(footing, decisions, lambda _: first.append(process_time() - start))
    return 1000 * first[0], 1000 * (process_time() - start), found


def main(argv: list[str]) -> list[dict[str, object]]:
    """Rows for bench.json: one for each kind of edit, and one for all of them."""
    log = open_log(Path(argv[0]) if argv else largest_recording())
    config = SlamConfig()
    base = run_slam(log, config).snapshot
    ground = Ground.of(base, config)
    footing = Footing.of(ground)
    chosen = np.linspace(5, len(base.observations) - 5, EDITS).astype(int)
    times: dict[str, list[tuple[float, float]]] = {kind: [] for kind in KINDS}
    off, exact = [], []
    for count, number in enumerate(chosen.tolist()):
        kind = KINDS[count % len(KINDS)]
        edit = edit_on(base, number, kind)
        if edit is None:
            continue
        try:
            measure(footing, edit)
        except EditError:
            continue  # two sides of a wall cannot be merged
        first, last, found = measure(footing, edit)
        times[kind].append((first, last))
        if count < 2 * len(KINDS):
            start = process_time()
            after = amended(base, (edit,), config, ground=ground).snapshot
            exact.append(1000 * (process_time() - start))
            poses = np.array([step.pose for step in after.steps])
            off.append(1000 * float(np.linalg.norm((poses - found.decisions.poses)[:, :2], axis=1).max()))
    rows = [row(kind, of_kind) for kind, of_kind in times.items() if of_kind]
    whole = row("all", [pair for of_kind in times.values() for pair in of_kind])
    whole |= {"exact_ms": round(float(np.median(exact)), 1), "off_mm": round(float(np.median(off)), 3)}
    whole |= {"log": log.name, "key_scans": len(base.key_scans), "unknowns": base_unknowns(base)}
    for one in (*rows, whole):
        print(json.dumps(one), flush=True)
    return [*rows, whole]


def base_unknowns(base: Snapshot) -> int:
    """Unknowns of the problem."""
    return 0 if base.estimate is None else base.estimate.graph.unknowns


def row(kind: str, pairs: list[tuple[float, float]]) -> dict[str, object]:
    """Medians and worst cases (CPU ms)."""
    first, last = np.array(pairs).T
    return {
        "edit": kind,
        "count": len(pairs),
        "first_ms": round(float(np.median(first)), 1),
        "converged_ms": round(float(np.median(last)), 1),
        "first_ms_95": round(float(np.percentile(first, 95)), 1),
        "converged_ms_95": round(float(np.percentile(last, 95)), 1),
    }


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))
    main(sys.argv[1:])
