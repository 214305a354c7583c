"""The legend: samples of every style, drawn from the same tables as the scene."""

from __future__ import annotations

from bspline_slam.segmentation import EndKind
from splinescope.grades import WIDTHS, Scale
from splinescope.palette import (
    COMPARED_HUE,
    GREEN,
    GREY,
    PURPLE,
    SKY,
    VERDICT_STYLES,
    VERMILION,
    YELLOW,
    Colour,
    Glyph,
    LineStyle,
    Theme,
    hexadecimal,
)
from splinescope.scene.scan_layers import END_GLYPHS
from splinescope.scene.strokes import glyph_shape

Section = dict[str, object]

END_LABELS = {
    EndKind.EDGE: "The thing ends here",
    EndKind.OCCLUDED: "Hidden from here on",
    EndKind.CORNER: "Corner",
    EndKind.NO_RETURN: "No return beyond",
    EndKind.FIELD_OF_VIEW: "The scan ends here",
}


def legend(theme: Theme, scale: Scale | None = None) -> list[Section]:
    """Sections for the page: a title, and entries of a label and a small drawing; a scale that curves are coloured by
    comes first."""
    verdicts = [
        _entry(style.label, _line(theme.legible(style.hue), style.line) + _glyph(theme.legible(style.hue), style.glyph))
        for style in VERDICT_STYLES.values()
    ]
    verdicts.append(_entry("Decided by hand", _glyph(theme.legible(PURPLE), Glyph.DIAMOND, 6.0)))
    quiet = theme.legible(theme.faint(theme.ink, 0.42))
    paths = [
        _entry("Estimate", _line(quiet, LineStyle.SOLID)),
        _entry("Odometry", _line(theme.legible(GREY), LineStyle.DASHED)),
        _entry("Truth", _line(theme.legible(GREEN), LineStyle.DOTTED)),
        _entry("Loop accepted", _line(theme.legible(PURPLE), LineStyle.SOLID)),
        _entry("Loop rejected", _line(theme.legible(VERMILION), LineStyle.SOLID, gap=True)),
    ]
    hues = "".join(_line(theme.spline(i), LineStyle.SOLID, x=1 + 11 * i, length=9.0) for i in range(3))
    shapes = [
        _entry("Map splines, hue by id" if theme.one_hue is None else "Shown result", hues),
        _entry("Compared result", _line(theme.legible(COMPARED_HUE), LineStyle.DASHED)),
        _entry("Proposed by hand", _line(theme.legible(PURPLE), LineStyle.DASHED)),
        _entry("Pinned by hand", _glyph(theme.legible(PURPLE), Glyph.PIN, 7.0)),
        _entry(
            "Loop closed by hand",
            _line(theme.legible(PURPLE), LineStyle.SOLID) + _glyph(theme.legible(PURPLE), Glyph.DIAMOND, 5.0),
        ),
        _entry("Control point", _glyph(theme.spline(0), Glyph.SQUARE, 3.5)),
        _entry("2σ ellipse (86 %)", _ellipse(theme.legible(SKY))),
        _entry("Impossible covariance", _glyph(theme.legible(VERMILION), Glyph.WARNING)),
    ]
    yellow = theme.legible(YELLOW)
    endings = [_entry(END_LABELS[kind], _glyph(yellow, glyph)) for kind, glyph in END_GLYPHS.items()]
    return [
        *([{"title": scale.title, "entries": grades(theme, scale)}] if scale is not None else []),
        {"title": "Associations", "entries": verdicts},
        {"title": "Map", "entries": shapes if scale is None else shapes[1:]},
        {"title": "Paths", "entries": paths},
        {"title": "Ends of segments", "entries": endings},
    ]


def grades(theme: Theme, scale: Scale) -> list[dict[str, str]]:
    """Entries for the grades of a scale, each in its colour and its width."""
    known = [
        _entry(label, _line(theme.graded(number), LineStyle.SOLID, width=width))
        for number, (label, width) in enumerate(zip(scale.labels, WIDTHS, strict=True))
    ]
    return known + ([_entry(scale.unknown, _line(theme.spline(0), LineStyle.DOTTED))] if scale.unknown else [])


def _entry(label: str, drawing: str) -> dict[str, str]:
    return {"label": label, "svg": f'<svg viewBox="0 0 34 14" aria-hidden="true">{drawing}</svg>'}


def _line(
    colour: Colour, style: LineStyle, x: float = 1.0, length: float = 32.0, gap: bool = False, width: float = 2.0
) -> str:
    dashes = "12 8" if gap else " ".join(f"{part:g}" for part in style.pattern)
    return (
        f'<path d="M{x:g} 7h{length:g}" fill="none" stroke="{hexadecimal(colour)}" '
        f'stroke-width="{width:g}" stroke-dasharray="{dashes}"/>'
    )


def _glyph(colour: Colour, glyph: Glyph, radius: float = 4.5) -> str:
    path = "".join(
        f"M{17 + radius * a[0]:.1f} {7 - radius * a[1]:.1f}L{17 + radius * b[0]:.1f} {7 - radius * b[1]:.1f}"
        for a, b in glyph_shape(glyph)
    )
    return f'<path d="{path}" fill="none" stroke="{hexadecimal(colour)}" stroke-width="1.6" stroke-linecap="round"/>'


def _ellipse(colour: Colour) -> str:
    return f'<ellipse cx="17" cy="7" rx="9" ry="4" fill="none" stroke="{hexadecimal(colour)}" stroke-width="1.6"/>'
