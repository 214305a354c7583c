"""The weights of beams: turned into the frame of their robot, and bounded for those far off."""

import numpy as np

from bspline_slam import se2
from bspline_slam.adjustment.counted_beams import CountedBeams
from bspline_slam.fitting import FittingConfig
from bspline_slam.observation import across_sigma
from bspline_slam.sights import collect_sights, find_feet
from core.mapped_room import PATH, disturbed, seen_from

FITTING, OUTLIER = FittingConfig(), 2.0


def test_beams_count_with_their_noise_and_never_more_than_outlier_standard_deviations_off() -> None:
    poses = disturbed(0.05)
    keys, splines, _ = seen_from(PATH)
    sights = collect_sights(keys, splines)
    feet = find_feet(sights, splines, poses, 0.15)
    counted = CountedBeams.of(sights, feet, poses, FITTING, OUTLIER)
    assert (counted.place == np.flatnonzero(feet.counts)).all()
    world = se2.rotate(poses[sights.pose[counted.place]], counted.normals)
    np.testing.assert_allclose(world, feet.normals[counted.place], atol=1e-12)
    noise = across_sigma(counted.normals, sights.directions[counted.place], sights.ranges[counted.place], FITTING)
    off = np.abs(feet.across[counted.place])
    far = off > OUTLIER * noise
    assert 0 < far.sum() < len(far)
    np.testing.assert_allclose(counted.sigma[~far], noise[~far])
    np.testing.assert_allclose(off[far] / counted.sigma[far], OUTLIER)


def test_chosen_ones_keep_what_they_have() -> None:
    keys, splines, _ = seen_from(PATH)
    sights = collect_sights(keys, splines)
    all_of_them = CountedBeams.of(sights, find_feet(sights, splines, PATH, 0.1), PATH, FITTING, OUTLIER)
    chosen = all_of_them.place % 3 == 0
    some = all_of_them.only(chosen)
    np.testing.assert_array_equal(some.place, all_of_them.place[chosen])
    np.testing.assert_array_equal(some.sigma, all_of_them.sigma[chosen])
