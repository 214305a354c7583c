"""The history of hand edits: everything that was accepted or switched, and how much of it is in force.

Every action of a person is one entry. `cursor` says how many entries are in force; those after it were undone and can
be done again until another action takes their place. Switching an edit off or on is an action like any other, so to
undo everything always leads back to the automatic result, and to redo everything to the last one.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from bspline_slam.config import NOTHING, converted
from bspline_slam.edits.edit import Edit, edit_from_dict, edit_to_dict
from bspline_slam.errors import EditError


@dataclass(frozen=True, slots=True)
class Accept:
    """Edits that a person accepted in one action, its name and its time (s since 1970)."""

    name: str
    time: float
    edits: tuple[Edit, ...]


@dataclass(frozen=True, slots=True)
class Switch:
    """The accepted action of this number put out of force (`on` false) or into force again."""

    number: int
    on: bool
    time: float


@dataclass(frozen=True, slots=True)
class GoTo:
    """Put the first `cursor` entries into force and no others: undo, redo, and any state in between."""

    cursor: int


Operation = Accept | Switch | GoTo


@dataclass(frozen=True, slots=True)
class Accepted:
    """An accepted action; `number` is its own for ever."""

    number: int
    action: Accept


@dataclass(frozen=True, slots=True)
class History:
    """All entries, how many of them are in force, and how many actions were ever accepted."""

    entries: tuple[Accepted | Switch, ...] = ()
    cursor: int = 0
    accepted: int = 0

    def after(self, operation: Operation) -> History:
        """The history with one more operation. Raises EditError where it makes no sense."""
        match operation:
            case Accept(edits=()):
                raise EditError("an action without edits changes nothing")
            case Accept():
                entry = Accepted(self.accepted, operation)
                return replace(self._with(entry), accepted=self.accepted + 1)
            case Switch(number=number, on=on):
                if self.states.get(number, on) == on:
                    raise EditError(f"action {number} is {'on' if on else 'off'} already, or not in force")
                return self._with(operation)
            case GoTo(cursor=cursor):
                if not 0 <= cursor <= len(self.entries):
                    raise EditError(f"there are {len(self.entries)} actions: none of them is number {cursor}")
                return replace(self, cursor=cursor)

    def _with(self, entry: Accepted | Switch) -> History:
        entries = (*self.entries[: self.cursor], entry)
        return replace(self, entries=entries, cursor=len(entries))

    @property
    def undo(self) -> GoTo | None:
        """What takes back the last action in force; None where there is none."""
        return GoTo(self.cursor - 1) if self.cursor else None

    @property
    def redo(self) -> GoTo | None:
        """What does the action again that was taken back last; None where there is none."""
        return GoTo(self.cursor + 1) if self.cursor < len(self.entries) else None

    @property
    def in_force(self) -> tuple[Accepted, ...]:
        """The accepted actions up to the cursor that are switched on, in order."""
        states = self.states
        accepted = (entry for entry in self.entries[: self.cursor] if isinstance(entry, Accepted))
        return tuple(entry for entry in accepted if states[entry.number])

    @property
    def active(self) -> tuple[Edit, ...]:
        """The edits in force, in order."""
        return tuple(edit for entry in self.in_force for edit in entry.action.edits)

    @property
    def states(self) -> dict[int, bool]:
        """Of each accepted action up to the cursor, whether it is switched on."""
        states: dict[int, bool] = {}
        for entry in self.entries[: self.cursor]:
            states[entry.number] = entry.on if isinstance(entry, Switch) else True
        return states

    @property
    def state_hash(self) -> str:
        """The same for the same edits in force in the same order, and for no others."""
        return edits_hash(self.active)


def edits_hash(edits: tuple[Edit, ...]) -> str:
    """The hash of a list of edits."""
    return hashlib.sha256(json.dumps([edit_to_dict(edit) for edit in edits]).encode()).hexdigest()


def operation_to_dict(operation: Operation) -> dict[str, Any]:
    """Plain values for JSON; the inverse of `operation_from_dict`."""
    match operation:
        case Accept(name=name, time=time, edits=edits):
            return {"do": "accept", "name": name, "time": time, "edits": [edit_to_dict(edit) for edit in edits]}
        case Switch(number=number, on=on, time=time):
            return {"do": "switch", "number": number, "on": on, "time": time}
        case GoTo(cursor=cursor):
            return {"do": "go to", "cursor": cursor}


def operation_from_dict(data: Mapping[str, Any]) -> Operation:
    """The operation that a dictionary describes; raises EditError naming what is wrong with it."""
    match data:
        case {"do": "accept", "edits": list(edits)}:
            return Accept(_of(data, "name", str), _of(data, "time", float), tuple(map(edit_from_dict, edits)))
        case {"do": "switch"}:
            return Switch(_of(data, "number", int), _of(data, "on", bool), _of(data, "time", float))
        case {"do": "go to"}:
            return GoTo(_of(data, "cursor", int))
    raise EditError(f"{str(data)[:60]} is no action")


def _of(data: Mapping[str, Any], name: str, kind: type) -> Any:
    value = converted(kind, data.get(name))
    if value is NOTHING:
        raise EditError(f'"{name}" of the action "{data["do"]}" cannot be {str(data.get(name))[:60]}')
    return value
