"""The twin of a run: its map is the world, its path the truth, its scans hit what the map shows."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import accumulate
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.bspline import BSpline, clamped_knots
from bspline_slam.calibration.odometry import odometry_bias
from bspline_slam.errors import ConfigError, LogError
from bspline_slam.export.map_json import map_to_json
from bspline_slam.export.trajectory import Trajectory
from bspline_slam.lab.disturbances import DisturbanceModel
from bspline_slam.lab.finished_run import FinishedRun
from bspline_slam.lab.simulation import OdometryModel
from bspline_slam.lab.twin import Twin, clear_of, simulate_twin, without_tremble
from bspline_slam.lab.twin_laser import TwinLaser
from bspline_slam.scan import Records
from bspline_slam.spline_map import MapSpline, SplineMap

NOBODY = DisturbanceModel(blocked_every=0, person_every=0)
LASER = TwinLaser(np.radians(np.arange(-90, 91, 2.0)), 0.05, 20.0, np.array([0.1, 0.0, 0.0]))
BIAS = {"distance_scale": 0.95, "turn_scale": 0.98, "turn_per_metre": 0.03, "lag": 0.0}
RADIUS = 5.0


def circle() -> MapSpline:
    """A round room, nearly: a cubic through many control points."""
    angle = np.linspace(0, 2 * np.pi, 200)
    points = RADIUS * np.stack([np.cos(angle), np.sin(angle)], -1)
    curve = BSpline(3, clamped_knots(200), points)
    return MapSpline(4, curve, curve.domain, 0)


def path(count: int = 300) -> np.ndarray:
    """A drive in a ring inside the room."""
    angle = np.linspace(0, 4 * np.pi, count)
    return np.stack([2 * np.cos(angle), 2 * np.sin(angle), se2.wrap(angle + np.pi / 2)], -1)


def written(folder: Path, **changes: Any) -> Path:
    """The results of a run as files, parts of the report replaced."""
    folder.mkdir()
    report: dict[str, Any] = {
        "format": "splinescope-report",
        "log": {"name": "ring.log", "scans": 150, "odometry": True, "content_hash": "0"},
        "laser": LASER.to_dict(),
        "odometry": BIAS,
    }
    map_to_json(SplineMap((circle(),)), {}, folder / "map.json")
    Trajectory(10.0 + 0.1 * np.arange(300), path()).to_tum(folder / "trajectory.tum")
    (folder / "report.json").write_text(json.dumps(report | changes))
    return folder


def twin_of(folder: Path) -> Twin:
    return Twin.from_run(FinishedRun.from_folder(folder))


@pytest.fixture
def twin(tmp_path: Path) -> Twin:
    return twin_of(written(tmp_path / "ring"))


def test_without_noise_every_beam_ends_on_the_map(twin: Twin) -> None:
    log = simulate_twin(twin, rng=np.random.default_rng(0), noise=0.0, bearing_noise=0.0, disturbances=NOBODY)
    assert len(log) == 150 and log.truth is not None
    for scan, pose in zip(log, log.truth, strict=True):
        ends = se2.transform(pose, scan.points_robot[scan.valid])
        assert np.abs(np.linalg.norm(ends, axis=1) - RADIUS).max() < 0.012
        assert np.all(np.isinf(scan.ranges[~scan.valid]))
    assert np.mean([scan.valid.mean() for scan in log]) > 0.99
    assert all(np.array_equal(met >= 0, scan.valid) for met, scan in zip(log.shapes, log, strict=True))


def test_the_laser_is_that_of_the_run(twin: Twin) -> None:
    scan = simulate_twin(twin, rng=np.random.default_rng(0))[7]
    assert np.allclose(scan.bearings, LASER.bearings, atol=1e-7)
    assert np.array_equal(scan.pose_robot_sensor, LASER.pose_robot_sensor) and scan.range_max == LASER.range_max


def test_odometry_errs_as_the_calibration_of_the_run_says(twin: Twin) -> None:
    assert twin.odometry is not None
    rng = np.random.default_rng(0)
    steps = np.stack([rng.uniform(0.05, 0.3, 400), np.zeros(400), rng.uniform(-0.2, 0.2, 400)], -1)
    truth = np.array(list(accumulate(steps, se2.compose, initial=np.zeros(3))))
    exact = replace(twin.odometry, translation_noise=0.0, turn_noise=0.0).drift(truth, rng)
    found = odometry_bias(Records(np.arange(401.0), np.arange(401.0), exact, np.arange(401)), truth)
    assert found is not None
    assert {name: getattr(found, name) for name in BIAS} == pytest.approx(BIAS, abs=1e-6)


def test_odometry_is_as_late_as_that_of_the_run(twin: Twin) -> None:
    late = simulate_twin(replace(twin, lag=2.0), rng=np.random.default_rng(0)).records.odometry
    prompt = simulate_twin(twin, rng=np.random.default_rng(0)).records.odometry
    assert late is not None and prompt is not None and np.allclose(late[2:], prompt[:-2])


def test_odometry_tells_of_the_wheels(twin: Twin) -> None:
    quiet = replace(twin, lever=0.2, odometry=OdometryModel(0.0, 0.0, 0.0, 0.0, 0.0))
    told = simulate_twin(quiet, rng=np.random.default_rng(0)).records.odometry
    assert told is not None
    wheels = se2.compose(twin.poses, np.tile([-0.2, 0.0, 0.0], (len(twin.poses), 1)))
    assert np.allclose(told, se2.between(wheels[0], wheels))


def test_the_seed_decides_everything(twin: Twin) -> None:
    hashes = [simulate_twin(twin, rng=np.random.default_rng(seed)).content_hash for seed in (1, 1, 2)]
    assert hashes[0] == hashes[1] != hashes[2]


def test_more_noise_in_odometry_leaves_the_scans_as_they_were(twin: Twin) -> None:
    one, two = (simulate_twin(twin, rng=np.random.default_rng(3), odometry_noise=factor) for factor in (1.0, 2.0))
    assert all(np.array_equal(a.ranges, b.ranges) for a, b in zip(one, two, strict=True))
    assert one.odometry is not None and two.odometry is not None and not np.allclose(one.odometry, two.odometry)


def test_a_run_without_odometry_has_a_twin_without(tmp_path: Path) -> None:
    noted = {"name": "ring.log", "scans": 300, "odometry": False}
    log = simulate_twin(twin_of(written(tmp_path / "ring", log=noted, odometry=None)), rng=np.random.default_rng(0))
    assert log.odometry is None and len(log) == 300


def test_a_stretch_has_its_scans_alone(twin: Twin) -> None:
    part = twin.stretch(40, 60)
    log = simulate_twin(part, rng=np.random.default_rng(0), disturbances=NOBODY)
    places = np.flatnonzero(twin.scan_of_record >= 0)[40:60]
    assert len(log) == 20 and log.truth is not None and np.array_equal(log.truth, twin.poses[places])
    with pytest.raises(ConfigError, match="has scans 0 to 149, none from 150 on before 200"):
        twin.stretch(150, 200)


def test_what_stands_on_the_path_is_no_part_of_the_world() -> None:
    drive = np.array([[0.0, 0.0, 0.0], [-2.0, 0.0, 0.0], [-12.0, 0.0, 0.0]])
    kept = list(clear_of(drive, SplineMap((circle(),))))
    ends = np.concatenate([curve(np.array(curve.domain)) for curve in kept])
    assert len(kept) == 2 and 0.2 <= np.abs(ends[np.abs(ends[:, 1]) > 1e-6, 1]).min() < 0.26
    for curve in kept:
        points = curve.sample(0.01)[1]
        assert np.abs(np.linalg.norm(points, axis=1) - RADIUS).max() < 0.01
        assert not np.any((points[:, 0] < 0) & (np.abs(points[:, 1]) < 0.2))
    assert sum(curve.length() for curve in kept) == pytest.approx(circle().length - 0.4, abs=0.12)


def test_a_robot_at_rest_does_not_tremble() -> None:
    rng = np.random.default_rng(5)
    rest = np.array([1.0, 2.0, 0.5]) + rng.uniform(-1, 1, (50, 3)) * [0.002, 0.002, 0.001]
    moved = np.concatenate([rest, path(40)])
    still = without_tremble(moved)
    assert np.all(still[:50] == rest[0]) and np.array_equal(still[50:], path(40))


@pytest.mark.parametrize(
    ("file", "content", "words"),
    [
        ("map.json", None, "map.json: is not a readable map"),
        ("map.json", '{"format": "splinescope-map", "version": 1, "splines": []}', "holds no spline"),
        ("map.json", '{"format": "splinescope-map", "version": 1, "splines": [{"id": 1}]}', "cannot be read"),
        ("map.json", '{"format": "splinescope-map", "version": 1}', "cannot be read"),
        ("trajectory.tum", None, "trajectory.tum: is not a readable trajectory"),
        ("report.json", None, "does not tell how the laser sees"),
        ("report.json", "{", "report.json: is not a readable report"),
        ("report.json", "{}", "report.json: is not the report of a run"),
    ],
)
def test_what_is_missing_is_said_in_one_sentence(tmp_path: Path, file: str, content: str | None, words: str) -> None:
    folder = written(tmp_path / "ring")
    (folder / file).unlink() if content is None else (folder / file).write_text(content)
    with pytest.raises((ConfigError, LogError), match=words):
        twin_of(folder)


def test_another_log_is_refused(tmp_path: Path) -> None:
    run = FinishedRun.from_folder(written(tmp_path / "ring"))
    office = Path(__file__).parents[3] / "sample_logs" / "office.log.gz"
    with pytest.raises(LogError, match="is not the log that ring was made from"):
        run.open_log(office)
    with pytest.raises(LogError, match="there is no such log"):
        run.open_log(tmp_path / "nowhere.log")


def test_the_laser_survives_its_way_through_a_report() -> None:
    again = TwinLaser.from_dict(json.loads(json.dumps(LASER.to_dict())))
    assert np.allclose(again.bearings, LASER.bearings, atol=1e-8)
    assert replace(again, bearings=LASER.bearings).to_dict() == LASER.to_dict()
