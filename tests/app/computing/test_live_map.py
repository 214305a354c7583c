"""The map of a running job: adjusted beside the front end, at rest for most of the time, and never in its way."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.errors import Cancelled, SolverError
from bspline_slam.export.map_json import map_to_json
from bspline_slam.incremental import Adjusted
from bspline_slam.logs import open_log
from bspline_slam.slam import Slam, SlamConfig, SlamStep, Snapshot, run_slam
from bspline_slam.spline_map import SplineMap
from splinescope.computing.live_map import LiveMap

CONFIG = SlamConfig()
ASIDE = np.array([0.1, -0.2, 0.3])


def drive(keys: int) -> Snapshot:
    """Every second scan a key scan, along a bend."""
    along = np.arange(2.0 * keys)
    poses = np.stack([along, np.sin(along), along / 30], -1)
    scans = np.arange(0, 2 * keys, 2)
    steps = tuple(SlamStep(int(scan), poses[scan], poses[scan], True, False, 1.0) for scan in scans)
    return Snapshot(poses, scans, steps, SplineMap(), ())


def aside(front: Snapshot, config: SlamConfig, cancelled: Callable[[], bool]) -> Adjusted:
    """Everything moved as a whole."""
    poses = front.poses[front.key_scans]
    return Adjusted(front.key_scans, poses, se2.compose(ASIDE, poses), {})


def shown_when_done(live: LiveMap, front: Snapshot) -> tuple[Snapshot, int]:
    """What is shown after the adjustment that begins now."""
    live.shown(front)
    live._pool.submit(lambda: None).result()
    return live.shown(front)


def test_the_map_is_shown_adjusted_and_so_are_the_steps_beside_it() -> None:
    with closing(LiveMap(CONFIG, aside, lambda: 0.0)) as live:
        front = drive(20)
        assert live.shown(front) == (front, 0)
        snapshot, adjusted = shown_when_done(live, front)
        assert adjusted == 39
        np.testing.assert_allclose(snapshot.poses, se2.compose(ASIDE, front.poses), atol=1e-9)
        step = live.carried(SlamStep(40, front.poses[-2], front.poses[-1], False, False, 1.0))
        np.testing.assert_allclose(step.pose, se2.compose(ASIDE, front.poses[-1]), atol=1e-9)
        np.testing.assert_allclose(step.predicted, se2.compose(ASIDE, front.poses[-2]), atol=1e-9)


def test_a_front_end_that_went_elsewhere_is_shown_as_it_is() -> None:
    with closing(LiveMap(CONFIG, aside, lambda: 0.0)) as live:
        shown_when_done(live, drive(20))
        closed = drive(20)
        closed.poses[:, 1] += 1.0
        assert live.shown(closed) == (closed, 0)
        step = SlamStep(40, closed.poses[-2], closed.poses[-1], False, False, 1.0)
        assert live.carried(step) is step


def test_nothing_is_begun_twice_for_the_same_key_scans_nor_for_a_few() -> None:
    begun: list[int] = []

    def counted(front: Snapshot, config: SlamConfig, cancelled: Callable[[], bool]) -> Adjusted:
        begun.append(len(front.key_scans))
        return aside(front, config, cancelled)

    with closing(LiveMap(CONFIG, counted, lambda: 0.0)) as live:
        for keys in (3, 20, 20, 21):
            shown_when_done(live, drive(keys))
    assert begun[0] == 20
    assert len(begun) <= 2


def test_it_rests_after_each_adjustment() -> None:
    now, begun = [0.0], []

    def busy(front: Snapshot, config: SlamConfig, cancelled: Callable[[], bool]) -> Adjusted:
        begun.append(len(front.key_scans))
        sum(range(300_000))
        return aside(front, config, cancelled)

    with closing(LiveMap(CONFIG, busy, lambda: now[0])) as live:
        shown_when_done(live, drive(20))
        shown_when_done(live, drive(30))
        assert begun == [20]
        now[0] = 1e6
        shown_when_done(live, drive(30))
        assert begun == [20, 30]


@pytest.mark.parametrize("error", [SolverError("no step lowers the cost"), Cancelled("given up")])
def test_an_adjustment_that_comes_to_nothing_leaves_the_map_of_the_front_end(error: Exception) -> None:
    def fail(front: Snapshot, config: SlamConfig, cancelled: Callable[[], bool]) -> Adjusted:
        raise error

    with closing(LiveMap(CONFIG, fail, lambda: 0.0)) as live:
        front = drive(20)
        assert shown_when_done(live, front) == (front, 0)


def test_closing_gives_up_what_runs() -> None:
    running = threading.Event()

    def endless(front: Snapshot, config: SlamConfig, cancelled: Callable[[], bool]) -> Adjusted:
        running.set()
        while not cancelled():
            pass
        raise Cancelled("given up")

    live = LiveMap(CONFIG, endless, lambda: 0.0)
    live.shown(drive(20))
    assert running.wait(10.0)
    live.close()


def test_the_result_does_not_hang_on_it(tmp_path: Path) -> None:
    log = open_log(Path(__file__).parents[3] / "sample_logs" / "three_splines.log.gz")
    slam = Slam(log)
    with closing(LiveMap(CONFIG)) as live:
        for step in slam.steps():
            if step.scan % 20 == 0:
                live.shown(slam.snapshot())
    beside, alone = slam.finish(), run_slam(log).snapshot
    np.testing.assert_array_equal(beside.poses, alone.poses)
    for name, snapshot in (("a", beside), ("b", alone)):
        map_to_json(snapshot.map, {}, tmp_path / name)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
