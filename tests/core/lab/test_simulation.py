"""Simulated logs: statistics of their noise, drift, seeds, and the sample logs made from them."""

from __future__ import annotations

import gzip
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.errors import ConfigError
from bspline_slam.lab.simulation import OdometryModel, SimulatedLog, measure, simulate, simulate_to_file
from bspline_slam.lab.world import World
from bspline_slam.lab.world_file import parse_world
from bspline_slam.logs import open_log
from bspline_slam.scan import ScanLog

SAMPLES = Path(__file__).parents[3] / "sample_logs"
SMALL = """{
  "laser": {"field_of_view": 180, "resolution": 1, "range_max": 6, "pose": [0.1, 0, 0]},
  "drive": {"way_points": [[0, 0], [1, 0], [2, 0], [3, 0.5]], "speed": 0.5, "turn_rate": 30, "scan_period": 0.5},
  "shapes": [{"shape": "box", "centre": [2, 0], "size": [9, 4]}, {"shape": "circle", "centre": [4, 1.2], "radius": 0.3}]
}"""


@pytest.fixture
def room() -> World:
    return parse_world(SMALL, "room.json")


def run(world: World, seed: int = 1, **options: Any) -> SimulatedLog:
    return simulate(world, rng=np.random.default_rng(seed), **options)


def test_without_noise_every_range_is_the_exact_one_in_steps_of_a_centimetre(room: World) -> None:
    log = run(room, noise=0.0, bearing_noise=0.0, odometry_noise=0.0)
    for scan, pose in zip(log, log.true_poses[log.scan_records], strict=True):
        sensor = se2.compose(pose, scan.pose_robot_sensor)
        angle = sensor[2] + scan.bearings
        exact = room.cast(sensor[:2], np.stack([np.cos(angle), np.sin(angle)], -1))
        seen = scan.valid
        assert seen.any() and np.abs(scan.ranges - exact)[seen].max() <= 0.005 + 1e-9
        assert np.all(exact[~seen] > room.laser.range_max - 0.005) and np.all(np.isinf(scan.ranges[~seen]))


def test_without_noise_odometry_is_the_truth_from_its_own_start(room: World) -> None:
    log = run(room, odometry_noise=0.0)
    assert log.odometry is not None and log.truth is not None
    assert np.allclose(se2.compose(log.truth[0], log.odometry), log.truth)


def test_range_noise_has_the_deviation_that_was_asked_for() -> None:
    circle = '{"shape": "circle", "centre": [0, 0], "radius": 3}'
    drive = '"drive": {"way_points": [[0, 0], [0.1, 0], [0.2, 0], [0.3, 0]]}'
    world = parse_world(f'{{"laser": {{}}, {drive}, "shapes": [{circle}]}}', "circle.json")
    rng = np.random.default_rng(7)
    ranges = np.concatenate([measure(world, world.laser, np.zeros(3), rng, 0.05, 0.01)[0] for _ in range(50)])
    assert np.mean(ranges) == pytest.approx(3.0, abs=4 * 0.05 / np.sqrt(len(ranges)))
    assert np.std(ranges) == pytest.approx(np.hypot(0.05, 0.01 / np.sqrt(12)), rel=0.04)


def test_bearing_noise_moves_the_beam_along_a_slanting_wall() -> None:
    wall = '{"shape": "polyline", "points": [[2, -50], [2, 50]]}'
    drive = '"drive": {"way_points": [[0, 0], [0.1, 0], [0.2, 0], [0.3, 0]]}'
    world = parse_world(f'{{"laser": {{}}, {drive}, "shapes": [{wall}]}}', "wall.json")
    slant = np.radians(45.0)
    laser = replace(world.laser, field_of_view=2 * slant, resolution=2 * slant)
    rng = np.random.default_rng(8)
    ranges = np.concatenate([measure(world, laser, np.zeros(3), rng, 0.0, 0.01)[0] for _ in range(4000)])
    expected = 2 / np.cos(slant) * np.tan(slant) * 0.01
    assert np.std(ranges) == pytest.approx(expected, rel=0.06)


def test_odometry_errs_by_its_bias_and_its_deviation() -> None:
    model = OdometryModel()
    steps = 4000
    straight = np.stack([0.25 * np.arange(steps + 1), np.zeros(steps + 1), np.zeros(steps + 1)], -1)
    drifted = model.drift(straight, np.random.default_rng(9))
    moved = se2.between(drifted[:-1], drifted[1:])
    turn_deviation, way_deviation = model.turn_noise * 0.5, model.translation_noise * 0.5
    assert np.std(moved[:, 2]) == pytest.approx(turn_deviation, rel=0.05)
    assert np.mean(moved[:, 2]) == pytest.approx(0.25 * model.turn_bias, abs=4 * turn_deviation / np.sqrt(steps))
    assert np.std(moved[:, 0]) == pytest.approx(way_deviation, rel=0.05)
    assert np.mean(moved[:, 0]) == pytest.approx(0.25 * (1 + model.scale), abs=4 * way_deviation / np.sqrt(steps))


