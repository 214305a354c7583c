"""What logs of other robots may be like: any log, put through one thing that goes wrong.

Each function of `TORTURES` takes a log in memory and a random generator and returns another one. `truth` goes along:
the poses that the estimate is held against, whatever became of scans and odometry.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.lab.simulation import OdometryModel
from bspline_slam.logs.indexed_log import IndexedLog
from bspline_slam.scan import LaserScan, Records, ScanLog, increasing_times


@dataclass(frozen=True, eq=False, slots=True)
class Recorded:
    """Scans with the odometry of each (None without) and the poses to hold the estimate against."""

    scans: tuple[LaserScan, ...]
    odometry: Float[np.ndarray, "n 3"] | None
    truth: Float[np.ndarray, "n 3"]

    @classmethod
    def of(cls, log: ScanLog, truth: Float[np.ndarray, "_ 3"], most: int | None = None) -> Recorded:
        """The first scans of a log, `most` at most."""
        scans = tuple(log[k] for k in range(min(len(log), most or len(log))))
        odometry = None if log.odometry is None else log.odometry[: len(scans)]
        return cls(scans, odometry, truth[: len(scans)])

    def log(self) -> IndexedLog:
        """The same as a log."""
        stamps = np.array([scan.stamp for scan in self.scans])
        records = Records(stamps, increasing_times(stamps), self.odometry, np.arange(len(stamps)))
        scans = [replace(scan, index=k) for k, scan in enumerate(self.scans)]
        return IndexedLog.from_records(Path("tortured.log"), records, self.truth, (), "", scans.__getitem__)

    def chosen(self, kept: Sequence[int] | Int[np.ndarray, "m"]) -> Recorded:
        """Only these scans, in this order."""
        odometry = None if self.odometry is None else self.odometry[np.asarray(kept)]
        return Recorded(tuple(self.scans[k] for k in kept), odometry, self.truth[np.asarray(kept)])

    def driven(self, steps: Callable[[Float[np.ndarray, "m 3"]], Float[np.ndarray, "m 3"]]) -> Recorded:
        """With the steps of odometry changed."""
        if self.odometry is None:
            return self
        path = [np.zeros(3)]
        for step in steps(se2.between(self.odometry[:-1], self.odometry[1:])):
            path.append(se2.compose(path[-1], step))
        return replace(self, odometry=np.array(path))

    def seen(self, look: Callable[[LaserScan], LaserScan]) -> Recorded:
        """With every scan changed."""
        return replace(self, scans=tuple(map(look, self.scans)))


Torture = Callable[[Recorded, np.random.Generator], Recorded]


def as_it_is(log: Recorded, rng: np.random.Generator) -> Recorded:
    return log


def no_odometry(log: Recorded, rng: np.random.Generator) -> Recorded:
    return replace(log, odometry=None)


def frozen_odometry(log: Recorded, rng: np.random.Generator) -> Recorded:
    """Moves once, then never again."""
    return log.driven(lambda steps: steps * (np.arange(len(steps)) < len(steps) // 10)[:, None])


def scaled(*factors: float) -> Torture:
    """Odometry steps (dx, dy, dθ) multiplied by so much."""
    return lambda log, rng: log.driven(lambda steps: steps * np.array(factors))


def jumping_odometry(log: Recorded, rng: np.random.Generator) -> Recorded:
    """A jump by 2 m and 60° every 150 scans on average."""

    def steps(plain: Float[np.ndarray, "m 3"]) -> Float[np.ndarray, "m 3"]:
        jumps = rng.random(len(plain)) < 1.0 / 150
        return plain + jumps[:, None] * rng.normal(size=plain.shape) * np.array([2.0, 2.0, np.radians(60.0)])

    return log.driven(steps)


def drifting_odometry(log: Recorded, rng: np.random.Generator) -> Recorded:
    """Worn wheels: 4 % of the way, 2° in 10 m and a random walk besides."""
    worn = OdometryModel(scale=0.04, turn_bias=float(np.radians(0.2)), turn_noise=float(np.radians(2.0)))
    return log if log.odometry is None else replace(log, odometry=worn.drift(log.truth, rng))


def restarted_odometry(log: Recorded, rng: np.random.Generator) -> Recorded:
    """The counters begin at zero again, twice."""
    if log.odometry is None:
        return log
    parts = np.array_split(log.odometry, 3)
    return replace(log, odometry=np.concatenate([se2.between(part[:1], part) for part in parts]))


def late_odometry(log: Recorded, rng: np.random.Generator) -> Recorded:
    """Each scan has the odometry of the third scan before it."""
    odometry = log.odometry
    return log if odometry is None else replace(log, odometry=odometry[np.maximum(np.arange(len(odometry)) - 3, 0)])


def key_scans(distance: float, turn: float) -> Torture:
    """Only a scan each time that the robot has moved by so many metres or degrees, as corrected logs have them."""

    def torture(log: Recorded, rng: np.random.Generator) -> Recorded:
        kept = [0]
        for k in range(1, len(log.scans)):
            x, y, angle = se2.between(log.truth[kept[-1]], log.truth[k]).tolist()
            if np.hypot(x, y) >= distance or abs(angle) >= np.radians(turn):
                kept.append(k)
        return log.chosen(kept)

    return torture


def in_turn(*tortures: Torture) -> Torture:
    """One after the other."""

    def torture(log: Recorded, rng: np.random.Generator) -> Recorded:
        for one in tortures:
            log = one(log, rng)
        return log

    return torture


def swapped(log: Recorded, rng: np.random.Generator) -> Recorded:
    """x and y of odometry exchanged."""
    return log if log.odometry is None else replace(log, odometry=log.odometry[:, [1, 0, 2]])


def in_degrees(log: Recorded, rng: np.random.Generator) -> Recorded:
    """Headings of odometry in degrees where radians belong."""
    return log if log.odometry is None else replace(log, odometry=log.odometry * np.array([1.0, 1.0, np.degrees(1.0)]))


def every(n: int) -> Torture:
    """Only each n-th scan."""
    return lambda log, rng: log.chosen(range(0, len(log.scans), n))


def thinned(beams: int) -> Torture:
    """About so many beams a scan."""

    def look(scan: LaserScan) -> LaserScan:
        n = max(len(scan.ranges) // beams, 1)
        return replace(scan, ranges=scan.ranges[::n], bearings=scan.bearings[::n])

    return lambda log, rng: log.seen(look)


def cut(limit: float) -> Torture:
    """A laser that sees no farther than `limit` (m)."""

    def look(scan: LaserScan) -> LaserScan:
        return replace(scan, range_max=min(limit, scan.range_max))

    return lambda log, rng: log.seen(look)


def garbage(share: float) -> Torture:
    """So many beams end anywhere."""

    def torture(log: Recorded, rng: np.random.Generator) -> Recorded:
        def look(scan: LaserScan) -> LaserScan:
            wrong = rng.random(len(scan.ranges)) < share
            return replace(scan, ranges=np.where(wrong, rng.uniform(0.1, 10.0, len(wrong)), scan.ranges))

        return log.seen(look)

    return torture


def missing(share: float) -> Torture:
    """So many beams do not come back, in stretches of about ten, as of glass."""

    def torture(log: Recorded, rng: np.random.Generator) -> Recorded:
        def look(scan: LaserScan) -> LaserScan:
            n = len(scan.ranges)
            gone = np.repeat(rng.random(n // 10 + 1) < share, 10)[:n]
            return replace(scan, ranges=np.where(gone, np.inf, scan.ranges))

        return log.seen(look)

    return torture


def crowded(share: float) -> Torture:
    """People around the robot: blobs of about eight beams nearer than the walls; so many beams in all."""

    def torture(log: Recorded, rng: np.random.Generator) -> Recorded:
        def look(scan: LaserScan) -> LaserScan:
            n = len(scan.ranges)
            blob = np.arange(n) // 8
            hidden = (rng.random(n // 8 + 1) < share)[blob]
            near = rng.uniform(0.6, 3.0, n // 8 + 1)[blob] + rng.normal(0.0, 0.03, n)
            return replace(scan, ranges=np.where(hidden, np.fmin(scan.ranges, near), scan.ranges))

        return log.seen(look)

    return torture


def gap(share: float) -> Torture:
    """So large a share is cut out of the middle; odometry goes on."""

    def torture(log: Recorded, rng: np.random.Generator) -> Recorded:
        n = len(log.scans)
        first = n // 2
        return log.chosen([k for k in range(n) if not first <= k < first + round(share * n)])

    return torture


def kidnapped(log: Recorded, rng: np.random.Generator) -> Recorded:
    """Carried, unnoticed by the wheels, from two thirds of the way to a third of it, then driven on from there."""
    n = len(log.scans)
    there = log.chosen([*range(2 * n // 3), *range(n // 3, n)])
    if there.odometry is None:
        return there
    steps = se2.between(there.odometry[:-1], there.odometry[1:])
    steps[2 * n // 3 - 1] = 0.0
    return there.driven(lambda _: steps)


def repeated(log: Recorded, rng: np.random.Generator) -> Recorded:
    """Every third message comes twice."""
    return log.chosen([k for k in range(len(log.scans)) for _ in range(1 + (k % 3 == 0))])


def out_of_order(log: Recorded, rng: np.random.Generator) -> Recorded:
    """Stamps jitter back and forth by more than the time between scans; scans stay in the order of recording."""
    stamps = np.array([scan.stamp for scan in log.scans])
    jitter = rng.normal(0.0, 1.5 * float(np.median(np.abs(np.diff(stamps)))), len(stamps))
    stamped = zip(log.scans, stamps + jitter, strict=True)
    return replace(log, scans=tuple(replace(scan, stamp=float(stamp)) for scan, stamp in stamped))


def no_clock(log: Recorded, rng: np.random.Generator) -> Recorded:
    """All stamps are the same."""
    return log.seen(lambda scan: replace(scan, stamp=0.0))


def clock_backwards(log: Recorded, rng: np.random.Generator) -> Recorded:
    """Stamps run backwards."""
    return log.seen(lambda scan: replace(scan, stamp=-scan.stamp))


def far_codes(log: Recorded, rng: np.random.Generator) -> Recorded:
    """What does not come back is NaN, infinite, 0, or far beyond the range, by turns."""

    def look(scan: LaserScan) -> LaserScan:
        codes = rng.choice([np.nan, np.inf, 0.0, 2.0 * scan.range_max], len(scan.ranges))
        return replace(scan, ranges=np.where(scan.valid, scan.ranges, codes))

    return log.seen(look)


def blind(degrees: float) -> Torture:
    """Posts of the robot itself, at its sides and behind, hide so many degrees of the view."""

    def look(scan: LaserScan) -> LaserScan:
        hidden = np.zeros(len(scan.ranges), dtype=bool)
        for post in np.radians([-80.0, 80.0, 180.0]):
            hidden |= np.abs(se2.wrap(scan.bearings - post)) < np.radians(degrees) / 6
        return replace(scan, ranges=np.where(hidden, 0.15, scan.ranges))

    return lambda log, rng: log.seen(look)


def beams_vary(log: Recorded, rng: np.random.Generator) -> Recorded:
    """Half of the beams in every third scan, the first ten missing in every fifth."""

    def look(scan: LaserScan) -> LaserScan:
        kept = slice(None, None, 2) if scan.index % 3 == 0 else slice(10 if scan.index % 5 == 0 else 0, None)
        return replace(scan, ranges=scan.ranges[kept], bearings=scan.bearings[kept])

    return log.seen(look)


def far_noise(share: float) -> Torture:
    """Ranges that err by such a share of themselves besides (1 σ)."""

    def torture(log: Recorded, rng: np.random.Generator) -> Recorded:
        def look(scan: LaserScan) -> LaserScan:
            return replace(scan, ranges=scan.ranges * (1.0 + share * rng.standard_normal(len(scan.ranges))))

        return log.seen(look)

    return torture


def upside_down(log: Recorded, rng: np.random.Generator) -> Recorded:
    """The laser hangs upside down and nobody says so: left is right, and the map is mirrored."""

    def look(scan: LaserScan) -> LaserScan:
        return replace(scan, ranges=scan.ranges[::-1].copy(), bearings=-scan.bearings[::-1])

    return replace(log, truth=log.truth * np.array([1.0, -1.0, -1.0])).seen(look)


TORTURES: dict[str, Torture] = {
    "as it is": as_it_is,
    "no odometry": no_odometry,
    "frozen odometry": frozen_odometry,
    "x reversed": scaled(-1, -1, 1),
    "turns reversed": scaled(1, -1, -1),
    "odometry × 0.8": scaled(0.8, 0.8, 0.8),
    "odometry × 1.2": scaled(1.2, 1.2, 1.2),
    "odometry jumps": jumping_odometry,
    "odometry late": late_odometry,
    "odometry drifts": drifting_odometry,
    "odometry restarts": restarted_odometry,
    "x and y swapped": swapped,
    "turns in degrees": in_degrees,
    "laser upside down": upside_down,
    "every 2nd scan": every(2),
    "every 3rd scan": every(3),
    "every 5th scan": every(5),
    "a scan every 0.7 m": key_scans(0.7, 20.0),
    "0.7 m and drift": in_turn(drifting_odometry, key_scans(0.7, 20.0)),
    "0.7 m, no odometry": in_turn(no_odometry, key_scans(0.7, 20.0)),
    "90 beams": thinned(90),
    "beams vary": beams_vary,
    "40° blind": blind(40.0),
    "codes of no return": far_codes,
    "1 % of noise": far_noise(0.01),
    "8 m of range": cut(8.0),
    "4 m of range": cut(4.0),
    "5 % garbage": garbage(0.05),
    "30 % missing": missing(0.3),
    "30 % hidden": crowded(0.3),
    "a gap of 3 %": gap(0.03),
    "kidnapped": kidnapped,
    "messages repeated": repeated,
    "stamps jitter": out_of_order,
    "no clock": no_clock,
    "clock backwards": clock_backwards,
}
