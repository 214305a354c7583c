"""What a person is about to do by hand: choose something in the map, or decide on edits that are proposed."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from bspline_slam.edits.edit import Edit
from splinescope.computing.edit_messages import Preview


class Picking(Enum):
    """What the next click in the map chooses; the value asks for it."""

    TARGET = "Click the spline that it belongs to."
    PLACE = "Click the place to split it at."
    LOOP = "Click the pose of the key scan that saw the same place."


@dataclass(frozen=True, eq=False, slots=True)
class Proposal:
    """Edits that are looked at before they are accepted, and what they would do as far as it is known."""

    edits: tuple[Edit, ...]
    name: str
    preview: Preview | None = None
