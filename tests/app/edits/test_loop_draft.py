"""A scan is laid over another one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinescope.edits.loop_draft import LoopDraft


def test_two_pairs_of_points_lay_a_scan_where_they_say() -> None:
    draft = LoopDraft(0, 5, np.zeros(3), np.array([1.0, 2.0, 0.5]), np.array([[1.0, 0.0], [0.0, 2.0]]))
    wanted = replace(draft, guess=np.array([-0.5, 0.3, 1.2]))
    for a, b in zip(draft.ghost, wanted.ghost, strict=True):
        draft = draft.marked(*a.tolist()).marked(*b.tolist())
    np.testing.assert_allclose(draft.guess, wanted.guess, atol=1e-9)
    assert draft.marks == ()
