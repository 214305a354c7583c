"""Links to an exact moment: which scan, which layers, which place and which colours, as words behind the address."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar
from urllib.parse import parse_qs, urlencode

from splinescope.browser.log_view import place_from
from splinescope.browser.values import Place
from splinescope.view import Colouring, Layer

E = TypeVar("E", Layer, Colouring)


@dataclass(frozen=True, slots=True)
class Link:
    """What a link asks for; None where it leaves things as they are. `nonsense` names words that mean nothing."""

    scan: int | None = None
    layers: frozenset[Layer] | None = None
    place: Place | None = None
    colouring: Colouring | None = None
    nonsense: tuple[str, ...] = ()

    @property
    def empty(self) -> bool:
        """Whether it asks for nothing."""
        return self == Link()

    @property
    def query(self) -> str:
        """The words behind the address: `scan=300&layers=beams,splines&camera=1.2,3.4,0.02&colour=age`."""
        words: dict[str, str] = {}
        if self.scan is not None:
            words["scan"] = str(self.scan)
        if self.layers is not None:
            words["layers"] = ",".join(sorted(_word(layer.name) for layer in self.layers))
        if self.place is not None:
            words["camera"] = ",".join(f"{number:.6g}" for number in self.place)
        if self.colouring is not None:
            words["colour"] = _word(self.colouring.name)
        return urlencode(words, safe=",")

    @staticmethod
    def parse(query: str) -> Link:
        """What the words behind an address ask for; words of others are left alone."""
        told = {name: values[-1] for name, values in parse_qs(query.lstrip("?"), keep_blank_values=True).items()}
        nonsense: list[str] = []
        scan, layers, place, colouring = (told.get(name) for name in ("scan", "layers", "camera", "colour"))
        if scan is not None and not (scan.isascii() and scan.isdigit()):
            nonsense.append(f"scan={scan}")
            scan = None
        known = place_from(place.split(",")) if place is not None else None
        if place is not None and known is None:
            nonsense.append(f"camera={place}")
        chosen = _named(Colouring, colouring) if colouring is not None else None
        if colouring is not None and chosen is None:
            nonsense.append(f"colour={colouring}")
        shown = None if layers is None else {name: _named(Layer, name) for name in layers.split(",") if name}
        nonsense += [f"layer {name}" for name, layer in (shown or {}).items() if layer is None]
        found = None if shown is None else frozenset(layer for layer in shown.values() if layer is not None)
        return Link(None if scan is None else int(scan[:9]), found, known, chosen, tuple(nonsense))


def _word(name: str) -> str:
    return name.lower().replace("_", "-")


def _named(kind: type[E], word: str) -> E | None:
    return kind.__members__.get(word.upper().replace("-", "_"))
