"""Text as it is to be read: true minus signs, and units that do not leave their numbers."""

from __future__ import annotations

import re

THIN = "\u202f"
"""A narrow space at which no line is broken."""
MINUS = re.compile(r"(?<![\w.,)\]\-–])-(?=\d)")
UNIT = re.compile(r"(?<=\d)( ?)(%|(?<= )(?:mm|cm|m|km|m²|ms|s|min|h|σ|kB|MB)\b)")


def typeset(text: str) -> str:
    """A sentence or a value with typographic minus signs, and with thin spaces between numbers and their units."""
    return UNIT.sub(rf"{THIN}\2", MINUS.sub("−", text))
