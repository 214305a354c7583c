"""What commands about time do to the clock of the timeline."""

from __future__ import annotations

from splinescope import commands as ask
from splinescope.playback import Playback

ClockCommand = ask.Seek | ask.Step | ask.Play | ask.Pause | ask.TogglePlay | ask.SetSpeed | ask.ChangeSpeed
"""Commands that the clock alone can follow."""


def played(playback: Playback, command: ClockCommand, now: float) -> Playback:
    """The clock after a command at `now` (s)."""
    match command:
        case ask.Seek(index=index):
            return playback.seek(index if index >= 0 else playback.count + index, now)
        case ask.Step(by=by):
            return playback.step(by, now)
        case ask.Play():
            return playback.play(now)
        case ask.Pause():
            return playback.pause(now)
        case ask.TogglePlay():
            return playback.toggled(now)
        case ask.SetSpeed(speed=speed):
            return playback.with_speed(speed, now)
        case ask.ChangeSpeed(by=by):
            return playback.faster(by, now)
