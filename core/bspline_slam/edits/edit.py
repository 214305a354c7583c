"""What a person can overrule, as values; each can be written as JSON and read again.

Scans are named by their index, splines by their lasting id in the automatic result or by the id that an edit gave to a
spline it made. An edit carries the ids of the splines it makes, so that another edit, taken back or switched off, never
renames them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, get_type_hints

import numpy as np

from bspline_slam.bspline import BSpline
from bspline_slam.config import NOTHING, converted
from bspline_slam.errors import EditError, GeometryError

FIRST_MADE_BY_HAND = 1_000_000
"""Ids from here on belong to splines that edits make; no log begins so many by itself."""

Triple = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class OnPiece:
    """Beams `first … last` (numbers of beams) of one segment of a key scan."""

    scan: int
    segment: int
    first: int
    last: int


@dataclass(frozen=True, slots=True)
class Force(OnPiece):
    """The piece saw this spline, however far it lies from it."""

    spline: int


@dataclass(frozen=True, slots=True)
class Forbid(OnPiece):
    """The piece did not see this spline: its runner-up takes it, if there is one within the gate."""

    spline: int


@dataclass(frozen=True, slots=True)
class MakeNew(OnPiece):
    """The piece saw what no other did: it starts the spline of this new id."""

    spline: int


@dataclass(frozen=True, slots=True)
class Ignore(OnPiece):
    """The piece saw nothing that belongs in the map."""


@dataclass(frozen=True, slots=True)
class SplitSegment:
    """The piece with this beam ends before it, and another one begins with it."""

    scan: int
    segment: int
    beam: int


@dataclass(frozen=True, slots=True)
class SplitSpline:
    """The spline ends at this point (m); what lies beyond is the spline of the id `new`."""

    spline: int
    point: tuple[float, float]
    new: int


@dataclass(frozen=True, slots=True)
class MergeSplines:
    """Both are one: what was given to `gone` saw `kept`."""

    kept: int
    gone: int


@dataclass(frozen=True, slots=True)
class PinPose:
    """The key scan was taken exactly here (x, y, θ in the world)."""

    scan: int
    pose: Triple


@dataclass(frozen=True, slots=True)
class PinSpline:
    """The spline is exactly this curve, supported between the parameters `span`."""

    spline: int
    degree: int
    knots: tuple[float, ...]
    control_points: tuple[tuple[float, float], ...]
    span: tuple[float, float]

    @classmethod
    def at(cls, spline: int, curve: BSpline, span: tuple[float, float]) -> PinSpline:
        """The spline held where this curve is."""
        points = tuple((float(x), float(y)) for x, y in curve.control_points)
        return cls(spline, curve.degree, tuple(map(float, curve.knots)), points, (float(span[0]), float(span[1])))

    @property
    def curve(self) -> BSpline:
        """The curve. Raises EditError where the numbers make none."""
        try:
            return BSpline(self.degree, np.array(self.knots), np.array(self.control_points).reshape(-1, 2))
        except GeometryError as error:
            raise EditError(f"the curve that spline {self.spline} is pinned to is none: {error}") from None


@dataclass(frozen=True, slots=True)
class CloseLoop:
    """Key scan `scan` lies at `measured` (x, y, θ) as seen from the key scan `earlier`.

    `sqrt_information` holds the rows of R in e = R·(measured ⊖ between), whitened.
    """

    earlier: int
    scan: int
    measured: Triple
    sqrt_information: tuple[Triple, Triple, Triple]
    score: float
    inliers: float


@dataclass(frozen=True, slots=True)
class DropLoop:
    """The two key scans did not see the same place: the closure between them is not believed."""

    earlier: int
    scan: int


Edit = (
    Force
    | Forbid
    | MakeNew
    | Ignore
    | SplitSegment
    | SplitSpline
    | MergeSplines
    | PinPose
    | PinSpline
    | CloseLoop
    | DropLoop
)
PieceEdit = Force | Forbid | MakeNew | Ignore
LoopEdit = CloseLoop | DropLoop

KINDS: Mapping[str, type] = {
    "force": Force,
    "forbid": Forbid,
    "new": MakeNew,
    "ignore": Ignore,
    "split segment": SplitSegment,
    "split spline": SplitSpline,
    "merge": MergeSplines,
    "pin pose": PinPose,
    "pin spline": PinSpline,
    "close loop": CloseLoop,
    "drop loop": DropLoop,
}
"""The names of the kinds in a journal."""

_NAMES = {cls: name for name, cls in KINDS.items()}


def edit_to_dict(edit: Edit) -> dict[str, Any]:
    """Plain values for JSON; the inverse of `edit_from_dict`."""
    return {"kind": _NAMES[type(edit)], **asdict(edit)}


def edit_from_dict(data: Any) -> Edit:
    """The edit that a dictionary describes; raises EditError naming what is wrong with it."""
    if not isinstance(data, Mapping) or data.get("kind") not in KINDS:
        raise EditError(f"{str(data)[:60]} is no edit")
    kind = KINDS[data["kind"]]
    hints = get_type_hints(kind)
    if set(data) != {"kind", *hints}:
        raise EditError(f'the edit "{data["kind"]}" has {", ".join(sorted(hints))}, not {", ".join(sorted(data))}')
    return kind(**{name: _value(hint, data[name], data["kind"], name) for name, hint in hints.items()})


def _value(hint: Any, value: Any, kind: str, name: str) -> Any:
    found = converted(hint, value)
    if found is NOTHING or not _finite(found):
        raise EditError(f'{name} of the edit "{kind}" cannot be {str(value)[:60]}')
    return found


def _finite(value: Any) -> bool:
    return all(map(_finite, value)) if isinstance(value, tuple) else bool(np.isfinite(value))


def in_words(edit: Edit) -> str:
    """What an edit says, for a list of edits."""
    match edit:
        case Force():
            return f"Force {_piece(edit)} to spline {edit.spline}"
        case Forbid():
            return f"Forbid {_piece(edit)} to see spline {edit.spline}"
        case MakeNew():
            return f"Make a new spline of {_piece(edit)}"
        case Ignore():
            return f"Ignore {_piece(edit)}"
        case SplitSegment():
            return f"Split segment {edit.segment} of scan {edit.scan} before beam {edit.beam}"
        case SplitSpline():
            return f"Split spline {edit.spline} at {edit.point[0]:.2f}, {edit.point[1]:.2f} m"
        case MergeSplines():
            return f"Merge spline {edit.gone} into spline {edit.kept}"
        case PinPose():
            return f"Pin the pose of scan {edit.scan}"
        case PinSpline():
            return f"Pin spline {edit.spline}"
        case CloseLoop():
            return f"Close a loop from scan {edit.scan} to scan {edit.earlier}"
        case DropLoop():
            return f"Drop the loop closure of scan {edit.scan} with scan {edit.earlier}"


def _piece(piece: OnPiece) -> str:
    return f"beams {piece.first}–{piece.last} of scan {piece.scan}"


def splines_made(edit: Edit) -> tuple[int, ...]:
    """Ids of the splines that an edit makes."""
    match edit:
        case MakeNew(spline=made) | SplitSpline(new=made):
            return (made,)
        case _:
            return ()
