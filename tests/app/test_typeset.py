"""Numbers are set as in print, and nothing else is touched."""

from __future__ import annotations

import pytest

from splinescope.typeset import THIN, typeset


@pytest.mark.parametrize(
    ("plain", "printed"),
    [
        ("-7.7", "−7.7"),
        ("at -8.18, -16.19 m", f"at −8.18, −16.19{THIN}m"),
        ("(-3)", "(−3)"),
        ("93.4% of 86 %", f"93.4{THIN}% of 86{THIN}%"),
        ("44 min 50 s left", f"44{THIN}min 50{THIN}s left"),
        ("9 to 12 mm off", f"9 to 12{THIN}mm off"),
    ],
)
def test_minus_signs_and_units(plain: str, printed: str) -> None:
    assert typeset(plain) == printed
    assert typeset(printed) == printed


@pytest.mark.parametrize("text", ["2026-11-22", "run-2.log", "1e-3", "50 splines", "scan 3 sees", "5–9", "− 3"])
def test_all_else_stays(text: str) -> None:
    assert typeset(text) == text
