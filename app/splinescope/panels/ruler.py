"""The ruler: distance and angle between two picked things, each with its 1σ."""

from __future__ import annotations

import numpy as np

from bspline_slam.measuring import Measurement
from splinescope import table
from splinescope.ruler import Ruler, in_words

FIRST = "Click the first thing: a place on a curve, a control point or a key pose. With keys: select, then Shift + M."
SECOND = "Now the second thing."
MEANING = "σ is that of the joint covariance: what two things have in common does not count. Esc puts the ruler away."


def reading(ruler: Ruler) -> list[str]:
    """What is picked and what was found, as HTML parts."""
    names = zip(("from", "to"), map(in_words, ruler.picked), strict=False)
    parts = [table.heading("Ruler"), table.pairs(list(names))]
    if ruler.first is None:
        return [parts[0], table.paragraph(FIRST)]
    if ruler.second is None:
        return [*parts, table.paragraph(SECOND)]
    match ruler.found:
        case None:
            return [*parts, table.paragraph("Measuring…")]
        case str(reason):
            return [*parts, table.paragraph(reason, "bad")]
        case found:
            return [*parts, table.pairs(figures(found)), table.paragraph(MEANING, "dim")]


def figures(found: Measurement) -> list[tuple[str, str]]:
    """The reading with its standard deviations."""
    sigma = "" if found.distance_sigma is None else f" ± {1000 * found.distance_sigma:.1f} mm (1σ)"
    rows = [("distance", f"{found.distance:.4f} m{sigma}")]
    if found.angle is not None and found.angle_sigma is not None:
        rows.append(("angle", f"{np.degrees(found.angle):.2f}° ± {np.degrees(found.angle_sigma):.2f}° (1σ)"))
    return rows
