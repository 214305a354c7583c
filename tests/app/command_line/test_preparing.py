"""The first run compiles in a stage of its own, which is told; later ones do not."""

from __future__ import annotations

from pathlib import Path

import pytest

from bspline_slam.errors import Cancelled
from bspline_slam.kernels import cache, matching
from splinescope.command_line.preparing import COMPILING, prepare


def test_a_cache_counts_as_filled_from_the_first_compiled_loop_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Stats:
        cache_path = str(tmp_path)

    monkeypatch.setattr(matching, "refine", type("Compiled", (), {"stats": Stats}))
    assert not cache.is_filled()
    (tmp_path / "matching.refine-210.py311.nbi").touch()
    assert cache.is_filled()


def test_nothing_is_compiled_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cache, "is_filled", lambda: True)
    told: list[tuple[str, float]] = []
    prepare(lambda *said: told.append(said), lambda: False)
    assert told == []


def test_a_first_run_says_that_it_compiles_and_how_far_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cache, "is_filled", lambda: False)
    told: list[tuple[str, float]] = []
    prepare(lambda *said: told.append(said), lambda: False)
    assert {stage for stage, _ in told} == {COMPILING}
    shares = [share for _, share in told]
    assert shares == sorted(shares)
    assert shares[0] == 0.0
    assert 0.5 < shares[-1] <= 1.0


def test_compiling_can_be_cancelled(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cache, "is_filled", lambda: False)
    with pytest.raises(Cancelled):
        prepare(lambda *_: None, lambda: True)
