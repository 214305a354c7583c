"""One driver, many watchers."""

from __future__ import annotations

from splinescope.browser.visitors import Visitors


def test_the_first_page_drives_and_others_watch_until_they_take_control() -> None:
    here = Visitors().came(1, "a").came(2, "b").came(3, "c")
    assert here.driver == 1
    assert here.watchers == (2, 3)
    assert here.driven_by(3).driver == 3
    assert here.driven_by(3).watchers == (1, 2)


def test_a_driver_that_loads_its_page_again_drives_on() -> None:
    here = Visitors().came(1, "a").came(2, "b")
    assert here.left(1).driver is None
    assert here.left(1).came(3, "a").driver == 3
    assert here.came(3, "a").left(1).driver == 3
    assert here.left(1).came(3, "z").driver is None
    assert here.left(1).driven_by(2).came(3, "a").driver == 2
    assert here.left(2).driver == 1


def test_a_page_that_comes_to_an_empty_room_drives() -> None:
    assert Visitors().came(1, "a").left(1).came(2, "b").driver == 2
