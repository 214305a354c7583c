import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.front_end.odometry_signs import SIGNS, odometry_signs
from bspline_slam.front_end.tracking import Tracker
from bspline_slam.lab.simulation import simulate
from bspline_slam.lab.world_file import open_world
from bspline_slam.slam_config import SlamConfig

C = SlamConfig()
LOG = simulate(open_world("corridor"), rng=np.random.default_rng(3))
ODOMETRY = np.asarray(LOG.odometry)


def with_signs(odometry: np.ndarray, signs: tuple[float, float, float]) -> np.ndarray:
    out = [odometry[0]]
    for step in se2.between(odometry[:-1], odometry[1:]):
        out.append(se2.compose(out[-1], step * signs))
    return np.array(out)


def new_tracker() -> Tracker:
    return Tracker(C.tracking, C.matching, C.segmentation, C.motion)


@pytest.mark.parametrize("signs", SIGNS[:2])
def test_the_sign_of_the_way_is_found_even_in_a_corridor(signs: tuple[float, float, float]) -> None:
    assert odometry_signs(LOG, with_signs(ODOMETRY, signs), new_tracker) == signs


def test_odometry_that_says_nothing_is_taken_as_it_is() -> None:
    assert odometry_signs(LOG, np.zeros_like(ODOMETRY), new_tracker) == SIGNS[0]
