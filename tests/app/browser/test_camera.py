"""What pages are made to see: arithmetic of rectangles, and who is left alone."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from app import views
from splinescope.browser.camera import Camera, bounds, contains, nearer, strayed, union
from splinescope.browser.page import Bounds, Viewport
from splinescope.browser.values import Place

HERE = Viewport(0.0, 0.0, 0.01, 1000.0, 600.0)


class Pages:
    """A page with so many clients, of which some have been `moved` by their persons."""

    def __init__(self, count: int = 1) -> None:
        self.moved: set[int] = set()
        self.fitted: list[tuple[Bounds, int]] = []
        self.looks: list[tuple[Place, int]] = []
        clients = {number: SimpleNamespace(client_id=number) for number in range(count)}
        self.server: Any = SimpleNamespace(get_clients=lambda: clients)

    def fit(self, wanted: Bounds, client: Any) -> None:
        self.fitted.append((wanted, client.client_id))

    def look(self, place: Place, client: Any, *, glide: bool = False) -> None:
        self.looks.append((place, client.client_id))

    def viewport_of(self, client: Any) -> Viewport:
        return replace(HERE, fitted=client.client_id not in self.moved)


def camera_of(pages: Pages) -> Camera:
    page: Any = pages
    return Camera(page)


def test_the_rectangle_holds_map_path_and_scan() -> None:
    shown = views.office(np.random.default_rng(1))
    left, low, right, high = bounds(shown.map, shown.scan)
    assert shown.map is not None
    points = np.concatenate([shown.map.estimate[:, :2], *(s.curve.control_points for s in shown.map.map)])
    assert np.all(points >= [left, low])
    assert np.all(points <= [right, high])
    assert bounds(None, None) == (-5.0, -5.0, 5.0, 5.0)


def test_a_growing_map_moves_only_pages_that_nobody_has_moved() -> None:
    pages = Pages(2)
    pages.moved.add(1)
    camera = camera_of(pages)
    camera.fit((0.0, 0.0, 10.0, 10.0))
    camera.grow((2.0, 2.0, 9.0, 9.0))
    assert [client for _, client in pages.fitted] == [0, 1]
    camera.grow((2.0, 2.0, 15.0, 9.0))
    (shown, client), *others = pages.fitted[2:]
    assert client == 0
    assert contains(shown, (0.0, 0.0, 15.0, 10.0))
    assert not others
    camera.settle((0.0, 0.0, 15.0, 10.0))
    assert pages.fitted[3:] == [((0.0, 0.0, 15.0, 10.0), 0)]


def test_a_new_page_is_welcomed_once() -> None:
    pages = Pages()
    camera = camera_of(pages)
    for _ in range(3):
        camera.welcome((0.0, 0.0, 5.0, 5.0))
    assert pages.fitted == [((0.0, 0.0, 5.0, 5.0), 0)]


def test_the_robot_is_followed_when_it_is_about_to_leave_and_the_scale_stays() -> None:
    assert not strayed(np.array([2.0, 1.0, 0.0]), HERE)
    robot = np.array([4.0, 1.0, 0.0])
    assert strayed(robot, HERE)
    pages = Pages()
    camera_of(pages).follow(robot)
    assert pages.looks == [((4.0, 1.0, HERE.metres_per_pixel), 0)]


def test_a_turned_page_is_left_through_its_own_edges() -> None:
    turned = replace(HERE, turn=np.pi / 2)
    assert strayed(np.array([2.0, 0.0, 0.0]), turned)  # 6 m tall: x runs up and down now
    assert not strayed(np.array([0.0, 2.0, 0.0]), turned)
    assert turned.bounds == pytest.approx((-3.0, -5.0, 3.0, 5.0))
    slanted = replace(HERE, turn=0.3).bounds
    assert contains(slanted, (-4.5, -2.0, 4.5, 2.0), slack=0.0)


def test_a_page_that_was_given_a_place_is_not_welcomed_to_another() -> None:
    pages = Pages(2)
    camera = camera_of(pages)
    camera.look((1.0, 2.0, 0.01), 1)
    camera.welcome((0.0, 0.0, 5.0, 5.0))
    assert pages.looks == [((1.0, 2.0, 0.01), 1)]
    assert [client for _, client in pages.fitted] == [0]


def test_rectangles_are_joined_and_compared_with_a_little_slack() -> None:
    a, b = (0.0, 0.0, 1.0, 1.0), (0.5, -1.0, 3.0, 0.5)
    both = union(a, b)
    assert contains(both, a)
    assert contains(both, b)
    assert not contains(a, b)
    assert contains(a, (-0.005, 0.0, 1.0, 1.0))


def test_a_page_is_led_to_a_thing_unless_it_sees_it_near_enough() -> None:
    pages = Pages(2)
    camera = camera_of(pages)
    camera.lead((20.0, 20.0, 22.0, 21.0), 1)
    ((place, client),) = pages.looks
    assert client == 1
    assert place == pytest.approx((21.0, 20.5, 0.004))
    near = replace(HERE, x=21.0, y=20.5, metres_per_pixel=0.004)
    assert nearer((20.0, 20.0, 22.0, 21.0), near) is None
    assert nearer((20.0, 20.0, 22.0, 21.0), replace(near, metres_per_pixel=0.01)) == pytest.approx(0.004)
    assert nearer((20.0, 20.0, 22.0, 21.0), replace(near, x=24.0)) == pytest.approx(0.004)
