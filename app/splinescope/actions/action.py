"""What a person can ask for, as one value: its words, its keys, what it does, and when it cannot be done."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from splinescope.commands import Command
from splinescope.session import NO_LOG, Session


class PageRequest(Enum):
    """What concerns one page, not the session."""

    SCRIPT = "the page's own script does it, by the id of the action"
    ASK = "the page asks the question of the action, and tells the answer"
    FIT = "show the whole map"
    FIT_SCAN = "show the current scan"
    TAKE_CONTROL = "drive from this page"
    LINK = "copy a link to this moment"
    TOUR = "take, go through or leave the guided tour"


@dataclass(frozen=True, slots=True)
class Perform:
    """A person asks for the action of this id."""

    action: str


@dataclass(frozen=True, slots=True)
class Answer:
    """A person has answered the question of the action of this id."""

    action: str
    text: str


@dataclass(frozen=True, slots=True)
class Question:
    """What an action has to know before it is done: the `label` of a field and an `example` of what belongs there, or
    one of the `choices`. `command` is made of the answer; it raises SplineSlamError where that makes no sense."""

    label: str
    command: Callable[[str], Command]
    example: str = ""
    choices: tuple[str, ...] = ()


Request = Command | PageRequest
"""What an action does."""


def always(session: Session) -> str | None:
    """The refusal of an action that can always be done."""
    return None


def with_log(session: Session) -> str | None:
    """The refusal of an action that needs a log."""
    return NO_LOG if session.log is None else None


@dataclass(frozen=True, slots=True)
class Action:
    """One row of the table.

    `words` say what it does, as on a button; `keys` are the names of keys as the page reports them ("ArrowRight",
    "Shift+ArrowRight", " ", "f", "F" for Shift and f, "Ctrl+z"). `does` is a command, a request to the page, or a
    function of the session that makes one. `refusal` says in one sentence why it cannot be done now; None if it can.
    A held key does an action again and again only where it `repeats`. One that `asks` first does `PageRequest.ASK`.
    """

    id: str
    words: str
    keys: tuple[str, ...]
    does: Request | Callable[[Session], Request]
    refusal: Callable[[Session], str | None] = always
    repeats: bool = False
    asks: Question | None = None

    def request(self, session: Session) -> Request:
        """What to do now."""
        return self.does(session) if callable(self.does) else self.does

    @property
    def own(self) -> bool:
        """Whether it concerns nobody but the page that asks."""
        return isinstance(self.does, PageRequest) and self.does is not PageRequest.TOUR

    @property
    def shown(self) -> str:
        """Its keys as a person reads them: `→ or .`; empty for an action without a key."""
        return " or ".join(map(key_in_words, self.keys))


KEY_WORDS = {
    " ": "Space",
    "ArrowRight": "→",
    "ArrowLeft": "←",
    "ArrowUp": "↑",
    "ArrowDown": "↓",
    "Escape": "Esc",
    "-": "−",
}


def key_in_words(name: str) -> str:
    """The name of a key as it is written for a person: `Ctrl + Z`, `Shift + F`, `→`."""
    *modifiers, key = name.split("+") if len(name) > 1 else [name]
    if len(key) == 1 and key.isalpha() and key.isupper() and not modifiers:
        modifiers = ["Shift"]
    return " + ".join([*modifiers, KEY_WORDS.get(key, key.upper() if len(key) == 1 else key)])
