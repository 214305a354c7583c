"""What there is to find on the timeline."""

from __future__ import annotations

from bspline_slam.association import Verdict
from splinescope.browser.values import Mark
from splinescope.findings import Findings


def marks(findings: Findings) -> tuple[Mark, ...]:
    """Key scans and lost scans, accepted loop closures, scans that started splines of the map, whose pieces were gated
    out, and where decisions were made by hand."""
    steps = [step for step in findings.steps.values() if step.key or step.lost]
    loops = findings.snapshot.loop_closures if findings.snapshot is not None else ()
    born = {spline.born for spline in findings.snapshot.map} if findings.snapshot is not None else ()
    by_hand = {a.scan for step in steps for a in step.associations if a.by == "hand"}
    gated = {a.scan for step in steps for a in step.associations if a.verdict is Verdict.GATED and a.candidates}
    return (
        *(Mark(step.scan, "lost" if step.lost else "key") for step in steps),
        *(Mark(loop.scan, "loop") for loop in loops if loop.accepted),
        *(Mark(scan, "new") for scan in sorted(born)),
        *(Mark(scan, "gated") for scan in sorted(gated)),
        *(Mark(scan, "hand") for scan in sorted(by_hand)),
    )


def next_mark(findings: Findings, kind: str, cursor: int, by: int) -> int | None:
    """The scan of the next mark of a kind (by = 1), or of the one before (by = −1); None where there is none."""
    places = {mark.position for mark in marks(findings) if mark.kind == kind}
    if by > 0:
        return min((place for place in places if place > cursor), default=None)
    return max((place for place in places if place < cursor), default=None)
