"""A short simulated drive with its finished map, and a piece in the middle of it."""

from __future__ import annotations

from pathlib import Path

import pytest

from bspline_slam.association import Association
from bspline_slam.edits.ground import Ground
from bspline_slam.logs import open_log
from bspline_slam.slam import run_slam
from bspline_slam.slam_config import SlamConfig
from bspline_slam.snapshot import Snapshot

SAMPLE = Path(__file__).parents[3] / "sample_logs" / "three_splines.log.gz"


@pytest.fixture(scope="session")
def config() -> SlamConfig:
    return SlamConfig()


@pytest.fixture(scope="session")
def base(config: SlamConfig) -> Snapshot:
    return run_slam(open_log(SAMPLE), config).snapshot


@pytest.fixture(scope="session")
def ground(base: Snapshot, config: SlamConfig) -> Ground:
    return Ground.of(base, config)


@pytest.fixture(scope="session")
def piece(base: Snapshot) -> Association:
    """The longest piece of a scan in the middle that is given to a spline."""
    ids = {spline.id for spline in base.map}
    return max((a for a in base.observations[11].associations if a.spline in ids), key=lambda a: a.last - a.first)
