"""What a person asks for, as small frozen values; widgets post them, the session applies them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from bspline_slam.edits.edit import Edit
from bspline_slam.measuring import Picked
from bspline_slam.scan import ScanLog
from splinescope.browser.link import Link
from splinescope.browser.values import Place
from splinescope.closures import ClosurePage
from splinescope.proposal import Picking
from splinescope.recipe import Recipe
from splinescope.subject import EditKind
from splinescope.view import Colouring, Layer, Piece, Selection


@dataclass(frozen=True, slots=True)
class OpenLog:
    """Read the log at `path` and process it; `title` is shown instead of the path's own name where given."""

    path: Path
    title: str | None = None


@dataclass(frozen=True, eq=False, slots=True)
class LogOpened:
    """The log asked for by `request` is readable."""

    request: OpenLog
    log: ScanLog


@dataclass(frozen=True, slots=True)
class LogRefused:
    """The log asked for by `request` cannot be read, and why."""

    request: OpenLog
    sentence: str


@dataclass(frozen=True, slots=True)
class Seek:
    """Show scan `index`; −1 is the last one."""

    index: int


@dataclass(frozen=True, slots=True)
class SeekTime:
    """Show the scan recorded `seconds` after the first one."""

    seconds: float


@dataclass(frozen=True, slots=True)
class Step:
    """Show the scan `by` further on, standing still."""

    by: int


@dataclass(frozen=True, slots=True)
class Play:
    """Play on."""


@dataclass(frozen=True, slots=True)
class Pause:
    """Stand still."""


@dataclass(frozen=True, slots=True)
class TogglePlay:
    """Play when standing, stand when playing."""


@dataclass(frozen=True, slots=True)
class SetSpeed:
    """Play at this multiple of real time."""

    speed: float


@dataclass(frozen=True, slots=True)
class ChangeSpeed:
    """Play faster (by = 1) or slower (by = −1)."""

    by: int


@dataclass(frozen=True, slots=True)
class FollowProcessing:
    """Keep the newest processed scan under the cursor."""

    on: bool


@dataclass(frozen=True, slots=True)
class FollowRobot:
    """Keep the robot in the middle of the picture."""

    on: bool


@dataclass(frozen=True, slots=True)
class RobotUp:
    """Turn the picture so that the robot drives upwards, or north up again; None changes to the other."""

    on: bool | None = None


@dataclass(frozen=True, slots=True)
class LookFrom:
    """The driver's page looks at this place; None: at the whole map."""

    place: Place | None


@dataclass(frozen=True, slots=True)
class ShowTab:
    """The driver's page shows these tabs: their names with commas between them."""

    name: str


@dataclass(frozen=True, slots=True)
class FollowLink:
    """Show the moment that a link names, standing still; once a log is open."""

    link: Link


@dataclass(frozen=True, slots=True)
class SeenTour:
    """Invite nobody to the guided tour any more."""


@dataclass(frozen=True, slots=True)
class SetLayer:
    """Show or hide one layer."""

    layer: Layer
    on: bool


@dataclass(frozen=True, slots=True)
class ToggleLayers:
    """Hide these layers if all of them are shown, show them otherwise."""

    layers: frozenset[Layer]


@dataclass(frozen=True, slots=True)
class SetColouring:
    """Colour the curves of the map by this."""

    colouring: Colouring


@dataclass(frozen=True, slots=True)
class NextColouring:
    """Colour the curves of the map by the thing `by` further on in the list."""

    by: int


@dataclass(frozen=True, slots=True)
class Select:
    """Look at one thing; None looks at nothing."""

    selection: Selection | None


@dataclass(frozen=True, slots=True)
class Leave:
    """Step back out of what is being done: put the ruler away, else nothing is selected any more."""


@dataclass(frozen=True, slots=True)
class Measure:
    """Take the ruler out, lay it to what is selected, or put it away when that was all."""


@dataclass(frozen=True, slots=True)
class LayRuler:
    """Measure from or to this thing."""

    picked: Picked


@dataclass(frozen=True, slots=True)
class ShowIteration:
    """Show the map at the iteration kept under this number; None: the result."""

    number: int | None


@dataclass(frozen=True, slots=True)
class StepIteration:
    """Show the map `by` kept iterations further on."""

    by: int


@dataclass(frozen=True, slots=True)
class ShowClosure:
    """Go to the later scan of the loop closure of this number, and look at the closure."""

    number: int


@dataclass(frozen=True, slots=True)
class LeafThrough:
    """Show this page of the list of loop closures."""

    page: ClosurePage


@dataclass(frozen=True, slots=True)
class ShowObservation:
    """Open or close the window that takes one observation apart; None changes to the other."""

    on: bool | None = None


@dataclass(frozen=True, slots=True)
class StepObservation:
    """Show the step of the observation `by` further on; opens its window first."""

    by: int


@dataclass(frozen=True, slots=True)
class SetDark:
    """Dark or light page; None changes to the other one."""

    dark: bool | None = None


@dataclass(frozen=True, slots=True)
class Choose:
    """Run with this model, estimator, order and knots from now on."""

    recipe: Recipe


@dataclass(frozen=True, slots=True)
class RunAgain:
    """Run over the whole log with the choices made."""


@dataclass(frozen=True, slots=True)
class Optimise:
    """Solve the map shown with the chosen back end."""


@dataclass(frozen=True, slots=True)
class ShowResult:
    """Show the result of this number."""

    number: int


@dataclass(frozen=True, slots=True)
class CompareWith:
    """Lay the result of this number over the one shown; None for none."""

    number: int | None


@dataclass(frozen=True, slots=True)
class DeleteResult:
    """Forget the result of this number."""

    number: int


@dataclass(frozen=True, slots=True)
class Cancel:
    """Stop what the estimator is doing; what it has done stays."""


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
class SeekMark:
    """Go to the next mark of a kind on the timeline (by = 1), or to the one before (by = −1)."""

    kind: str
    by: int


@dataclass(frozen=True, slots=True)
class LookThere:
    """Let the page that asks look at what is selected, or at the scan shown."""


@dataclass(frozen=True, slots=True)
class ShowWorst:
    """Go to the residual of this place in the list of the worst."""

    number: int


Command = (
    OpenLog
    | LogOpened
    | LogRefused
    | Seek
    | SeekTime
    | Step
    | Play
    | Pause
    | TogglePlay
    | SetSpeed
    | ChangeSpeed
    | FollowProcessing
    | FollowRobot
    | RobotUp
    | LookFrom
    | ShowTab
    | FollowLink
    | SeenTour
    | SetLayer
    | ToggleLayers
    | SetColouring
    | NextColouring
    | Select
    | Leave
    | Measure
    | LayRuler
    | ShowIteration
    | StepIteration
    | ShowClosure
    | LeafThrough
    | ShowObservation
    | StepObservation
    | SetDark
    | Choose
    | RunAgain
    | Optimise
    | ShowResult
    | CompareWith
    | DeleteResult
    | Cancel
    | EditSelected
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
    | SeekMark
    | LookThere
    | ShowWorst
)
