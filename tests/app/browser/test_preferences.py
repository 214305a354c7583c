"""What is remembered."""

from __future__ import annotations

from pathlib import Path

import pytest

from bspline_slam.errors import ConfigError
from splinescope.browser.log_view import LogView
from splinescope.browser.preferences import FIRST_LAYERS, MOST_VIEWS, Preferences, check, default_path, load, save
from splinescope.view import Colouring, Layer, Selection


def test_what_is_saved_comes_back(tmp_path: Path) -> None:
    seen = LogView(120, (1.0, -2.5, 0.02), Selection("control point", 3, 2), "quality")
    views = {"a": LogView(), "b": seen}
    chosen = Preferences(frozenset({Layer.TRUTH, Layer.ELLIPSES}), False, True, 5.0, Colouring.AGE, True, True, views)
    path = tmp_path / "deep" / "session.json"
    save(chosen, path)
    assert load(path) == chosen
    assert [child.name for child in path.parent.iterdir()] == ["session.json"]


@pytest.mark.parametrize("text", ["", "{", "[]", '"office"', "null", '{"layers": 3, "dark": "yes", "speed": []}'])
def test_a_broken_file_is_a_first_visit(tmp_path: Path, text: str) -> None:
    path = tmp_path / "session.json"
    path.write_text(text, encoding="utf-8")
    assert load(path) == Preferences()
    assert load(tmp_path / "nowhere.json") == Preferences()


@pytest.mark.parametrize(
    "view",
    ["7", "{}", '{"cursor": -1, "place": [1, 2]}', '{"place": [1, 2, -3], "tab": 4}', '{"selection": {"kind": 1}}'],
)
def test_views_that_make_no_sense_are_those_of_a_first_visit(view: str) -> None:
    assert Preferences.from_json(f'{{"views": {{"a": {view}}}}}').views == {"a": LogView()}


def test_only_the_latest_views_are_remembered() -> None:
    chosen = Preferences()
    for number in range(MOST_VIEWS + 5):
        chosen = chosen.with_view(str(number), LogView(cursor=number))
    chosen = chosen.with_view("7", LogView(cursor=1))
    assert len(chosen.views) == MOST_VIEWS
    assert list(chosen.views)[-1] == "7"
    assert "4" not in chosen.views


def test_unknown_layers_are_left_out_and_missing_words_stay_as_they_were() -> None:
    told = Preferences.from_json('{"layers": ["BEAMS", "SMELL"], "colour": "red"}')
    assert told.layers == {Layer.BEAMS}
    assert Preferences.from_json('{"dark": false}').layers == FIRST_LAYERS


def test_a_place_that_cannot_be_written_harms_nothing(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("", encoding="utf-8")
    save(Preferences(), blocked / "session.json")
    assert "cannot remember" in caplog.text


def test_the_users_configuration_folder_is_respected(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    assert default_path() == tmp_path / "splinescope" / "session.json"


def test_what_is_no_session_is_not_written_over(tmp_path: Path) -> None:
    check(tmp_path / "new.json")
    save(Preferences(dark=False), tmp_path / "kept.json")
    check(tmp_path / "kept.json")
    for name, content in (("a.log", b"FLASER 3 1 1 1"), ("a.bag", b"#ROSBAG\xff\x00"), ("b.json", b'{"poses": []}')):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(ConfigError, match=f"{name} is no session of SplineScope"):
            check(tmp_path / name)
