"""What a person asks for, as small frozen values; widgets post them, the session applies them."""

from __future__ import annotations

from splinescope.commands.edits import (
    AcceptEdits,
    ChooseTarget,
    DropProposal,
    EditCommand,
    EditSelected,
    GoToEdit,
    MatchGhost,
    MoveGhost,
    NextPiece,
    PickNext,
    PickPlace,
    ProposeEdits,
    Redo,
    SelectPieces,
    SettleDoubt,
    ShowDoubt,
    ShowWorst,
    StepDoubt,
    SwitchEdit,
    TakeUpEdits,
    TogglePiece,
    Undo,
)
from splinescope.commands.logs import (
    LogCommand,
    LogOpened,
    LogRefused,
    OpenLog,
)
from splinescope.commands.looking import (
    FollowLink,
    LayRuler,
    LeafThrough,
    Leave,
    LookFrom,
    LookingCommand,
    LookThere,
    Measure,
    Select,
    ShowClosure,
    ShowIteration,
    ShowObservation,
    ShowTab,
    StepIteration,
    StepObservation,
)
from splinescope.commands.playback import (
    ChangeSpeed,
    FollowProcessing,
    Pause,
    Play,
    PlaybackCommand,
    Seek,
    SeekMark,
    SeekTime,
    SetSpeed,
    Step,
    TogglePlay,
)
from splinescope.commands.preferences import (
    FollowRobot,
    NextColouring,
    PreferenceCommand,
    RobotUp,
    SeenTour,
    SetColouring,
    SetDark,
    SetLayer,
    ToggleLayers,
)
from splinescope.commands.work import (
    Cancel,
    Choose,
    CompareWith,
    DeleteResult,
    Optimise,
    RunAgain,
    ShowResult,
    WorkCommand,
)

Command = LogCommand | PlaybackCommand | PreferenceCommand | LookingCommand | WorkCommand | EditCommand