def test_a_log_in_memory_is_a_scan_log(room: World) -> None:
    log = run(room)
    assert isinstance(log, ScanLog) and log.name == "room" and log.notes == ()
    assert log.odometry is not None and len(log) == len(log.times) == len(log.odometry) == len(list(log))
    for index in (0, len(log) - 1):
        time = float(log.times[index])
        assert log.index_at(time) == index and log[index].index == index
        pose = log.odometry_at(time)
        assert pose is not None and np.allclose(pose, log.odometry[index])
    assert len(log.records.stamps) in (2 * len(log) - 1, 2 * len(log))


def test_the_same_seed_makes_the_same_log_and_another_does_not(room: World) -> None:
    assert run(room, seed=3).content_hash == run(room, seed=3).content_hash
    assert run(room, seed=3).content_hash != run(room, seed=4).content_hash


def test_another_resolution_leaves_the_odometry_as_it_was(room: World) -> None:
    coarse, fine = run(room), run(room, resolution=float(np.radians(0.5)))
    assert len(fine[0].bearings) == 2 * len(coarse[0].bearings) == 360
    assert fine.odometry is not None and coarse.odometry is not None
    assert np.array_equal(fine.odometry, coarse.odometry)


def test_progress_counts_every_scan(room: World) -> None:
    seen: list[tuple[int, int]] = []
    log = simulate(room, rng=np.random.default_rng(0), progress=lambda done, total: seen.append((done, total)))
    assert seen == [(i + 1, len(log)) for i in range(len(log))]


def test_a_file_comes_with_its_truth_and_the_same_seed_makes_the_same_bytes(tmp_path: Path) -> None:
    world = tmp_path / "room.json"
    world.write_text(SMALL)
    for suffix in (".log", ".log.gz", ".mcap"):
        first = simulate_to_file(world, tmp_path / "one" / f"a{suffix}", seed=5)
        again = simulate_to_file(world, tmp_path / "two" / f"a{suffix}", seed=5)
        assert [path.name for path in first] == [f"a{suffix}", "a.truth.tum"]
        assert [path.read_bytes() for path in first] == [path.read_bytes() for path in again]
        log = open_log(first[0])
        assert log.truth is not None and len(log) == len(log.truth)


@pytest.mark.parametrize(
    ("world", "out", "options", "words"),
    [
        (
            "atrium",
            "a.log",
            {},
            "no world or world file called atrium; the built-in worlds are corridor, office, three_splines",
        ),
        ("three_splines", "a.csv", {}, "a.csv: a log can be written as .log, .log.gz, .mcap, not as .csv"),
        ("three_splines", "a.log", {"noise": -0.1}, "noise must"),
        ("three_splines", "a.log", {"odometry_noise": float("nan")}, "odometry noise must"),
        ("three_splines", "a.log", {"resolution_deg": 0.0}, "resolution must be positive and at most .* 180°"),
        ("three_splines", "a.log", {"resolution_deg": 200.0}, "resolution must be positive and at most .* 180°"),
    ],
)
def test_wrong_wishes_are_answered_with_a_sentence(
    tmp_path: Path, world: str, out: str, options: dict[str, Any], words: str
) -> None:
    with pytest.raises(ConfigError, match=words):
        simulate_to_file(world, tmp_path / out, **options)
    assert not (tmp_path / out).exists()


@pytest.mark.parametrize("name", ["three_splines", "office"])
def test_the_sample_logs_are_what_the_recorded_command_makes(tmp_path: Path, name: str) -> None:
    for path in simulate_to_file(name, tmp_path / f"{name}.log.gz"):
        kept, made = (SAMPLES / path.name).read_bytes(), path.read_bytes()
        if path.suffix == ".gz":
            kept, made = gzip.decompress(kept), gzip.decompress(made)
        assert kept == made


def test_the_sample_bag_holds_the_same_drive_as_the_sample_text() -> None:
    text, bag = open_log(SAMPLES / "office.log.gz"), open_log(SAMPLES / "office.mcap")
    assert len(text) == len(bag) >= 400
    assert text.odometry is not None and bag.odometry is not None
    assert np.allclose(text.odometry, bag.odometry, atol=2e-6) and np.allclose(text.times, bag.times, atol=1e-6)
    for index in range(0, len(text), 50):
        ours, theirs = text[index], bag[index]
        assert np.array_equal(ours.valid, theirs.valid)
        assert np.allclose(ours.ranges[ours.valid], theirs.ranges[theirs.valid], atol=1e-5)
        assert np.allclose(ours.bearings, theirs.bearings, atol=1e-5)


def test_the_odometry_of_the_office_ends_metres_and_tens_of_degrees_off() -> None:
    log = open_log(SAMPLES / "office.log.gz")
    assert log.odometry is not None and log.truth is not None
    off = se2.between(log.truth[-1], se2.compose(log.truth[0], se2.between(log.odometry[0], log.odometry[-1])))
    assert np.linalg.norm(off[:2]) > 2.0 and np.degrees(abs(off[2])) > 15.0


def test_the_samples_are_small() -> None:
    assert sum(path.stat().st_size for path in SAMPLES.iterdir()) < 5e6
