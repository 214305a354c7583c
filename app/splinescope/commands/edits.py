"""Hand edits: proposed, accepted, taken back; and the doubts that lead to them."""

from __future__ import annotations

from dataclasses import dataclass

from bspline_slam.edits.edit import Edit
from splinescope.edits.proposal import Picking
from splinescope.edits.subject import EditKind
from splinescope.view import Piece


@dataclass(frozen=True, slots=True)
class EditSelected:
    """Propose an edit of this kind of what is selected."""

    kind: EditKind


@dataclass(frozen=True, slots=True)
class ProposeEdits:
    """Look at what these edits would do."""

    edits: tuple[Edit, ...]


@dataclass(frozen=True, slots=True)
class ChooseTarget:
    """The spline that what is selected is to be given to or merged with: the one `by` further on among those near it,
    or the spline of this id."""

    by: int = 0
    spline: int | None = None


@dataclass(frozen=True, slots=True)
class NextPiece:
    """Look at the piece of the selected segment `by` further on."""

    by: int


@dataclass(frozen=True, slots=True)
class SelectPieces:
    """Look at these pieces of the key scan shown, to edit all of them at once."""

    pieces: tuple[Piece, ...]


@dataclass(frozen=True, slots=True)
class TogglePiece:
    """Look at this piece of the key scan too, or no longer."""

    piece: Piece


@dataclass(frozen=True, slots=True)
class PickNext:
    """Let the next click in the map choose something for an edit; None: it selects as ever."""

    what: Picking | None


@dataclass(frozen=True, slots=True)
class PickPlace:
    """A place in the map was clicked while something was to be chosen there (m; what is near it counts)."""

    x: float
    y: float
    near: float


@dataclass(frozen=True, slots=True)
class AcceptEdits:
    """Make the proposed edits."""


@dataclass(frozen=True, slots=True)
class DropProposal:
    """Do not make the proposed edits."""


@dataclass(frozen=True, slots=True)
class Undo:
    """Take back the last action."""


@dataclass(frozen=True, slots=True)
class Redo:
    """Do again what was taken back."""


@dataclass(frozen=True, slots=True)
class GoToEdit:
    """Go to the state after so many actions."""

    cursor: int


@dataclass(frozen=True, slots=True)
class SwitchEdit:
    """Put an action out of force, or into force again; None changes to the other."""

    number: int
    on: bool | None = None


@dataclass(frozen=True, slots=True)
class TakeUpEdits:
    """Go on with the edits from before, or set them aside."""

    on: bool


@dataclass(frozen=True, slots=True)
class MoveGhost:
    """Shift the ghost scan (m) and turn it (rad)."""

    x: float = 0.0
    y: float = 0.0
    turn: float = 0.0


@dataclass(frozen=True, slots=True)
class MatchGhost:
    """Let the scan matcher place the ghost scan, and propose the loop closure."""


@dataclass(frozen=True, slots=True)
class StepDoubt:
    """Look at the doubtful decision `by` further on."""

    by: int


@dataclass(frozen=True, slots=True)
class ShowDoubt:
    """Look at the doubtful decision of this number."""

    number: int


@dataclass(frozen=True, slots=True)
class SettleDoubt:
    """The doubtful decision looked at is right, or is to be overruled."""

    right: bool


@dataclass(frozen=True, slots=True)
class ShowWorst:
    """Go to the residual of this place in the list of the worst."""

    number: int


EditCommand = (
    EditSelected
    | ProposeEdits
    | ChooseTarget
    | NextPiece
    | SelectPieces
    | TogglePiece
    | PickNext
    | PickPlace
    | AcceptEdits
    | DropProposal
    | Undo
    | Redo
    | GoToEdit
    | SwitchEdit
    | TakeUpEdits
    | MoveGhost
    | MatchGhost
    | StepDoubt
    | ShowDoubt
    | SettleDoubt
    | ShowWorst
)
