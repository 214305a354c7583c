"""Configurations from and to plain data."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Literal

import pytest

from bspline_slam.config import config_from_dict, config_to_dict, read_config_file
from bspline_slam.errors import ConfigError


class Way(Enum):
    SHORT = "short"
    LONG = "long"


@dataclass(frozen=True)
class Matching:
    window: float = 0.5
    steps: int = 3
    gate: float | None = None


@dataclass(frozen=True)
class Config:
    matching: Matching = field(default_factory=lambda: Matching(window=0.7))
    model: Literal["normal-distance", "chord-length"] = "normal-distance"
    way: Way = Way.SHORT
    strict: bool = True
    levels: tuple[float, ...] = (1.0, 0.1)


def test_nothing_said_means_defaults_and_a_part_keeps_its_neighbours() -> None:
    assert config_from_dict(Config, {}) == Config()
    changed = config_from_dict(Config, {"matching": {"steps": 5}})
    assert changed.matching == Matching(window=0.7, steps=5)


def test_every_kind_of_value_goes_there_and_back() -> None:
    config = Config(Matching(1.0, 2, 0.3), "chord-length", Way.LONG, False, (3.0,))
    plain = json.loads(json.dumps(config_to_dict(config)))
    assert config_from_dict(Config, plain) == config


def test_a_whole_number_becomes_a_float() -> None:
    window = config_from_dict(Config, {"matching": {"window": 2}}).matching.window
    assert window == 2.0
    assert isinstance(window, float)


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        ({"modle": "x"}, "no modle; known: levels, matching, model, strict, way"),
        ({"matching": {"windw": 1}}, "no matching.windw; known in matching: gate, steps, window"),
        ({"matching": {"window": "wide"}}, "matching.window must be a number, not 'wide'"),
        ({"matching": {"steps": 1.5}}, "matching.steps must be a whole number"),
        ({"matching": {"steps": True}}, "matching.steps must be a whole number"),
        ({"matching": {"gate": "x"}}, "matching.gate must be a number or empty"),
        ({"matching": 3}, "matching must be a table of names and values"),
        ({"model": "spline"}, "one of 'normal-distance', 'chord-length'"),
        ({"way": "middle"}, "one of 'short', 'long'"),
        ({"strict": 1}, "strict must be true or false"),
        ({"levels": [1, "a"]}, "levels must be"),
    ],
)
def test_a_mistake_is_named_in_a_sentence(data: dict[str, object], sentence: str) -> None:
    with pytest.raises(ConfigError, match=sentence):
        config_from_dict(Config, data)


def test_files_of_both_kinds(tmp_path: Path) -> None:
    (tmp_path / "c.json").write_text('{"matching": {"steps": 4}}')
    (tmp_path / "c.toml").write_text("[matching]\nsteps = 4\n")
    assert read_config_file(tmp_path / "c.json") == read_config_file(tmp_path / "c.toml") == {"matching": {"steps": 4}}


@pytest.mark.parametrize(
    ("name", "text", "sentence"),
    [
        ("c.yaml", "a: 1", ".json or .toml"),
        ("c.json", "{", "cannot be read"),
        ("c.toml", "= 3", "cannot be read"),
        ("c.json", "[1]", "table of names"),
        ("d.json", None, "no configuration file"),
    ],
)
def test_files_that_are_none(tmp_path: Path, name: str, text: str | None, sentence: str) -> None:
    if text is not None:
        (tmp_path / name).write_text(text)
    with pytest.raises(ConfigError, match=sentence):
        read_config_file(tmp_path / name)
