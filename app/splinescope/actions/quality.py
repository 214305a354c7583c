"""Actions on what is found out about the map: the tests of key scans, and the list of loop closures."""

from __future__ import annotations

from functools import partial

from bspline_slam.lab.scan_test import ScanTest
from splinescope import commands as ask
from splinescope.actions.action import Action
from splinescope.closures import ClosurePage, Which, chosen, pages
from splinescope.pictures.consistency import next_outside
from splinescope.session import Session

NOT_TESTED = "Key scans of this map are not tested by {}."
NONE_ABOVE = "No key scan lies above the band of {}."


def _test(session: Session, name: str) -> ScanTest | None:
    tests = session.findings.consistency
    test = None if tests is None else getattr(tests, name)
    return test if test is not None and len(test.scans) > 1 else None


def _untested(name: str, session: Session) -> str | None:
    return NOT_TESTED.format(name.upper()) if _test(session, name) is None else None


def _none_above(name: str, session: Session) -> str | None:
    test = _test(session, name)
    if test is None:
        return NOT_TESTED.format(name.upper())
    return NONE_ABOVE.format(name.upper()) if next_outside(test, session.cursor) is None else None


def _to_worst(name: str, session: Session) -> ask.Command:
    test = _test(session, name)
    return ask.Seek(session.cursor if test is None or test.worst is None else test.worst)


def _to_next(name: str, session: Session) -> ask.Command:
    test = _test(session, name)
    after = None if test is None else next_outside(test, session.cursor)
    return ask.Seek(session.cursor if after is None else after)


def _tests(name: str, what: str) -> tuple[Action, ...]:
    worst, above = partial(_to_worst, name), partial(_to_next, name)
    say_worst, say_above = f"Go to the key scan with the worst {what}", f"Go to the next one above the band of {what}"
    return (
        Action(f"{name}-worst", say_worst, (), worst, partial(_untested, name)),
        Action(f"{name}-next", say_above, (), above, partial(_none_above, name)),
    )


def _pages(session: Session) -> int:
    snapshot = session.findings.snapshot
    return 0 if snapshot is None else pages(len(chosen(snapshot.loop_closures, session.closure_page.which)))


def _turned(by: int, session: Session) -> ask.Command:
    return ask.LeafThrough(session.closure_page.turned(by, _pages(session)))


def _unturned(by: int, session: Session) -> str | None:
    page = session.closure_page
    if page.turned(by, _pages(session)) == page:
        return "There is no page of loop closures after this one." if by > 0 else "This is the first page of them."
    return None


QUALITY = (
    *_tests("nis", "NIS"),
    *_tests("nees", "NEES"),
    Action("closures-next", "Loop closures: next page", (), partial(_turned, 1), partial(_unturned, 1)),
    Action("closures-back", "Loop closures: page before", (), partial(_turned, -1), partial(_unturned, -1)),
    *(
        Action(f"closures-{which.value}", f"Loop closures: list {which.value}", (), ask.LeafThrough(ClosurePage(which)))
        for which in Which
    ),
)
