"""The adjusted estimate while the log is still being read: for looking at, for no decision hangs on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.adjustment.adjust import adjust_splines
from bspline_slam.backends.protocol import Cancelling, IterationRecord, never
from bspline_slam.slam_config import SlamConfig, model_of
from bspline_slam.snapshot import Snapshot
from bspline_slam.spline_map import MapSpline, SplineMap

STALE = 0.1
"""Once the front end has moved a key scan by more than that (m), an adjustment of where it was before says nothing."""


@dataclass(frozen=True, eq=False, slots=True)
class Adjusted:
    """An adjustment of the first n key scans, told so that it can be laid over a front end that has gone on meanwhile.

    `front` is where the front end had each key scan when it was adjusted, `poses` where the adjustment put it (world
    frame). `splines` are those adjusted, by id, each beside the one of the front end that it was made of.
    """

    key_scans: Int[np.ndarray, "n"]
    front: Float[np.ndarray, "n 3"]
    poses: Float[np.ndarray, "n 3"]
    splines: Mapping[int, tuple[MapSpline, MapSpline]]

    def fits(self, snapshot: Snapshot) -> bool:
        """Whether the front end still has the adjusted key scans where they were."""
        now = snapshot.poses[self.key_scans]
        return bool(np.abs(now[:, :2] - self.front[:, :2]).max(initial=0.0) < STALE)

    def applied(self, snapshot: Snapshot) -> Snapshot:
        """What the front end has by now, adjusted as far as that is known; the rest goes along.

        Key scans keep their corrections, seen from where the front end has them; later scans, and splines that are
        new or have grown, go along with the nearest adjusted key scan before them.
        """
        scans = snapshot.key_scans
        before = snapshot.poses[scans]
        now = before[: len(self.key_scans)]
        adjusted = se2.compose(now, se2.between(self.front, self.poses))
        motions = se2.compose(adjusted, se2.inverse(now))
        later = se2.compose(motions[-1], before[len(now) :])
        after = np.concatenate([adjusted, later])
        since = se2.compose(adjusted, se2.inverse(self.poses))
        return replace(
            snapshot,
            poses=snapshot.poses_with(after),
            steps=tuple(replace(step, pose=pose) for step, pose in zip(snapshot.steps, after, strict=True)),
            map=SplineMap(tuple(self._adjusted(spline, motions, since) for spline in snapshot.map)),
        )

    def _adjusted(
        self, spline: MapSpline, motions: Float[np.ndarray, "n 3"], since: Float[np.ndarray, "n 3"]
    ) -> MapSpline:
        """A spline of the front end as adjusted, moved as the key scan that began it was moved `since`; one that has
        changed meanwhile as it is, moved by what `motions` the adjustment made."""
        k = max(int(np.searchsorted(self.key_scans, spline.born, side="right")) - 1, 0)
        then, adjusted = self.splines.get(spline.id, (None, spline))
        if then is not None and same_stretch(then, spline):
            return adjusted.moved(since[k])
        return spline.moved(motions[k])


def same_stretch(a: MapSpline, b: MapSpline) -> bool:
    """Whether a spline has neither grown nor been joined between two moments; it may have moved."""
    return a.span == b.span and np.array_equal(a.curve.knots, b.curve.knots)


def adjust_so_far(snapshot: Snapshot, config: SlamConfig, cancelled: Cancelling = never) -> Adjusted:
    """All that the front end has read and decided, adjusted by `direct`: its key scans, splines and loop closures.

    It starts where the front end is, and not where the last adjustment ended: what has closed since then has moved the
    front end, and would lie beyond the gates of a state from before. Raises Cancelled, and SolverError.
    """
    front = snapshot.poses[snapshot.key_scans]
    worthy = snapshot.map.seen_by_at_least(min(config.least_observations, len(front)))
    splines, estimate = adjust_splines(
        snapshot.observations, front, worthy, snapshot.pose_factors, config.adjustment, model_of(config), "direct",
        unheard, cancelled,
    )  # fmt: skip
    before = {spline.id: spline for spline in worthy}
    pairs = {spline.id: (before[spline.id], spline) for spline in splines}
    return Adjusted(snapshot.key_scans, front, estimate.poses, pairs)


def unheard(fraction: float, record: IterationRecord | None) -> None:
    """Progress that nobody hears of."""
