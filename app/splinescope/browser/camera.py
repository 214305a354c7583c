"""Where the pages look: fit the map, keep up with its growth, keep the robot in sight."""

from __future__ import annotations

import numpy as np
import viser
from jaxtyping import Float

from bspline_slam import se2
from splinescope.browser.page import Bounds, Page, Viewport
from splinescope.browser.values import Place
from splinescope.view import MapView, ScanView

AIR = 0.15
"""Share of its size that a growing map is given on every side, so that the picture does not move all the time."""

ROOM = 0.25
"""Share of a page's size that the robot may be away from the middle before the page follows."""


class Camera:
    """Moves what pages see; a page whose person has looked elsewhere is left alone while the map grows."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self._fitted: dict[int, Bounds] = {}
        self._placed: set[int] = set()

    def fit(self, wanted: Bounds, client: int | None = None) -> None:
        """Show all of it in one page, or in every page."""
        for each in self._page.server.get_clients().values():
            if client in (None, each.client_id):
                self._fit(each, wanted)

    def look(self, place: Place, client: int | None = None) -> None:
        """Show this place in one page, or in every page."""
        for each in self._page.server.get_clients().values():
            if client in (None, each.client_id):
                self._placed.add(each.client_id)
                self._page.look(place, each)

    def lead(self, wanted: Bounds, client: int | None = None) -> None:
        """Let one page, or every page, look at this; a page that sees it near enough stays where it is."""
        for each in self._page.server.get_clients().values():
            viewport = self._page.viewport_of(each) if client in (None, each.client_id) else None
            if viewport is not None and (scale := nearer(wanted, viewport)) is not None:
                self._placed.add(each.client_id)
                middle = (0.5 * (wanted[0] + wanted[2]), 0.5 * (wanted[1] + wanted[3]))
                self._page.look((*middle, scale), each, glide=True)

    def welcome(self, wanted: Bounds) -> None:
        """Show all of it in pages that have come since the last time."""
        for client in self._page.server.get_clients().values():
            known = client.client_id in self._fitted or client.client_id in self._placed
            if not known and self._page.viewport_of(client) is not None:
                self._fit(client, wanted)

    def grow(self, wanted: Bounds) -> None:
        """Show what has been added outside of the last fit, with room for more."""
        for client, fitted in self._untouched():
            if not contains(fitted, wanted):
                self._fit(client, widened(union(fitted, wanted), AIR))

    def settle(self, wanted: Bounds) -> None:
        """Show exactly this."""
        for client, _ in self._untouched():
            self._fit(client, wanted)

    def _untouched(self) -> list[tuple[viser.ClientHandle, Bounds]]:
        """Pages that see what they were last shown, or are on the way there, and what that was."""
        pages = []
        for client in self._page.server.get_clients().values():
            viewport, fitted = self._page.viewport_of(client), self._fitted.get(client.client_id)
            if viewport is not None and viewport.fitted and fitted is not None:
                pages.append((client, fitted))
        return pages

    def _fit(self, client: viser.ClientHandle, wanted: Bounds) -> None:
        self._fitted[client.client_id] = wanted
        self._page.fit(wanted, client)

    def follow(self, robot: Float[np.ndarray, "3"]) -> None:
        """Bring the robot back to the middle of every page that it is about to leave, at the same scale."""
        for client in self._page.server.get_clients().values():
            viewport = self._page.viewport_of(client)
            if viewport is not None and strayed(robot, viewport):
                self._placed.add(client.client_id)
                self._page.look((float(robot[0]), float(robot[1]), viewport.metres_per_pixel), client, glide=True)


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


def widened(bounds: Bounds, share: float) -> Bounds:
    """The rectangle with this share of its size more on every side."""
    air_x, air_y = share * (bounds[2] - bounds[0]), share * (bounds[3] - bounds[1])
    return bounds[0] - air_x, bounds[1] - air_y, bounds[2] + air_x, bounds[3] + air_y


def nearer(wanted: Bounds, viewport: Viewport) -> float | None:
    """The scale (m per pixel) at which a page shows a rectangle well; None for one that does, at a scale no more than
    twice as large."""
    good = 2.0 * max((wanted[2] - wanted[0]) / viewport.width, (wanted[3] - wanted[1]) / viewport.height)
    near = 0.5 * good <= viewport.metres_per_pixel <= 2.0 * good
    return None if near and contains(viewport.bounds, wanted) else good


def strayed(robot: Float[np.ndarray, "3"], viewport: Viewport) -> bool:
    """Whether the robot is further from the middle than ROOM of the page's size."""
    away = se2.rotation(viewport.turn).T @ (robot[:2] - [viewport.x, viewport.y]) / viewport.metres_per_pixel
    return bool(max(abs(away) / [viewport.width, viewport.height]) > ROOM)
