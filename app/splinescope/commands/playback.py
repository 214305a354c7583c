"""Which scan is shown, and how playback goes."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Seek:
    """Show scan `index`; −1 is the last one."""

    index: int


@dataclass(frozen=True, slots=True)
class SeekTime:
    """Show the scan recorded `seconds` after the first one."""

    seconds: float


@dataclass(frozen=True, slots=True)
class SeekMark:
    """Go to the next mark of a kind on the timeline (by = 1), or to the one before (by = −1)."""

    kind: str
    by: int


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


PlaybackCommand = (
    Seek | SeekTime | SeekMark | Step | Play | Pause | TogglePlay | SetSpeed | ChangeSpeed | FollowProcessing
)
