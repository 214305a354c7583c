"""A sentence that has to reach the person now."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Notice:
    """Shown at once; `bad` if something went wrong, then it also stays readable. `client`: in this page alone."""

    title: str
    text: str
    bad: bool = False
    client: int | None = None
