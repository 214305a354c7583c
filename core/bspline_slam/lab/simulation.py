"""Simulated logs: a robot drives through a world, its laser and its odometry err, the truth is kept."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.errors import ConfigError
from bspline_slam.export.logs import WRITERS, log_suffix, truth_path, write_truth
from bspline_slam.lab.world import Laser, World
from bspline_slam.lab.world_file import open_world
from bspline_slam.scan import LaserScan, Records, increasing_times, index_at, interpolate_poses

START = 1259712000.0
"""Stamp of the first record (s): a plausible clock, because zero means "no time" to many tools."""
QUANTUM = 0.01
"""Step of the measured ranges (m), that of common indoor lasers."""

Progress = Callable[[int, int], None]
"""Called with (scans done, scans in all)."""


def silent(done: int, total: int) -> None:
    """Progress that nobody watches."""


@dataclass(frozen=True, slots=True)
class OdometryModel:
    """How wheel odometry errs: a part that is always the same, and a random walk that grows with the way.

    Over d metres and a turn by α: translation ∝ 1 + `scale` with deviation `translation_noise`·√d along the drive and
    a quarter of it across; turn ∝ 1 + `turn_scale`, plus `turn_bias`·d, with deviation `turn_noise`·√d.
    """

    scale: float = 0.02
    translation_noise: float = 0.03
    turn_scale: float = -0.01
    turn_bias: float = float(np.radians(0.25))
    turn_noise: float = float(np.radians(3.0))

    def scaled(self, factor: float) -> OdometryModel:
        """The same model with every error `factor` times as large."""
        return OdometryModel(
            factor * self.scale,
            factor * self.translation_noise,
            factor * self.turn_scale,
            factor * self.turn_bias,
            factor * self.turn_noise,
        )

    def noise_covariance(self, way: float) -> Float[np.ndarray, "3 3"]:
        """Covariance of the random part of one step over `way` metres, (along, across, turn)."""
        deviations = np.array([self.translation_noise, 0.25 * self.translation_noise, self.turn_noise])
        return np.diag(deviations**2 * way)

    def drift(self, truth: Float[np.ndarray, "n 3"], rng: np.random.Generator) -> Float[np.ndarray, "n 3"]:
        """The path that odometry reports for a true path, in a frame of its own that starts at (0, 0, 0)."""
        steps = se2.between(truth[:-1], truth[1:])
        way = np.sqrt(np.linalg.norm(steps[:, :2], axis=1))
        errors = rng.standard_normal(steps.shape)
        deviation = self.translation_noise * way
        along = steps[:, 0] * (1 + self.scale) + deviation * errors[:, 0]
        across = steps[:, 1] * (1 + self.scale) + 0.25 * deviation * errors[:, 1]
        turn = steps[:, 2] * (1 + self.turn_scale) + self.turn_bias * way**2 + self.turn_noise * way * errors[:, 2]
        heading = np.concatenate([[0.0], np.cumsum(turn)])
        moves = np.einsum("nij,nj->ni", se2.rotation(heading[:-1]), np.stack([along, across], -1))
        position = np.concatenate([np.zeros((1, 2)), np.cumsum(moves, axis=0)])
        return np.concatenate([position, se2.wrap(heading)[:, None]], axis=1)


@dataclass(frozen=True, eq=False, slots=True)
class SimulatedLog:
    """A ScanLog in memory, with the true pose of the robot at every record (world frame).

    `shapes` has one array per scan: the shape of the world that each beam met, −1 for none (`World.hits`).
    """

    name: str
    scans: tuple[LaserScan, ...]
    records: Records
    true_poses: Float[np.ndarray, "records 3"]
    shapes: tuple[Int[np.ndarray, "_"], ...] = ()

    @property
    def scan_records(self) -> Int[np.ndarray, "scans"]:
        """Records that hold a scan."""
        return np.flatnonzero(self.records.scan_of_record >= 0)

    @property
    def path(self) -> Path:
        return Path(self.name)

    @property
    def times(self) -> Float[np.ndarray, "scans"]:
        return self.records.times[self.scan_records]

    @property
    def odometry(self) -> Float[np.ndarray, "scans 3"] | None:
        return None if self.records.odometry is None else self.records.odometry[self.scan_records]

    @property
    def truth(self) -> Float[np.ndarray, "scans 3"] | None:
        return self.true_poses[self.scan_records]

    @property
    def notes(self) -> tuple[str, ...]:
        return ()

    @property
    def content_hash(self) -> str:
        """SHA-256 of everything a reader of the log could see."""
        digest = hashlib.sha256(self.records.stamps.tobytes())
        if self.records.odometry is not None:
            digest.update(self.records.odometry.tobytes())
        for scan in self.scans:
            digest.update(scan.ranges.tobytes() + scan.bearings.tobytes())
        return digest.hexdigest()

    def __len__(self) -> int:
        return len(self.scans)

    def __getitem__(self, index: int) -> LaserScan:
        return self.scans[index]

    def __iter__(self) -> Iterator[LaserScan]:
        return iter(self.scans)

    def index_at(self, time: float) -> int:
        """The latest scan at or before `time`; the first scan for earlier times."""
        return index_at(self.times, time)

    def odometry_at(self, time: float) -> Float[np.ndarray, "3"] | None:
        odometry = self.records.odometry
        return None if odometry is None else interpolate_poses(self.records.times, odometry, time)


def simulate(
    world: World,
    *,
    rng: np.random.Generator,
    noise: float = 0.012,
    bearing_noise: float = 1e-3,
    resolution: float | None = None,
    odometry: OdometryModel = OdometryModel(),
    odometry_noise: float = 1.0,
    progress: Progress = silent,
) -> SimulatedLog:
    """Drive through the world once; a record of odometry lies half-way between any two scans.

    `noise` (m) and `bearing_noise` (rad) are standard deviations per beam, `resolution` (rad) replaces the angle
    between beams that the world's laser has, and `odometry_noise` multiplies every error of `odometry`.
    Scans and odometry draw from streams of their own, so changing one leaves the other as it was.
    """
    scan_rng, odometry_rng = rng.spawn(2)
    laser = _with_resolution(world.laser, resolution)
    elapsed, truth = world.drive.poses(world.drive.scan_period / 2)
    stamps = np.round(START + elapsed, 6)
    scan_of_record = np.where(np.arange(len(stamps)) % 2 == 0, np.arange(len(stamps)) // 2, -1)
    total = (len(stamps) + 1) // 2
    scans, shapes = [], []
    for index in range(total):
        ranges, met = measure(world, laser, truth[2 * index], scan_rng, noise, bearing_noise)
        scans.append(
            LaserScan(
                index=index,
                stamp=float(stamps[2 * index]),
                ranges=ranges,
                bearings=laser.bearings,
                range_min=laser.range_min,
                range_max=laser.range_max,
                pose_robot_sensor=laser.pose_robot_sensor,
            )
        )
        shapes.append(met)
        progress(index + 1, total)
    reported = odometry.scaled(odometry_noise).drift(truth, odometry_rng)
    records = Records(stamps, increasing_times(stamps), reported, scan_of_record)
    return SimulatedLog(world.name, tuple(scans), records, truth, tuple(shapes))


def measure(
    world: World,
    laser: Laser,
    pose_world_robot: Float[np.ndarray, "3"],
    rng: np.random.Generator,
    noise: float,
    bearing_noise: float,
) -> tuple[Float[np.ndarray, "beams"], Int[np.ndarray, "beams"]]:
    """Ranges of one scan (m), in steps of 1 cm, and the shapes met; +inf and −1 where nothing lies inside the range of
    the laser."""
    sensor = se2.compose(pose_world_robot, laser.pose_robot_sensor)
    angle = sensor[2] + laser.bearings + bearing_noise * rng.standard_normal(len(laser.bearings))
    ranges, shapes = world.hits(sensor[:2], np.stack([np.cos(angle), np.sin(angle)], -1))
    ranges += noise * rng.standard_normal(len(ranges))
    ranges = np.round(ranges / QUANTUM) * QUANTUM
    seen = ranges < laser.range_max
    return np.where(seen, np.maximum(ranges, laser.range_min), np.inf), np.where(seen, shapes, -1)


def simulate_to_file(
    world: str | Path,
    out: Path,
    *,
    seed: int = 0,
    noise: float = 0.012,
    resolution_deg: float | None = None,
    odometry_noise: float = 1.0,
    progress: Progress = silent,
) -> list[Path]:
    """Simulate a built-in world or a world file into a log with its truth beside it; returns what was written.

    The suffix of `out` (.log, .log.gz, .mcap) decides the format; the truth goes to `<stem>.truth.tum`. Raises
    ConfigError for an unknown world, a wrong world file, a suffix without a format, or a value out of range.
    """
    check_wishes(out, noise=noise, odometry_noise=odometry_noise, seed=seed)
    log = simulate(
        open_world(world),
        rng=np.random.default_rng(seed),
        noise=noise,
        resolution=None if resolution_deg is None else float(np.radians(resolution_deg)),
        odometry_noise=odometry_noise,
        progress=progress,
    )
    return write_simulated(log, out)


def check_wishes(out: Path, **values: float) -> None:
    """Refuse, before any work, a suffix without a format and values that are negative or no numbers (ConfigError)."""
    for name, value in values.items():
        if not 0 <= value < np.inf:
            raise ConfigError(f"{name.replace('_', ' ')} must be a number and not negative, got {value:g}")
    if log_suffix(out) not in WRITERS:
        raise ConfigError(f"{out.name}: a log can be written as {', '.join(WRITERS)}, not as {out.suffix or 'that'}")


def write_simulated(log: SimulatedLog, out: Path) -> list[Path]:
    """Write the log and its truth beside it; returns what was written."""
    out.parent.mkdir(parents=True, exist_ok=True)
    WRITERS[log_suffix(out)](log, out)
    write_truth(log, truth_path(out))
    return [out, truth_path(out)]


def _with_resolution(laser: Laser, resolution: float | None) -> Laser:
    if resolution is None:
        return laser
    if not 0 < resolution <= laser.field_of_view:
        raise ConfigError(
            f"the resolution must be positive and at most the field of view of "
            f"{np.degrees(laser.field_of_view):g}°, got {np.degrees(resolution):g}°"
        )
    return replace(laser, resolution=resolution)
