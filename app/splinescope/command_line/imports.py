"""Imports that last."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def lasting() -> Iterator[None]:
    """What is imported inside lives as long as the program, so the garbage collector need not look through it, neither
    while it is loaded nor ever after: there are more of these objects than a log ever makes."""
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()
