"""One thread for dense products.

They are too small to share, and threads that wait for each other on a busy machine made a factor take fifty times
as long as one thread alone. The number of threads changes the last digits, too: what is done within it from beginning
to end gives the same on any number of cores.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import cache, wraps
from typing import ParamSpec, TypeVar

from threadpoolctl import ThreadpoolController

Arguments = ParamSpec("Arguments")
Returned = TypeVar("Returned")


def single_thread() -> AbstractContextManager[object]:
    """Context in which dense linear algebra runs in the calling thread."""
    return _controller().limit(limits=1, user_api="blas")


def in_one_thread(function: Callable[Arguments, Returned]) -> Callable[Arguments, Returned]:
    """The function, with its dense linear algebra in the calling thread."""

    @wraps(function)
    def inside(*args: Arguments.args, **named: Arguments.kwargs) -> Returned:
        with single_thread():
            return function(*args, **named)

    return inside


@cache
def _controller() -> ThreadpoolController:
    """Knows the libraries loaded by now; made once, for the look-up takes milliseconds."""
    return ThreadpoolController()
