"""Where the pages look: fit the map, keep up with its growth, keep the robot in sight."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from splinescope.page import Bounds, Page, Viewport
from splinescope.view import MapView, ScanView

FIT_MARGIN = 56.0
"""Pixels of air, both sides together, that the page leaves around what it fits."""

ROOM = 0.25
"""Share of a page's size that the robot may be away from the middle before the page follows."""


class Camera:
    """Moves what pages see; a page whose person has looked elsewhere is left alone while the map grows."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self._fitted: Bounds | None = None
        self._met: set[int] = set()

    def fit(self, wanted: Bounds) -> None:
        """Show all of it in every page."""
        self._fitted = wanted
        self._page.fit(wanted)

    def welcome(self, wanted: Bounds) -> None:
        """Show all of it in pages that have come since the last time."""
        for client in self._page.server.get_clients().values():
            if client.client_id not in self._met and self._page.viewport_of(client) is not None:
                self._met.add(client.client_id)
                self._page.fit(wanted, client)

    def grow(self, wanted: Bounds) -> None:
        """Show what has been added outside of the last fit, in pages that still see the whole of that."""
        if self._fitted is not None and not contains(self._fitted, wanted):
            self.settle(union(self._fitted, wanted))

    def settle(self, wanted: Bounds) -> None:
        """Show exactly this in pages that still see the whole of the last fit."""
        before, self._fitted = self._fitted, wanted
        for client in self._page.server.get_clients().values():
            seen = self._page.bounds_of(client)
            if before is None or (seen is not None and contains(seen, before)):
                self._page.fit(wanted, client)

    def follow(self, robot: Float[np.ndarray, "3"]) -> None:
        """Bring the robot back to the middle of every page that it is about to leave, at the same scale."""
        for client in self._page.server.get_clients().values():
            viewport = self._page.viewport_of(client)
            if viewport is not None and strayed(robot, viewport):
                self._page.fit(around(robot, viewport), client)


def bounds(world: MapView | None, scan: ScanView | None) -> Bounds:
    """The rectangle that holds the map, or the odometry where there is none yet, and the scan."""
    parts = [np.zeros((0, 2))]
    if world is not None:
        parts += [spline.curve.control_points for spline in world.map]
        parts.append(world.estimate[:, :2])
        if not len(world.estimate) and world.odometry is not None:
            parts.append(world.odometry[:, :2])
    if scan is not None:
        parts.append(scan_points(scan))
    points = np.concatenate(parts)
    if not len(points):
        return -5.0, -5.0, 5.0, 5.0
    (left, low), (right, high) = points.min(axis=0), points.max(axis=0)
    return float(left), float(low), float(right), float(high)


def scan_points(scan: ScanView) -> Float[np.ndarray, "m 2"]:
    """Where the beams of a scan ended, and the robot (world frame)."""
    points = se2.transform(scan.pose, scan.scan.points_robot[scan.scan.valid])
    return np.concatenate([scan.pose[None, :2], points])


def contains(outer: Bounds, inner: Bounds, slack: float = 0.01) -> bool:
    """Whether `inner` lies inside `outer`, but for a small share of its size."""
    air = slack * max(inner[2] - inner[0], inner[3] - inner[1])
    return (
        outer[0] <= inner[0] + air
        and outer[1] <= inner[1] + air
        and outer[2] >= inner[2] - air
        and outer[3] >= inner[3] - air
    )


def union(a: Bounds, b: Bounds) -> Bounds:
    return min(a[0], b[0]), min(a[1], b[1]), max(a[2], b[2]), max(a[3], b[3])


def strayed(robot: Float[np.ndarray, "3"], viewport: Viewport) -> bool:
    """Whether the robot is further from the middle than ROOM of the page's size."""
    away_x = abs(float(robot[0]) - viewport.x) / (viewport.width * viewport.metres_per_pixel)
    away_y = abs(float(robot[1]) - viewport.y) / (viewport.height * viewport.metres_per_pixel)
    return max(away_x, away_y) > ROOM


def around(robot: Float[np.ndarray, "3"], viewport: Viewport) -> Bounds:
    """A rectangle about the robot that fits at the scale the page has now."""
    x, y = float(robot[0]), float(robot[1])
    half = 0.5 * max(viewport.width - FIT_MARGIN, 1.0) * viewport.metres_per_pixel
    return x - half, y, x + half, y
