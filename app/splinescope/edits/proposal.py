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


def asks(picking: Picking | None, proposal: Proposal | None, drafting: bool) -> str:
    """What a person is to do now, over the map: choose something, or decide on what is proposed."""
    if picking is not None:
        return f"{picking.value} Esc cancels."
    if proposal is None:
        return "Lay the purple scan where it belongs, then match it (Ctrl + Enter)." if drafting else ""
    if proposal.preview is None:
        return f"{proposal.name} …"
    if proposal.preview.refusal is not None:
        return f"{proposal.name}: {proposal.preview.refusal} Esc cancels."
    return f"Enter accepts, Esc cancels: {proposal.name}."
