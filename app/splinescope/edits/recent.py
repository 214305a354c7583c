"""Results with hand edits that were shown lately: to go back to one of them nobody has to be asked."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass, replace

from bspline_slam.edits.doubts import Doubt
from bspline_slam.edits.edit import Edit
from bspline_slam.edits.explain import Explanation
from splinescope.result import Result

KEPT = 16
"""So many of them are kept."""


@dataclass(frozen=True, eq=False, slots=True)
class State:
    """A result with edits, what the solver said of them, and the doubts about it as far as they are known."""

    result: Result
    explanation: Explanation | None
    doubts: tuple[Doubt, ...] | None = None


class Recent:
    """The latest states by their edits."""

    def __init__(self) -> None:
        self._states: OrderedDict[tuple[Edit, ...], State] = OrderedDict()

    def find(self, edits: tuple[Edit, ...]) -> State | None:
        """The state with these edits; None where it was not shown lately."""
        if edits in self._states:
            self._states.move_to_end(edits)
        return self._states.get(edits)

    def keep(self, state: State) -> None:
        """This is the state of its edits."""
        self._states[state.result.edits] = state
        self._states.move_to_end(state.result.edits)
        while len(self._states) > KEPT:
            self._states.popitem(last=False)

    def learn(self, edits: tuple[Edit, ...], doubts: tuple[Doubt, ...]) -> None:
        """The doubts about a state are known now."""
        if edits in self._states:
            self._states[edits] = replace(self._states[edits], doubts=doubts)
