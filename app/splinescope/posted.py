"""What arrives at the owner of the session: what people do in pages, what processes send, what the program asks."""

from __future__ import annotations

import threading
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from splinescope import commands as ask
from splinescope.actions import Answer, Perform
from splinescope.browser.values import Place
from splinescope.computing.messages import Message


@dataclass(frozen=True, eq=False, slots=True)
class Click:
    """A person clicked the map at `point` (world frame); with Shift what is there `adds` to what is selected."""

    point: Float[np.ndarray, "2"]
    metres_per_pixel: float
    adds: bool = False


@dataclass(frozen=True, eq=False, slots=True)
class Box:
    """A person drew a rectangle with these `corners`, in order round it (world frame)."""

    corners: Float[np.ndarray, "4 2"]


@dataclass(frozen=True, slots=True)
class PageMoved:
    """Some page sees another part of the world, or a new page has come."""


@dataclass(frozen=True, slots=True)
class Hello:
    """A page has come that calls itself `name`; `query` stands behind its address. It is `back` where it was here
    before its connection was lost, and looked at `place` then (None: at what it was made to see)."""

    name: str
    query: str
    back: bool = False
    place: Place | None = None


@dataclass(frozen=True, slots=True)
class Goodbye:
    """The page of this client has left."""

    client: int


@dataclass(frozen=True, eq=False, slots=True)
class Barrier:
    """`passed` is set when all that was posted before is done."""

    passed: threading.Event


@dataclass(frozen=True, eq=False, slots=True)
class FromEditor:
    """What the editor's process sent."""

    message: Message


Posted = ask.Command | Perform | Answer | Click | Box | PageMoved | Hello | Goodbye | Barrier | Message | FromEditor


@dataclass(frozen=True, eq=False, slots=True)
class Arrival:
    """Something posted, and the client whose person asked for it (None: the program itself)."""

    item: Posted
    client: int | None
