"""Stretches: they cover their curves, and each has the residuals of its own beams."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam.fitting import FittingConfig
from bspline_slam.lab.residuals import BeamResiduals
from bspline_slam.lab.stretches import LENGTH, Stretches, binned_rms
from core.lab.walls import beams, room


def test_stretches_cover_each_curve_without_gaps() -> None:
    walls = room()
    found = Stretches.of(walls, BeamResiduals.of(beams(0.01), walls, FittingConfig()))
    for spline in walls:
        mine = found.spline == spline.id
        assert found.start[mine][0] == spline.span[0] and found.end[mine][-1] == pytest.approx(spline.span[1])
        assert np.allclose(found.start[mine][1:], found.end[mine][:-1])
        assert spline.length / mine.sum() <= 1.01 * LENGTH


def test_a_place_where_beams_scatter_stands_out() -> None:
    walls, residuals = room(), BeamResiduals.of(beams(0.005), room(), FittingConfig())
    there = (residuals.spline == 1) & (np.abs(residuals.t - 0.5) < 0.1)
    residuals.across[there] += np.where(np.arange(there.sum()) % 2, 0.03, -0.03)
    found = Stretches.of(walls, residuals)
    middle = 0.5 * (found.start + found.end)
    disturbed = (found.spline == walls.splines[1].id) & (np.abs(middle - 0.5) < 0.08)
    others = (found.spline != walls.splines[1].id) & np.isfinite(found.value)
    assert disturbed.any() and found.value[disturbed].min() > 2.0 * found.value[others].max()


def test_where_nothing_was_seen_nothing_is_said() -> None:
    walls, seen = room(), beams(0.005)
    nothing = BeamResiduals.of(seen.part(np.zeros(len(seen), dtype=bool)), walls, FittingConfig())
    assert np.isnan(Stretches.of(walls, nothing).value).all()


def test_binned_figures_are_those_of_each_bin() -> None:
    t = np.repeat([0.5, 1.5, 2.5], [6, 6, 2])
    found = binned_rms(t, np.repeat([0.01, -0.02, 0.03], [6, 6, 2]), np.arange(4.0))
    assert found[:2] == pytest.approx([0.01, 0.02])
    assert np.isnan(found[2])
