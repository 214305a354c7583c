"""Who asks: the page whose person caused what this thread is doing just now."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_ASKER: ContextVar[int | None] = ContextVar("asker", default=None)


@contextmanager
def asked_by(client: int) -> Iterator[None]:
    """While it lasts, whatever this thread posts was asked for in the page of this client."""
    token = _ASKER.set(client)
    try:
        yield
    finally:
        _ASKER.reset(token)


def asker() -> int | None:
    """The client whose person asks; None where the program itself acts."""
    return _ASKER.get()
