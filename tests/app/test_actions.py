"""The table of actions."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from app.inline import InlineEstimator, deliver, session_with, stand_in
from app.logs import corridor_log
from bspline_slam.errors import SplineSlamError
from bspline_slam.front_end.loop_closure import LoopClosure
from splinescope import commands as ask
from splinescope.actions import ACTIONS, GROUPS, PageRequest, described, refusals
from splinescope.actions.layers import MAP_LAYERS, SCAN_LAYERS
from splinescope.browser.page import Page
from splinescope.browser.preferences import Preferences
from splinescope.closures import ClosurePage, Which
from splinescope.panels.action_button import ActionButton
from splinescope.panels.action_row import action_row, button
from splinescope.paths import static_folder
from splinescope.session import Session
from splinescope.view import Layer, Selection


@pytest.fixture
def empty() -> Session:
    return Session(InlineEstimator(), lambda _: None, Preferences())


@pytest.fixture
def finished(monkeypatch: pytest.MonkeyPatch) -> Session:
    drive = corridor_log(np.random.default_rng(8), 30)
    stand_in(monkeypatch, drive)
    session, inline = session_with(drive)
    deliver(session, inline)
    return session


def test_no_key_means_two_things_and_no_id_two_actions() -> None:
    rows = [action for group in GROUPS.values() for action in group]
    assert max(Counter(key for action in rows for key in action.keys).values()) == 1
    assert len(ACTIONS) == len(rows)


def test_every_layer_has_its_place_once() -> None:
    assert sorted(layer.name for layer in SCAN_LAYERS + MAP_LAYERS) == sorted(layer.name for layer in Layer)


def test_the_keys_people_expect(finished: Session) -> None:
    expected = {
        " ": ask.TogglePlay(),
        "ArrowRight": ask.Step(1),
        ",": ask.Step(-1),
        "Shift+ArrowLeft": ask.Step(-10),
        "Home": ask.Seek(0),
        "End": ask.Seek(-1),
        "]": ask.ChangeSpeed(1),
        "Escape": ask.Leave(),
        "d": ask.SetDark(),
        "f": PageRequest.FIT,
        "?": PageRequest.SCRIPT,
        "Ctrl+k": PageRequest.SCRIPT,
    }
    does = {key: action.request(finished) for action in ACTIONS.values() for key in action.keys}
    assert expected.items() <= does.items()
    assert "Ctrl+c" not in does


def test_keys_are_shown_as_people_write_them() -> None:
    assert ACTIONS["next-scan"].shown == "→ or ."
    assert ACTIONS["back-10"].shown == "Shift + ←"
    assert ACTIONS["palette"].shown == "Ctrl + K or /"
    assert ACTIONS["zoom-in"].shown == "+ or ="
    assert ACTIONS["run"].shown == ""


def test_every_action_can_be_done_or_says_why_not_in_a_sentence(empty: Session, finished: Session) -> None:
    for session in (empty, finished):
        refused = refusals(session)
        assert all(sentence.endswith(".") and sentence[0].isupper() for sentence in refused.values())
        for action in ACTIONS.values():
            request = action.request(session)
            if action.id not in refused and not isinstance(request, PageRequest):
                session.apply(request)
    assert not finished.troubles


def test_segments_and_their_splines_are_reached_by_keys(finished: Session) -> None:
    finished.apply(ask.Seek(0))
    assert finished.scan_view is not None
    numbers = [fitted.segment.index for fitted in finished.scan_view.segments]
    reached = []
    for _ in numbers:
        request = ACTIONS["next-segment"].request(finished)
        assert isinstance(request, ask.Select)
        finished.apply(request)
        assert finished.selection is not None
        reached.append(finished.selection.id)
    assert reached == numbers
    finished.apply(ask.Select(None))
    assert ACTIONS["previous-segment"].request(finished) == ask.Select(Selection("segment", numbers[-1]))
    tied = next(a for a in finished.scan_view.associations if a.spline is not None)
    finished.apply(ask.Select(Selection("segment", tied.segment)))
    assert ACTIONS["spline-of-segment"].refusal(finished) is None
    assert ACTIONS["spline-of-segment"].request(finished) == ask.Select(Selection("spline", tied.spline or 0))


def test_the_scripts_own_actions_are_done_by_the_script() -> None:
    scripts = "".join(path.read_text(encoding="utf-8") for path in static_folder().glob("*.js"))
    done = set(re.findall(r'does\("([a-z-]+)"', scripts))
    assert done == {a.id for a in ACTIONS.values() if a.does is PageRequest.SCRIPT and not a.id.startswith("tab-")}
    assert len(described()["actions"]) == len(ACTIONS)  # pyright: ignore[reportArgumentType]


def test_questions_are_told_and_their_answers_are_commands(empty: Session) -> None:
    asking = [action for action in ACTIONS.values() if action.asks is not None]
    assert {action.id for action in asking} == {a.id for a in ACTIONS.values() if a.does is PageRequest.ASK}
    told = described()["actions"]
    assert isinstance(told, list)
    assert {row["id"] for row in told if row["asks"]} == {action.id for action in asking}
    second, opening = ACTIONS["go-to-second"], ACTIONS["open-log"]
    assert second.asks is not None and opening.asks is not None
    assert second.asks.command("42,5 s") == second.asks.command("42.5") == ask.SeekTime(42.5)
    opened = opening.asks.command("office")
    assert isinstance(opened, ask.OpenLog) and opened.path.name in opening.asks.choices
    for action, nonsense in ((second, "noon"), (second, "nan"), (opening, "no such log")):
        assert action.asks is not None
        with pytest.raises(SplineSlamError):
            action.asks.command(nonsense)


def test_what_is_chosen_for_the_next_run_can_be_chosen_by_name(finished: Session) -> None:
    finished.apply(choice(finished, "estimator-sam"))
    finished.apply(choice(finished, "model-chord-length"))
    assert (finished.recipe.back_end, finished.recipe.model) == ("sam", "chord-length")


def choice(session: Session, action: str) -> ask.Command:
    request = ACTIONS[action].request(session)
    assert not isinstance(request, PageRequest)
    return request


def test_tests_and_pages_of_closures_are_reached_by_name(finished: Session, empty: Session) -> None:
    assert ACTIONS["nis-worst"].refusal(empty) == "Key scans of this map are not tested by NIS."
    tests = finished.findings.consistency
    assert tests is not None
    assert choice(finished, "nis-worst") == ask.Seek(tests.nis.worst or 0)
    finished.apply(ask.Seek(0))
    finished.apply(choice(finished, "nis-next"))
    assert finished.cursor == tests.nis.worst
    finished.findings.consistency = replace(tests, nis=replace(tests.nis, squares=tests.nis.dof))
    assert ACTIONS["nis-next"].refusal(finished) == "No key scan lies above the band of NIS."
    assert ACTIONS["closures-next"].refusal(finished) and ACTIONS["closures-back"].refusal(finished)
    snapshot = finished.findings.snapshot
    assert snapshot is not None
    loop = LoopClosure(0, 20, np.zeros(3), np.eye(3), 0.7, 0.8, False, "seen again")
    finished.findings.snapshot = replace(snapshot, loop_closures=(loop,) * 20)
    pages = [0]
    while ACTIONS["closures-next"].refusal(finished) is None:
        finished.apply(choice(finished, "closures-next"))
        pages.append(finished.closure_page.number)
    assert pages == [0, 1, 2]
    finished.apply(choice(finished, "closures-accepted"))
    assert finished.closure_page == ClosurePage(Which.ACCEPTED)


def test_a_button_says_why_it_cannot_be_pressed(page: Page, empty: Session, finished: Session) -> None:
    made = ActionButton(page.server.gui, lambda _: None, "optimise")
    made.refresh(empty)
    assert made.handle.disabled
    assert made.handle.hint == "No log is open."
    made.refresh(finished)
    assert not made.handle.disabled
    assert made.handle.hint == "Key O"


def test_a_button_among_others_looks_as_if_it_could_not_be_pressed_and_says_why(
    empty: Session, finished: Session
) -> None:
    off = button(empty, "Solve <it>", "optimise")
    assert 'aria-disabled="true"' in off and 'title="No log is open."' in off and "Solve &lt;it&gt;" in off
    on = button(finished, "Solve it", "optimise")
    assert "aria-disabled" not in on and 'title="Only solve this map again (O)"' in on
    row = action_row(finished, {"Undo": "undo", "Solve": "optimise"}, label="Now", strong="optimise")
    assert row.count("<button") == 2 and row.count("act strong") == 1 and "<span>Now</span>" in row


def test_results_are_shown_and_laid_over_each_other_in_turn(finished: Session) -> None:
    assert finished.estimation is not None and finished.result is not None
    assert ACTIONS["result-next"].refusal(finished) and ACTIONS["result-delete"].refusal(finished)
    for number in (2, 3):
        results = finished.estimation.results
        finished.estimation.results = results.added(replace(finished.result, number=number), show=False)

    def do(action: str) -> tuple[int | None, int | None]:
        request = ACTIONS[action].request(finished)
        assert ACTIONS[action].refusal(finished) is None and not isinstance(request, PageRequest)
        finished.apply(request)
        results = finished.results
        return tuple(each.number if each is not None else None for each in (results.shown, results.compared))  # type: ignore[return-value]

    assert [do("result-over") for _ in range(3)] == [(1, 2), (1, 3), (1, None)]
    assert [do("result-next") for _ in range(3)] == [(2, None), (3, None), (1, None)]
    assert [do("result-over"), do("result-swap"), do("result-delete")] == [(1, 2), (2, 1), (2, None)]
