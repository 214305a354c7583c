"""One thread for the dense products inside sparse factors.

They are too small to share, and threads that wait for each other on a busy machine made a factor take fifty times
as long as one thread alone.
"""

from __future__ import annotations

from contextlib import AbstractContextManager
from functools import cache

from threadpoolctl import ThreadpoolController


def single_thread() -> AbstractContextManager[object]:
    """Context in which dense linear algebra runs in the calling thread."""
    return _controller().limit(limits=1, user_api="blas")


@cache
def _controller() -> ThreadpoolController:
    """Knows the libraries loaded by now; made once, for the look-up takes milliseconds."""
    return ThreadpoolController()
