"""Configurations as plain data: nested frozen dataclasses from and to dictionaries, JSON and TOML files."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from enum import Enum
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from bspline_slam.errors import ConfigError

T = TypeVar("T")


def config_from_dict(cls: type[T], data: Mapping[str, Any]) -> T:
    """A configuration with its defaults, changed where `data` says so.

    Raises ConfigError naming the unknown key and the known ones, or the value of the wrong type.
    """
    return _changed(cls(), data, "")


def config_to_dict(config: Any) -> dict[str, Any]:
    """The resolved configuration as nested dictionaries of plain values; the inverse of `config_from_dict`."""
    return {field.name: _plain(getattr(config, field.name)) for field in fields(config)}


def read_config_file(path: Path) -> dict[str, Any]:
    """The dictionary written in a `.json` or `.toml` file."""
    readers = {".json": json.loads, ".toml": tomllib.loads}
    if path.suffix not in readers:
        raise ConfigError(
            f"{path.name}: a configuration is a .json or .toml file, not {path.suffix or 'without suffix'}"
        )
    try:
        data = readers[path.suffix](path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ConfigError(f"there is no configuration file {path}") from None
    except (OSError, ValueError) as error:
        raise ConfigError(f"{path.name} cannot be read: {error}") from None
    if not isinstance(data, dict):
        raise ConfigError(f"{path.name}: a configuration is a table of names and values")
    return data


def _changed(config: Any, data: Mapping[str, Any], place: str) -> Any:
    """`config` with the values of `data`; `place` is the dotted way to it, for sentences."""
    known = get_type_hints(type(config))
    for key in data:
        if key not in known:
            where = f" in {place.rstrip('.')}" if place else ""
            raise ConfigError(f"the configuration has no {place}{key}; known{where}: {', '.join(sorted(known))}")
    return replace(
        config,
        **{key: _value(known[key], value, getattr(config, key), place + key) for key, value in data.items()},
    )


def _value(hint: Any, value: Any, current: Any, place: str) -> Any:
    """`value` as the type that `hint` asks for, or a ConfigError that says what was expected."""
    if is_dataclass(current) and isinstance(value, Mapping):
        return _changed(current, value, place + ".")
    for kind in get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,):
        understood = converted(kind, value)
        if understood is not NOTHING:
            return understood
    raise ConfigError(f"{place} must be {_name(hint)}, not {value!r}")


NOTHING = object()
"""What `converted` says of a value that is none of the kind."""


def converted(kind: Any, value: Any) -> Any:
    """`value` as one plain `kind`, NOTHING when it is none; whole numbers pass for floats, booleans for no number."""
    origin = get_origin(kind)
    if origin is Literal:
        return value if value in get_args(kind) else NOTHING
    if origin is tuple:
        return _converted_tuple(get_args(kind), value)
    if kind is NoneType:
        return None if value is None else NOTHING
    if isinstance(kind, type) and issubclass(kind, Enum):
        return next((member for member in kind if member.value == value), NOTHING)
    if isinstance(value, bool) or kind is bool:
        return value if kind is bool and isinstance(value, bool) else NOTHING
    if kind is float and isinstance(value, int):
        return float(value)
    return value if isinstance(kind, type) and isinstance(value, kind) else NOTHING


def _converted_tuple(kinds: tuple[Any, ...], value: Any) -> Any:
    if not isinstance(value, (list, tuple)):
        return NOTHING
    if len(kinds) == 2 and kinds[1] is Ellipsis:
        kinds = (kinds[0],) * len(value)
    if len(kinds) != len(value):
        return NOTHING
    items = tuple(converted(kind, item) for kind, item in zip(kinds, value, strict=True))
    return NOTHING if any(item is NOTHING for item in items) else items


def _name(hint: Any) -> str:
    """A type in words."""
    if get_origin(hint) in (Union, UnionType):
        return " or ".join(_name(kind) for kind in get_args(hint))
    if get_origin(hint) is Literal:
        return "one of " + ", ".join(map(repr, get_args(hint)))
    if isinstance(hint, type) and issubclass(hint, Enum):
        return "one of " + ", ".join(repr(member.value) for member in hint)
    if is_dataclass(hint):
        return "a table of names and values"
    words = {float: "a number", int: "a whole number", bool: "true or false", str: "a text", NoneType: "empty"}
    return words.get(hint, str(hint))


def _plain(value: Any) -> Any:
    if is_dataclass(value):
        return config_to_dict(value)
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    return value
