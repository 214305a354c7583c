"""What gets in the way of a laser in a building with people: somebody stands before it, others walk by."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from bspline_slam.lab.world import arc_ranges

NEAREST = 0.5
"""Somebody who would come nearer than this (m) steps out of the way of the robot."""


@dataclass(frozen=True, slots=True)
class DisturbanceModel:
    """How often the laser is disturbed: one event each for so many scans on average (0 for never).

    While it is blocked, for `blocked_scans` scans (least, most), `blocked_share` of its beams end at `blocked_range` m
    (least, most). People are discs of `radius` that walk along the robot's own path at `pace` m/s, towards it or away
    from it, for `seconds` each.
    """

    blocked_every: float = 600.0
    blocked_scans: tuple[int, int] = (3, 12)
    blocked_share: float = 0.95
    blocked_range: tuple[float, float] = (0.15, 0.5)
    person_every: float = 80.0
    radius: float = 0.2
    pace: float = 1.0
    aside: float = 0.4
    seconds: float = 12.0


USUAL = DisturbanceModel()


@dataclass(frozen=True, eq=False, slots=True)
class Disturbances:
    """Where something stood in the way: the range at which each scan was blocked (NaN: it was not), and for each
    person the scans of its walk with the centre of its disc there."""

    model: DisturbanceModel
    blocked_at: Float[np.ndarray, "scans"]
    walks: tuple[tuple[Int[np.ndarray, "_"], Float[np.ndarray, "_ 2"]], ...]

    @classmethod
    def drawn(
        cls,
        model: DisturbanceModel,
        times: Float[np.ndarray, "scans"],
        positions: Float[np.ndarray, "scans 2"],
        rng: np.random.Generator,
    ) -> Disturbances:
        """Chosen at random for a robot that was at `positions` (world frame, m) at `times` (s)."""
        blocked_at = np.full(len(times), np.nan)
        for first in _events(len(times), model.blocked_every, rng):
            last = first + int(rng.integers(*model.blocked_scans, endpoint=True))
            blocked_at[first:last] = rng.uniform(*model.blocked_range)
        walks = [_walk(model, first, times, positions, rng) for first in _events(len(times), model.person_every, rng)]
        return cls(model, blocked_at, tuple(walks))

    def people_at(self, scan: int) -> Float[np.ndarray, "p 2"]:
        """Centres of the people of that scan (world frame)."""
        centres = [path[scans == scan] for scans, path in self.walks if scans[0] <= scan <= scans[-1]]
        return np.concatenate([np.zeros((0, 2)), *centres])

    def shortened(
        self,
        scan: int,
        ranges: Float[np.ndarray, "beams"],
        origin: Float[np.ndarray, "2"],
        directions: Float[np.ndarray, "beams 2"],
        rng: np.random.Generator,
    ) -> tuple[Float[np.ndarray, "beams"], Bool[np.ndarray, "beams"]]:
        """The ranges with everything that stands in the way, and which beams it stops."""
        reach = np.full(len(ranges), np.inf)
        people = self.people_at(scan)
        people = people[np.linalg.norm(people - origin, axis=1) > NEAREST]
        if len(people):
            circle = np.array([self.model.radius, 0.0, 2 * np.pi])
            reach = arc_ranges(np.column_stack([people, np.tile(circle, (len(people), 1))]), origin, directions)
        if not np.isnan(self.blocked_at[scan]):
            hidden = rng.random(len(ranges)) < self.model.blocked_share
            reach = np.where(hidden, np.minimum(reach, self.blocked_at[scan]), reach)
        return np.minimum(ranges, reach), reach < ranges


def _events(scans: int, every: float, rng: np.random.Generator) -> Iterator[int]:
    """First scans of so many events as come by chance, in order."""
    count = rng.poisson(scans / every) if every > 0 else 0
    yield from map(int, np.sort(rng.integers(0, scans, count)))


def _walk(
    model: DisturbanceModel,
    first: int,
    times: Float[np.ndarray, "scans"],
    positions: Float[np.ndarray, "scans 2"],
    rng: np.random.Generator,
) -> tuple[Int[np.ndarray, "w"], Float[np.ndarray, "w 2"]]:
    """A walk along the path of the robot, a little aside: there is room for a person wherever a robot has been."""
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(positions, axis=0), axis=1))])
    last = int(np.searchsorted(times, times[first] + model.seconds, side="right"))
    lead, direction = rng.uniform(1.0, 8.0) * rng.choice([-1.0, 1.0]), rng.choice([-1.0, 1.0])
    gone = way[first] + lead + direction * model.pace * (times[first:last] - times[first])
    angle = rng.uniform(-np.pi, np.pi)
    aside = model.aside * np.array([np.cos(angle), np.sin(angle)])
    centres = np.stack([np.interp(gone, way, positions[:, axis]) for axis in (0, 1)], -1) + aside
    return np.arange(first, last), centres
