"""Colours, line styles and glyphs: one meaning each, legible on dark and on light, never told by hue alone.

The hues are those of Okabe and Ito (2008), which people with any colour vision can tell apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import cache

import numpy as np
from jaxtyping import Float, UInt8

from bspline_slam.association import Verdict

Colour = UInt8[np.ndarray, "3"]


def _rgb(text: str) -> Colour:
    return np.frombuffer(bytes.fromhex(text), dtype=np.uint8)


ORANGE, SKY, GREEN, YELLOW = _rgb("E69F00"), _rgb("56B4E9"), _rgb("009E73"), _rgb("F0E442")
BLUE, VERMILION, PURPLE = _rgb("0072B2"), _rgb("D55E00"), _rgb("CC79A7")
GREY = _rgb("8A949E")
SHOWN_HUE, COMPARED_HUE = SKY, ORANGE
"""Two results over one another: one hue each."""
RAMP_ON_DARK = tuple(map(_rgb, ("62656F", "838179", "A99F73", "D4C15F", "FEE838")))
RAMP_ON_LIGHT = tuple(map(_rgb, ("948E77", "737475", "52596D", "273E6E", "00224E")))
"""From quiet to loud in steps that any colour vision can tell: cividis (Nuñez, Anderton and Renslow 2018)."""
SPLINE_HUES = (SKY, ORANGE, GREEN, PURPLE, BLUE, YELLOW, VERMILION)
MINIMUM_CONTRAST = 3.0  # WCAG 2.2, 1.4.11: what graphics need against their background


class LineStyle(Enum):
    """How a line is broken."""

    SOLID = "solid"
    DASHED = "dashed"
    DOTTED = "dotted"
    DASH_DOT = "dash-dot"

    @property
    def pattern(self) -> tuple[float, ...]:
        """Lengths of ink and gap in pixels; empty for a line without gaps."""
        return _PATTERNS.get(self, ())


_PATTERNS = {
    LineStyle.DASHED: (12.0, 8.0),
    LineStyle.DOTTED: (2.5, 4.5),
    LineStyle.DASH_DOT: (11.0, 4.0, 2.5, 4.0),
}


class Glyph(Enum):
    """Small signs of constant size on the screen."""

    CIRCLE = "circle"
    CHEVRONS = "chevrons"
    PLUS = "plus"
    CROSS = "cross"
    BAR = "bar"
    DIAMOND = "diamond"
    SQUARE = "square"
    CORNER = "corner"
    OPEN = "open"
    FAN = "fan"
    WARNING = "warning"
    PIN = "pin"


@dataclass(frozen=True, eq=False, slots=True)
class Style:
    """What one state looks like: hue, line and glyph differ between any two states."""

    label: str
    hue: Colour
    line: LineStyle
    glyph: Glyph


VERDICT_STYLES: dict[Verdict, Style] = {
    Verdict.MATCHED: Style("Matched", GREEN, LineStyle.SOLID, Glyph.CIRCLE),
    Verdict.EXTENDED: Style("Extended", SKY, LineStyle.DASH_DOT, Glyph.CHEVRONS),
    Verdict.NEW: Style("New", ORANGE, LineStyle.DOTTED, Glyph.PLUS),
    Verdict.GATED: Style("Gated out", VERMILION, LineStyle.DASHED, Glyph.CROSS),
    Verdict.IGNORED: Style("Ignored", GREY, LineStyle.DOTTED, Glyph.BAR),
}


@dataclass(frozen=True, eq=False, slots=True)
class Theme:
    """The ground that everything is drawn on, the ink that stands out from it most, and the one hue of all splines
    while two results are compared or grades are coloured.

    `spread` multiplies the contrast that each hue has by nature: on a light ground hues that are all brought to the
    same contrast would have the same lightness, and people who see fewer hues could not tell them apart.
    """

    background: Colour
    ink: Colour
    one_hue: Colour | None = None
    spread: float = 1.0

    def legible(self, hue: Colour, contrast: float = MINIMUM_CONTRAST) -> Colour:
        """The hue, moved towards the ink just as far as this contrast with the background asks for."""
        asked = max(contrast, self.spread * contrast_ratio(hue, self.background))
        return _legible(hue.tobytes(), self.background.tobytes(), self.ink.tobytes(), asked)

    def faint(self, hue: Colour, strength: float) -> Colour:
        """The hue as if drawn with this opacity (0…1) on the background."""
        return mix(self.background, hue, strength)

    def spline(self, spline_id: int) -> Colour:
        """The colour of a spline: from its id alone, so that no edit ever changes it; of all, where they share one."""
        if self.one_hue is not None:
            return self.legible(self.one_hue)
        hue = SPLINE_HUES[spline_id % len(SPLINE_HUES)]
        tint = (0.0, 0.28, 0.14)[spline_id // len(SPLINE_HUES) % 3]
        return self.legible(mix(hue, self.ink, tint))

    def splines(self, ids: Sequence[int]) -> UInt8[np.ndarray, "n 3"]:
        """The colours of many splines."""
        every = np.array([self.spline(number) for number in range(3 * len(SPLINE_HUES))])
        return every[np.asarray(ids, dtype=int) % len(every)]

    def graded(self, grade: int) -> Colour:
        """One of five colours: the higher the grade, the more it stands out from the ground."""
        dark = luminance(self.background) < luminance(self.ink)
        return (RAMP_ON_DARK if dark else RAMP_ON_LIGHT)[grade]

    def verdict(self, verdict: Verdict) -> Colour:
        """The hue of a decision on an association."""
        return self.legible(VERDICT_STYLES[verdict].hue)


@cache
def _legible(hue: bytes, background: bytes, ink: bytes, contrast: float) -> Colour:
    colour, ground, most = (np.frombuffer(c, dtype=np.uint8) for c in (hue, background, ink))
    mixtures = (mix(colour, most, float(share)) for share in np.linspace(0.0, 1.0, 41))
    return next((mixture for mixture in mixtures if contrast_ratio(mixture, ground) >= contrast), most)


DARK = Theme(_rgb("0D1218"), _rgb("F2F5F8"))
LIGHT = Theme(_rgb("F7F8F9"), _rgb("17212B"), spread=1.3)
DARK_COMPARING, LIGHT_COMPARING = (replace(ground, one_hue=SHOWN_HUE) for ground in (DARK, LIGHT))
DARK_GRADING, LIGHT_GRADING = (replace(ground, one_hue=GREY) for ground in (DARK, LIGHT))


def theme(dark: bool, comparing: bool = False, grading: bool = False) -> Theme:
    """The theme that goes with the page, with a second result over the one shown, with grades in colour."""
    if grading:
        return DARK_GRADING if dark else LIGHT_GRADING
    if comparing:
        return DARK_COMPARING if dark else LIGHT_COMPARING
    return DARK if dark else LIGHT


def mix(a: Colour, b: Colour, share: float) -> Colour:
    """From a (share 0) to b (share 1), in the colour space of the screen."""
    return np.rint((1.0 - share) * a.astype(float) + share * b.astype(float)).astype(np.uint8)


def luminance(colour: Colour) -> float:
    """Relative luminance of an sRGB colour, 0 (black) to 1 (white) (WCAG 2.2)."""
    value: Float[np.ndarray, "3"] = colour.astype(float) / 255.0
    linear = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    return float(linear @ np.array([0.2126, 0.7152, 0.0722]))


def contrast_ratio(a: Colour, b: Colour) -> float:
    """Contrast of two colours, 1 (none) to 21 (black on white) (WCAG 2.2)."""
    low, high = sorted((luminance(a), luminance(b)))
    return (high + 0.05) / (low + 0.05)


def hexadecimal(colour: Colour) -> str:
    """The colour as style sheets write it: #rrggbb."""
    return "#" + colour.tobytes().hex()
