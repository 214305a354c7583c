"""What hand edits would change, or have changed, as it is drawn over the map."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
from jaxtyping import Float

from bspline_slam.edits.edit import CloseLoop, Edit, PinPose, PinSpline
from bspline_slam.errors import EditError
from bspline_slam.slam import Snapshot
from splinescope.edits.loop_draft import LoopDraft
from splinescope.edits.proposal import Proposal
from splinescope.view import GhostView, Point

EXAGGERATED = 1.0
"""The largest move of a pose is drawn so long (m) where it is shorter,"""
MOST_EXAGGERATED = 200.0
"""but no more than so many times too long."""


def ghost_view(
    proposal: Proposal | None,
    draft: LoopDraft | None,
    edits: tuple[Edit, ...],
    automatic: Snapshot | None,
    now: Snapshot | None,
) -> GhostView | None:
    """What is drawn of a proposal, of a drafted loop closure, of `edits` in force that hold a place or tie two, and,
    while nothing is proposed, of what edits moved between the `automatic` result and the map `now`."""
    preview = proposal.preview if proposal is not None else None
    ghost = preview.ghost if preview is not None else None
    moves = _moves(automatic, now) if proposal is None and automatic is not None and now is not None else None
    edits = (*edits, *proposal.edits) if proposal is not None else edits
    pins, ties = tuple(_pins(edits).values()), _ties(edits, now)
    if ghost is None and draft is None and moves is None and not pins and not ties:
        return None
    return GhostView(
        splines=ghost.splines if ghost is not None else None,
        path=ghost.poses if ghost is not None else None,
        points=draft.ghost if draft is not None else None,
        marks=draft.marks if draft is not None else (),
        moves=moves,
        pins=pins,
        ties=ties,
    )


def _pins(edits: tuple[Edit, ...]) -> dict[tuple[str, int], Point]:
    """Where a pin is stuck into each pose and spline that is held: into a spline in its middle."""
    pins = {}
    for edit in edits:
        if isinstance(edit, PinPose):
            pins["pose", edit.scan] = edit.pose[:2]
        elif isinstance(edit, PinSpline):
            with suppress(EditError):  # a journal may hold what is no curve: its explanation says so
                x, y = edit.curve(np.array([0.5 * sum(edit.span)]))[0]
                pins["spline", edit.spline] = (float(x), float(y))
    return pins


def _ties(edits: tuple[Edit, ...], now: Snapshot | None) -> tuple[tuple[Point, Point], ...]:
    """Where the key scans lie that loop closures by hand tie together."""
    closed = dict.fromkeys((edit.earlier, edit.scan) for edit in edits if isinstance(edit, CloseLoop))
    if now is None or not closed:
        return ()
    places = dict(zip(now.key_scans.tolist(), now.poses[now.key_scans, :2].tolist(), strict=True))
    return tuple((tuple(places[a]), tuple(places[b])) for a, b in closed if a in places and b in places)


def _moves(automatic: Snapshot, now: Snapshot) -> Float[np.ndarray, "n 2 2"] | None:
    """Lines from where key poses are to where edits moved them, drawn longer where they are short."""
    if len(automatic.poses) != len(now.poses):
        return None
    before, after = automatic.poses[now.key_scans, :2], now.poses[now.key_scans, :2]
    largest = float(np.linalg.norm(after - before, axis=1).max(initial=0.0))
    if largest < 1e-4:
        return None
    longer = min(max(EXAGGERATED / largest, 1.0), MOST_EXAGGERATED)
    return np.stack([after, after + longer * (after - before)], axis=1)
