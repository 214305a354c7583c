"""A building as long as one likes, for logs as long: blocks in a row, each a ring of corridors with niches.

`python -m bench.street BLOCKS FILE` writes the log of a drive through it, with its truth beside it.
"""

from __future__ import annotations

import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.lab.drive import Drive
from bspline_slam.lab.simulation import START, OdometryModel, SimulatedLog, measure, write_simulated
from bspline_slam.lab.world import Laser, World
from bspline_slam.scan import LaserScan, Records, increasing_times

LENGTH, DEPTH, WIDTH, PASSAGE = 20.0, 12.0, 2.0, 2.0
"""Outer size of a ring, width of its corridors, length of the passage to the next one (m)."""
PITCH = LENGTH + PASSAGE
INTEL_BLOCKS = 8
"""About as many scans and key scans as the log of the Intel Research Lab has."""
PERIOD = 0.17
LASER = Laser(np.pi, np.radians(1.0), 0.05, 15.0, np.zeros(3))


def wall_with_niches(
    start: Float[np.ndarray, "2"], end: Float[np.ndarray, "2"], rng: np.random.Generator
) -> Float[np.ndarray, "_ 2"]:
    """Corners of a wall that steps back, to the right of its direction, into niches of random place, width and
    depth."""
    length = float(np.linalg.norm(end - start))
    along = (end - start) / length
    right = np.array([along[1], -along[0]])
    corners, at = [start], rng.uniform(0.5, 2.0)
    while at + 2.0 < length:
        width, depth = rng.uniform(0.6, 1.6), rng.uniform(0.2, 2.0)
        a, b = start + at * along, start + (at + width) * along
        corners += [a, a + depth * right, b + depth * right, b]
        at += width + rng.uniform(0.8, 3.0)
    return np.array([*corners, end])


def block(number: int, blocks: int, rng: np.random.Generator) -> Float[np.ndarray, "l 2 2"]:
    """Lines of one ring, and of the passage that leads on from it."""
    half, x = WIDTH / 2, number * PITCH
    middle, outer = DEPTH / 2, np.array([[0.0, 0.0], [LENGTH, 0.0], [LENGTH, DEPTH], [0.0, DEPTH]])
    inner = np.array([[WIDTH, WIDTH], [WIDTH, DEPTH - WIDTH], [LENGTH - WIDTH, DEPTH - WIDTH], [LENGTH - WIDTH, WIDTH]])
    walls = [*pairwise(outer[:2]), *pairwise(outer[2:]), *pairwise(np.vstack([inner, inner[:1]]))]
    for side, opens in ((0.0, number > 0), (LENGTH, number < blocks - 1)):
        gap = half if opens else 0.0
        walls += [(np.array([side, 0.0]), np.array([side, middle - gap]))]
        walls += [(np.array([side, middle + gap]), np.array([side, DEPTH]))]
    if number < blocks - 1:
        walls += [(np.array([LENGTH, y]), np.array([PITCH, y])) for y in (middle - half, middle + half)]
    lines = []
    for k, (start, end) in enumerate(walls):
        corners = wall_with_niches(start, end, rng) if k < 6 else np.array([start, end])
        lines += list(pairwise(corners + np.array([x, 0.0])))
    return np.array(lines)


def way_points(number: int, blocks: int) -> list[tuple[float, float]]:
    """Once around the ring and on through its lower half, straight along the corridors."""
    x, half = number * PITCH, WIDTH / 2
    left, right, low, high, middle = half, LENGTH - half, half, DEPTH - half, DEPTH / 2
    lower = [(left, middle), (left, low), (right, low), (right, middle)]
    corners = [*lower, (right, high), (left, high), *lower]
    if number < blocks - 1:
        corners.append((PITCH, middle))
    points: list[tuple[float, float]] = []
    for (ax, ay), (bx, by) in pairwise(corners):
        count = max(round(np.hypot(bx - ax, by - ay)), 1)
        points += [(x + ax + (bx - ax) * k / count, ay + (by - ay) * k / count) for k in range(count)]
    return points


def street_log(blocks: int, seed: int = 0) -> SimulatedLog:
    """The drive through a street of so many blocks. Each scan meets what is within its block and those beside it."""
    rng = np.random.default_rng(seed)
    lines = [block(number, blocks, rng) for number in range(blocks)]
    points = np.array([point for number in range(blocks) for point in way_points(number, blocks)])
    drive = Drive(points, speed=0.5, turn_rate=np.radians(40.0), acceleration=0.5, scan_period=PERIOD)
    elapsed, truth = drive.poses(PERIOD)
    scans = []
    for index, pose in enumerate(truth):
        here = int(np.clip(pose[0] // PITCH, 0, blocks - 1))
        near = np.concatenate(lines[max(here - 1, 0) : here + 2])
        world = World("street", near, np.zeros((0, 5)), (), LASER, drive)
        ranges, _ = measure(world, LASER, pose, rng, 0.012, 1e-3)
        scans.append(
            LaserScan(index, START + elapsed[index], ranges, LASER.bearings, 0.05, 15.0, LASER.pose_robot_sensor)
        )
    stamps = np.round(START + elapsed, 6)
    odometry = OdometryModel().drift(truth, rng)
    records = Records(stamps, increasing_times(stamps), odometry, np.arange(len(stamps)))
    return SimulatedLog("street", tuple(scans), records, se2.between(truth[0], truth))


if __name__ == "__main__":
    write_simulated(street_log(int(sys.argv[1])), Path(sys.argv[2]))
