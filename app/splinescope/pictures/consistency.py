"""A test of consistency over the scans of a log, as a picture and in words."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from bspline_slam.lab.scan_test import ScanTest
from splinescope.palette import BLUE, GREEN, GREY, VERMILION, Theme
from splinescope.pictures import drawing
from splinescope.pictures.drawing import WIDTH, Axes

HEIGHT = 150.0
LEFT, TOP, BOTTOM = 34.0, 8.0, 124.0
LEAST, MOST = 1e-2, 1e4
"""What lies beyond these is drawn at the edge."""


def scan_test_picture(test: ScanTest, cursor: int, name: str, theme: Theme) -> str:
    """Each key scan as a dot over its number, on a logarithmic scale, the band behind it and the cursor's scan marked.

    Dots above the band are hollow circles in another colour, those below it small crosses.
    """
    axes = _axes(test)
    values, bands = np.clip(test.normalised, LEAST, MOST), np.clip(test.bands, LEAST, MOST)
    above, below = test.normalised > test.bands[:, 1], test.normalised < test.bands[:, 0]
    placed = _placed(axes, test, values)
    parts = [
        drawing.area(_outline(axes, test, bands), theme.legible(BLUE), 0.28),
        *_scale(axes, theme),
        _cursor(axes, test, cursor, theme),
        drawing.dots(placed[~above & ~below], theme.legible(GREEN), 2.0),
        drawing.dots(placed[above], theme.legible(VERMILION), 3.2, hollow=True),
        _crosses(placed[below], theme),
        *_numbers(test),
    ]
    return drawing.picture(parts, HEIGHT, f"{name} of key scans against the 95 % band: {in_words(test)}")


def in_words(test: ScanTest) -> str:
    """The share inside the band, and on which side the others lie."""
    high = int(np.sum(test.normalised > test.bands[:, 1]))
    low = len(test.scans) - high - int(np.sum(test.inside))
    share = f"{int(np.sum(test.inside))} of {len(test.scans)} key scans ({np.mean(test.inside):.0%}) lie inside"
    rest = [f"{count} {where}" for count, where in ((high, "above"), (low, "below")) if count]
    return f"{share}, {' and '.join(rest)} it." if rest else f"{share}."


def next_outside(test: ScanTest, cursor: int) -> int | None:
    """The next scan after the cursor's that lies above its band, from the start again after the last one."""
    outside = test.scans[test.normalised > test.bands[:, 1]]
    if not len(outside):
        return None
    return int(outside[np.searchsorted(outside, cursor, side="right") % len(outside)])


def _axes(test: ScanTest) -> Axes:
    values = np.clip(np.concatenate([test.normalised, test.bands.ravel()]), LEAST, MOST)
    low, high = np.floor(np.log10(values.min())), max(np.ceil(np.log10(values.max())), 1.0)
    first, last = int(test.scans[0]), max(int(test.scans[-1]), int(test.scans[0]) + 1)
    return Axes((first, float(low)), (last, float(high)), (LEFT, TOP, WIDTH - 8.0, BOTTOM))


def _placed(axes: Axes, test: ScanTest, values: Float[np.ndarray, "n"]) -> Float[np.ndarray, "n 2"]:
    return axes.at(np.column_stack([test.scans.astype(float), np.log10(values)]))


def _outline(axes: Axes, test: ScanTest, bands: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "m 2"]:
    return np.concatenate([_placed(axes, test, bands[:, 0]), _placed(axes, test, bands[:, 1])[::-1]])


def _scale(axes: Axes, theme: Theme) -> list[str]:
    """Powers of ten up the side; 1 as a line of its own."""
    parts = []
    for power in range(int(axes.low[1]), int(axes.high[1]) + 1):
        line = axes.at(np.array([[axes.low[0], power], [axes.high[0], power]], dtype=float))
        parts.append(drawing.path(line, theme.faint(GREY, 0.9 if power == 0 else 0.4), 1.2 if power == 0 else 0.7))
        parts.append(drawing.words(f"{10.0**power:g}", LEFT - 5.0, line[0, 1] + 3.5, anchor="end", dim=True))
    return parts


def _cursor(axes: Axes, test: ScanTest, cursor: int, theme: Theme) -> str:
    if not test.scans[0] <= cursor <= test.scans[-1]:
        return ""
    line = axes.at(np.array([[cursor, axes.low[1]], [cursor, axes.high[1]]], dtype=float))
    return drawing.path(line, theme.ink, 1.0)


def _crosses(points: Float[np.ndarray, "n 2"], theme: Theme) -> str:
    arms = np.array([[-2.5, -2.5], [2.5, 2.5]]), np.array([[-2.5, 2.5], [2.5, -2.5]])
    return "".join(drawing.path(point + arm, theme.legible(GREY), 1.3) for point in points for arm in arms)


def _numbers(test: ScanTest) -> list[str]:
    y = BOTTOM + 15.0
    return [
        drawing.words(f"scan {test.scans[0]:,}", LEFT, y, dim=True),
        drawing.words(f"scan {test.scans[-1]:,}", WIDTH - 8.0, y, anchor="end", dim=True),
    ]
