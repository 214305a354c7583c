"""The history as a state machine against a list of what a person would expect."""

from __future__ import annotations

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from bspline_slam.edits.edit import DropLoop, MergeSplines
from bspline_slam.edits.history import Accept, GoTo, History, Operation, Switch, operation_from_dict, operation_to_dict
from bspline_slam.errors import EditError
from core.edits.drawn import ACCEPTS, OPERATIONS


@given(OPERATIONS)
def test_an_operation_survives_json(operation: Operation) -> None:
    assert operation_from_dict(json.loads(json.dumps(operation_to_dict(operation)))) == operation


@pytest.mark.parametrize(
    ("data", "complaint"),
    [
        ({}, "no action"),
        ({"do": "go to"}, "cursor"),
        ({"do": "switch", "number": 0, "on": 1, "time": 0.0}, "on"),
        ({"do": "accept", "name": "x", "time": 0.0, "edits": [{"kind": "x"}]}, "no edit"),
    ],
)
def test_what_is_no_operation_is_refused(data: dict[str, object], complaint: str) -> None:
    with pytest.raises(EditError, match=complaint):
        operation_from_dict(data)


class Editing(RuleBasedStateMachine):
    """Random actions; `states` are the edits in force after each entry, as far as nothing else took its place."""

    def __init__(self) -> None:
        super().__init__()
        self.history = History()
        self.states: list[tuple[object, ...]] = [()]

    def _act(self, operation: Operation) -> None:
        self.states = self.states[: self.history.cursor + 1]
        self.history = self.history.after(operation)
        self.states.append(self.history.active)

    @rule(action=ACCEPTS)
    def accept(self, action: Accept) -> None:
        before = self.history.active
        self._act(action)
        assert self.history.active == (*before, *action.edits)

    @precondition(lambda self: self.history.states)
    @rule(data=st.data())
    def switch(self, data: st.DataObject) -> None:
        number = data.draw(st.sampled_from(sorted(self.history.states)))
        on = not self.history.states[number]
        self._act(Switch(number, on, 0.0))
        assert (number in {entry.number for entry in self.history.in_force}) == on

    @rule(data=st.data())
    def go_to(self, data: st.DataObject) -> None:
        self.history = self.history.after(GoTo(data.draw(st.integers(0, len(self.history.entries)))))

    @precondition(lambda self: self.history.undo is not None)
    @rule()
    def undo_and_redo(self) -> None:
        undo = self.history.undo
        assert undo is not None
        undone = self.history.after(undo)
        assert undone.redo is not None
        assert undone.after(undone.redo) == self.history

    @invariant()
    def the_edits_in_force_are_those_of_the_cursor(self) -> None:
        assert len(self.states) == len(self.history.entries) + 1
        assert self.history.active == self.states[self.history.cursor]

    @invariant()
    def all_undone_is_the_first_state_and_all_redone_the_last(self) -> None:
        first, last = self.history, self.history
        while first.undo:
            first = first.after(first.undo)
        while last.redo:
            last = last.after(last.redo)
        assert first.state_hash == History().state_hash
        assert last.active == self.states[-1]

    @invariant()
    def numbers_are_never_given_twice(self) -> None:
        numbers = [entry.number for entry in self.history.entries if not isinstance(entry, Switch)]
        assert len(set(numbers)) == len(numbers)


Editing.TestCase.settings = settings(max_examples=30, stateful_step_count=25, deadline=None)
TestEditing = Editing.TestCase


def test_other_edits_and_another_order_have_another_hash() -> None:
    one, other = DropLoop(1, 2), MergeSplines(1, 2)
    hashes = {
        History().after(Accept("", 0.0, edits)).state_hash for edits in ((one,), (other,), (one, other), (other, one))
    }
    assert len(hashes | {History().state_hash}) == 5


@pytest.mark.parametrize("operation", [Accept("", 0.0, ()), Switch(0, True, 0.0), GoTo(1), GoTo(-1)])
def test_what_makes_no_sense_is_refused(operation: Operation) -> None:
    with pytest.raises(EditError):
        history = History()
        history.after(operation)
