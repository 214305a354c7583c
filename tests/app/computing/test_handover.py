"""A result with edits goes from one process to another as what differs from the result without."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np

from bspline_slam.edits.amend import amended
from bspline_slam.edits.edit import Edit, Ignore, PinPose
from bspline_slam.logs import open_log
from bspline_slam.slam import SlamConfig, run_slam
from splinescope.computing.handover import packed, unpacked

LOG = Path(__file__).parents[3] / "sample_logs" / "three_splines.log.gz"


def test_what_is_unpacked_elsewhere_is_what_was_packed() -> None:
    config = SlamConfig()
    base = run_slam(open_log(LOG), config).snapshot
    piece = base.observations[11].associations[0]
    x, y, heading = base.steps[20].pose.tolist()
    edits: tuple[Edit, ...] = (
        Ignore(piece.scan, piece.segment, piece.first, piece.last),
        PinPose(base.steps[20].scan, (x + 0.01, y, heading)),
    )
    made = amended(base, edits, config).snapshot
    bytes_of_it = packed(base, made)
    assert len(bytes_of_it) < 0.7 * len(pickle.dumps(made))
    elsewhere = pickle.loads(pickle.dumps(base))
    found = unpacked(elsewhere, bytes_of_it)
    np.testing.assert_array_equal(found.poses, made.poses)
    assert found.observations[12] is elsewhere.observations[12]
    assert next(s.associations for s in found.steps if s.scan == piece.scan)[0].by == "hand"
    for one, other in zip(found.map, made.map, strict=True):
        assert one.id == other.id
        np.testing.assert_array_equal(one.curve.control_points, other.curve.control_points)
    assert found.estimate is not None and made.estimate is not None
    assert found.estimate.chi2 == made.estimate.chi2
    assert len(found.estimate.graph.spline_factors) == len(made.estimate.graph.spline_factors)
