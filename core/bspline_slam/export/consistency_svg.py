"""Consistency as a drawing: each figure as a dot beside its acceptance band, and pose errors over the drive."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from math import isfinite
from pathlib import Path

from bspline_slam.lab.consistency_table import POSE_DOF, Figure, Row
from bspline_slam.lab.statistics import Band, chi_square_band

LABELS, PANEL, GAP, ROW = 330, 150, 26, 26
CHART = 110
"""Height of a chart over the drive."""
WIDTH = LABELS + 5 * (PANEL + GAP)
HIGHEST = 2.0
"""End of the axis of normalised errors; what lies beyond is written there."""
STYLE = """
  svg { font-family: Helvetica, Arial, sans-serif; font-size: 12px; }
  .paper { fill: #fff; }
  .head { font-weight: bold; }
  text { fill: #16324f; }
  .dim { fill: #66788a; font-size: 10px; }
  .axis { fill: none; stroke: #d3dae3; stroke-width: 1; }
  .band { fill: #cfe3f5; }
  .inside { fill: #16324f; stroke: #16324f; }
  .outside { fill: #fff; stroke: #c8442c; stroke-width: 2; }
  .beyond { fill: #c8442c; text-anchor: end; }
  .curve { fill: none; stroke: #16324f; stroke-width: 1.5; }
"""
PANELS = ("pose ANEES / n", "curve ANEES / n", "NIS / n", "χ² / dof", "2σ coverage")


def consistency_to_svg(rows: Sequence[Row], path: Path) -> None:
    """Draw the rows: above, every figure in its band; below, the mean normalised error of each key scan's pose."""
    top = 64 + ROW * len(rows)
    height = top + 40 + (CHART + 34) * len(rows)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" height="{height}">',
        f"<title>Consistency of estimators</title><style>{STYLE}</style>",
        f'<rect class="paper" width="{WIDTH}" height="{height}"/>',
        *_heads(rows),
    ]
    for number, row in enumerate(rows):
        parts.extend(_dots(row, 56 + ROW * number))
    parts.append(f'<text class="head" x="12" y="{top + 16}">Pose ANEES / n of each key scan along the drive</text>')
    for number, row in enumerate(rows):
        parts.extend(_chart(row, top + 34 + (CHART + 34) * number))
    path.write_text("\n".join([*parts, "</svg>"]) + "\n", encoding="utf-8")


def _name(row: Row) -> str:
    e = row.experiment
    return escape(f"{e.world} · {e.model} · {e.back_end} · {e.association}")


def _heads(rows: Sequence[Row]) -> list[str]:
    """Names of the panels and their scales."""
    bottom = 48 + ROW * len(rows)
    parts = ['<text class="dim" x="12" y="36">shaded: the 95 % acceptance band</text>']
    for k, name in enumerate(PANELS):
        left, end = LABELS + k * (PANEL + GAP), 1.0 if k == 4 else HIGHEST
        parts.append(f'<text class="head" x="{left}" y="18">{name}</text>')
        for share in (0.0, 0.5, 1.0):
            x = left + PANEL * share
            parts.append(f'<text class="dim" x="{x:.0f}" y="36" text-anchor="middle">{end * share:g}</text>')
            parts.append(f'<path class="axis" d="M{x:.0f} 42V{bottom}"/>')
    return parts


def _dots(row: Row, y: float) -> list[str]:
    parts = [f'<text x="12" y="{y + 4:.0f}">{_name(row)}</text>']
    for k, figure in enumerate((row.pose, row.curve, row.nis, row.chi2, row.coverage)):
        left, end = LABELS + k * (PANEL + GAP), 1.0 if k == 4 else HIGHEST
        parts.extend(_dot(figure, left, y, PANEL / end, left + PANEL))
    return parts


def _dot(figure: Figure, left: float, y: float, scale: float, right: float) -> list[str]:
    """A band and the dot that should lie in it; a value beyond the axis is written at its end."""
    if not isfinite(figure.value):
        return [f'<text class="dim" x="{left + 4:.0f}" y="{y + 4:.0f}">not computed</text>']
    low, high = (min(left + scale * edge, right) for edge in figure.band)
    parts = [f'<rect class="band" x="{low:.1f}" y="{y - 9:.0f}" width="{max(high - low, 1.0):.1f}" height="18"/>']
    x = left + scale * figure.value
    if x > right:
        return [*parts, f'<text class="beyond" x="{right:.0f}" y="{y + 4:.0f}">{figure.value:.3g} →</text>']
    kind = "inside" if figure.inside else "outside"
    return [*parts, f'<circle class="{kind}" cx="{x:.1f}" cy="{y:.0f}" r="4"/>']


def _chart(row: Row, y: float) -> list[str]:
    """Mean NEES of each key scan's pose, the band of that many runs behind it; its axis ends at twice HIGHEST."""
    left, right, bottom, top = 50.0, WIDTH - 20.0, y + CHART, y + 14
    parts = [f'<text x="12" y="{y + 4:.0f}">{_name(row)}, {row.runs} runs</text>']
    scale = (bottom - top) / (2 * HIGHEST)
    for value in (0.0, 1.0, 2.0, 3.0, 4.0):
        level = bottom - scale * value
        parts.append(f'<path class="axis" d="M{left:g} {level:.1f}H{right:g}"/>')
        parts.append(f'<text class="dim" x="{left - 8:g}" y="{level + 4:.1f}" text-anchor="end">{value:g}</text>')
    if len(row.by_scan) < 2:
        return parts
    parts.append(_strip(chi_square_band(POSE_DOF * row.runs), left, right, bottom, scale))
    last, first = max(row.by_scan), min(row.by_scan)
    across = [left + (right - left) * (scan - first) / (last - first) for scan in row.by_scan]
    up = [bottom - scale * min(value, 2 * HIGHEST) for value in row.by_scan.values()]
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(across, up, strict=True))
    ends = f'<text class="dim" x="{left:g}" y="{bottom + 12:.0f}">scan {first}</text>'
    ends += f'<text class="dim" x="{right:g}" y="{bottom + 12:.0f}" text-anchor="end">scan {last}</text>'
    return [*parts, f'<polyline class="curve" points="{points}"/>', ends]


def _strip(band: Band, left: float, right: float, bottom: float, scale: float) -> str:
    low, high = (bottom - scale * min(edge, 2 * HIGHEST) for edge in band)
    return f'<rect class="band" x="{left:g}" y="{high:.1f}" width="{right - left:g}" height="{low - high:.1f}"/>'
