"""The table of keys."""

from __future__ import annotations

from collections import Counter

from splinescope import commands as ask
from splinescope.keys import BINDINGS, MAP_LAYERS, SCAN_LAYERS, PageAction, binding_of
from splinescope.panels.help import sheet
from splinescope.view import Layer


def test_no_key_means_two_things() -> None:
    assert max(Counter(name for binding in BINDINGS for name in binding.names).values()) == 1


def test_every_layer_has_its_place_once() -> None:
    assert sorted(layer.name for layer in SCAN_LAYERS + MAP_LAYERS) == sorted(layer.name for layer in Layer)


def test_the_keys_people_expect() -> None:
    expected = {
        " ": ask.TogglePlay(),
        "ArrowRight": ask.Step(1),
        ",": ask.Step(-1),
        "Shift+ArrowLeft": ask.Step(-10),
        "Home": ask.Seek(0),
        "End": ask.Seek(-1),
        "]": ask.ChangeSpeed(1),
        "d": ask.SetDark(),
        "f": PageAction.FIT,
        "?": PageAction.HELP,
        "Escape": PageAction.ESCAPE,
    }
    for name, action in expected.items():
        binding = binding_of(name)
        assert binding is not None
        assert binding.does == action
    assert binding_of("Ctrl+c") is None


def test_the_help_sheet_names_every_key() -> None:
    text = sheet()
    assert all(binding.says in text for binding in BINDINGS)
    assert text.count("<kbd>") == len(BINDINGS)
