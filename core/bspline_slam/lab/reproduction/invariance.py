"""Figs 2 and 3: without noise, two places give the same control points, and these the reference spline."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.bspline import BSpline
from bspline_slam.export import figure as fig
from bspline_slam.lab.reproduction import sight
from bspline_slam.lab.reproduction.reproduced import NOT_GIVEN, Reproduced, Row, write_data

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False, slots=True)
class TwoViews:
    """The scans of both places and the splines fitted to them, all in the world frame."""

    scans: tuple[Float[np.ndarray, "m 2"], Float[np.ndarray, "k 2"]]
    fitted: tuple[BSpline, BSpline]

    @property
    def mean_square_error(self) -> float:
        """Mean square distance from the spline of the first place to the reference (m²)."""
        _, samples = self.fitted[0].sample(0.01)
        foot = sight.REFERENCE(sight.REFERENCE.foot_points(samples))
        return float(np.mean(np.sum((samples - foot) ** 2, axis=1)))

    @property
    def differences(self) -> Float[np.ndarray, "n"]:
        """Distance between the control points of the two places (m)."""
        return np.linalg.norm(self.fitted[1].control_points - self.fitted[0].control_points, axis=1)


def two_views() -> TwoViews:
    """Noise-free scans at 0.1° from both places, fitted by chord length."""
    poses = (sight.FIRST_POSE, sight.SECOND_POSE)
    seen = [sight.scan_curve(sight.REFERENCE, pose, sight.FINE) for pose in poses]
    fitted = [sight.observe(points).curve.moved(pose) for pose, points in zip(poses, seen, strict=True)]
    world = [se2.transform(pose, points) for pose, points in zip(poses, seen, strict=True)]
    return TwoViews((world[0], world[1]), (fitted[0], fitted[1]))


def reproduce(out: Path) -> Reproduced:
    """Draw both figures and compare the fits."""
    views = two_views()
    files = fig.draw("Fig. 2 · Finding the scan points", [_beams], out / "figure_2", height=4.6)
    files += fig.draw(
        "Fig. 3 · The same control points from two places, without noise",
        [
            lambda axes: _scan(axes, views),
            lambda axes: _against_reference(axes, views),
            lambda axes: _both_scans(axes, views),
            lambda axes: _control_points(axes, views),
        ],
        out / "figure_3",
    )
    apart = views.differences
    data = {
        "reference": {"knots": sight.REFERENCE.knots, "control_points": sight.REFERENCE.control_points},
        "poses": [sight.FIRST_POSE, sight.SECOND_POSE],
        "scans": list(views.scans),
        "control_points": [curve.control_points for curve in views.fitted],
        "mean_square_error_m2": views.mean_square_error,
        "control_point_differences_m": apart,
    }
    rows = (
        Row("3b", "mean square error of the fit to the reference (m²)", "2.4e-3", f"{views.mean_square_error:.1e}"),
        Row("3d", "control points from the second place: RMS difference (mm)", NOT_GIVEN, f"{_rms(apart) * 1e3:.1f}"),
        Row("3d", "… largest difference (mm)", NOT_GIVEN, f"{apart.max() * 1e3:.1f}"),
    )
    return Reproduced(rows, (*files, write_data(out / "figure_3", data)))


def _rms(values: Float[np.ndarray, "n"]) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _reference(axes: Axes, label: str = "reference spline") -> None:
    fig.line(axes, sight.REFERENCE.sample(0.02)[1], fig.BLUE, label, linewidth=2.0)


def _beams(axes: Axes) -> None:
    fig.to_scale(axes, "Beams (every 3°) and where they meet the reference spline")
    points = se2.transform(
        sight.FIRST_POSE, sight.scan_curve(sight.REFERENCE, sight.FIRST_POSE, float(np.radians(3.0)))
    )
    fig.rays(axes, sight.FIRST_POSE[:2], points, fig.ORANGE, linewidth=0.7)
    _reference(axes)
    fig.dots(axes, points, fig.RED, "scan points", markersize=4)
    fig.robot(axes, sight.FIRST_POSE, fig.INK, "robot")
    fig.legend(axes)


def _scan(axes: Axes, views: TwoViews) -> None:
    fig.to_scale(axes, f"(a) {len(views.scans[0])} intersection points, one every 0.1°")
    fig.dots(axes, views.scans[0], fig.RED, markersize=1.5)
    fig.robot(axes, sight.FIRST_POSE, fig.INK)


def _against_reference(axes: Axes, views: TwoViews) -> None:
    fig.to_scale(axes, f"(b) Mean square error {views.mean_square_error:.1e} m²")
    _reference(axes)
    fig.line(axes, views.fitted[0].sample(0.02)[1], fig.RED, "derived spline", linestyle=(0, (1, 2)), linewidth=2.0)
    fig.legend(axes)


def _both_scans(axes: Axes, views: TwoViews) -> None:
    fig.to_scale(axes, "(c) Scans from two places")
    for pose, points, colour, name in zip(
        (sight.FIRST_POSE, sight.SECOND_POSE), views.scans, (fig.RED, fig.GREEN), ("first", "second"), strict=True
    ):
        fig.rays(axes, pose[:2], points[::40], colour, linewidth=0.3)
        fig.dots(axes, points[::10], colour, f"{name} scan (every tenth point)", markersize=2.5)
        fig.robot(axes, pose, colour)
    fig.legend(axes)


def _control_points(axes: Axes, views: TwoViews) -> None:
    fig.to_scale(axes, f"(d) Control points, at most {views.differences.max() * 1e3:.1f} mm apart")
    fig.line(axes, views.fitted[0].sample(0.02)[1], fig.PALE)
    for curve, colour, marker, size, name in zip(
        views.fitted, (fig.RED, fig.GREEN), ("o", "x"), (8, 5), ("first", "second"), strict=True
    ):
        fig.dots(
            axes, curve.control_points, colour, f"from the {name} place", marker=marker, markersize=size,
            markerfacecolor="none",
        )  # fmt: skip
    fig.legend(axes)
