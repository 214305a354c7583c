"""Who answers hand edits, and where results with them are shown, as seen from those who edit."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from jaxtyping import Float

from bspline_slam.edits.edit import Edit
from bspline_slam.slam import SlamConfig
from splinescope.computing.edit_messages import Ghost
from splinescope.result import Result


class Answering(Protocol):
    """Who answers edits: the editor's process, seen from here."""

    def prepare(self, kept: bytes, config: SlamConfig) -> int: ...
    def preview(self, in_force: tuple[Edit, ...], proposed: tuple[Edit, ...]) -> int: ...
    def make(self, edits: tuple[Edit, ...], shown: tuple[Edit, ...]) -> int: ...
    def match(self, in_force: tuple[Edit, ...], earlier: int, scan: int, guess: Float[np.ndarray, "3"]) -> int: ...
    def hand_over(self, edits: tuple[Edit, ...]) -> int: ...
    def cancel(self) -> None: ...


class Nobody:
    """Where there is no editor's process: nothing is ever answered."""

    def prepare(self, kept: bytes, config: SlamConfig) -> int:
        return 0

    def preview(self, in_force: tuple[Edit, ...], proposed: tuple[Edit, ...]) -> int:
        return 0

    def make(self, edits: tuple[Edit, ...], shown: tuple[Edit, ...]) -> int:
        return 0

    def match(self, in_force: tuple[Edit, ...], earlier: int, scan: int, guess: Float[np.ndarray, "3"]) -> int:
        return 0

    def hand_over(self, edits: tuple[Edit, ...]) -> int:
        return 0

    def cancel(self) -> None:
        """Nothing runs."""


class Show(Protocol):
    """Where results with edits are shown."""

    def amend(self, result: Result) -> None:
        """This is the result of its number from now on."""
        ...

    def glimpse(self, ghost: Ghost) -> None:
        """What the map nearly becomes."""
        ...

    def handed(self, number: int, edits: tuple[Edit, ...], amended: bytes) -> None:
        """The result of this number with these edits, packed for the estimator."""
        ...
