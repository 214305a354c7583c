"""A result on its way back to the estimator: packed, for it is too large to be unpacked in the page."""

from __future__ import annotations

from dataclasses import dataclass

from bspline_slam.edits.edit import Edit
from bspline_slam.slam import SlamConfig

SENT_BEFORE = b""
"""Instead of a snapshot that is `kept`: that of the last request which had one."""


@dataclass(frozen=True, eq=False, slots=True)
class PackedResult:
    """The pickled snapshot as the estimator `kept` it, the configuration to go on with, and the hand `edits` that are
    to be in it. `amended` is the result with these as the editor packed it; None where it was sent before, or where the
    estimator has to make the edits itself."""

    kept: bytes
    config: SlamConfig
    edits: tuple[Edit, ...] = ()
    amended: bytes | None = None
