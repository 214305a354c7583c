"""What goes between the page's process and the editor's: requests one way, answers the other, all frozen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float

from bspline_slam.association import Association
from bspline_slam.edits.doubts import Doubt
from bspline_slam.edits.edit import Edit
from bspline_slam.edits.explain import Explanation
from bspline_slam.front_end.loop_closure import LoopClosure
from bspline_slam.slam import SlamConfig, Snapshot
from bspline_slam.spline_map import SplineMap
from splinescope.computing.messages import Message
from splinescope.computing.solution import Solution


@dataclass(frozen=True, eq=False, slots=True)
class Prepare:
    """Get ready for edits of a finished result, `kept` as it was sent."""

    job: int
    kept: bytes
    config: SlamConfig


@dataclass(frozen=True, eq=False, slots=True)
class FindPreview:
    """What would edits do to the result with those in force?"""

    job: int
    in_force: tuple[Edit, ...]
    proposed: tuple[Edit, ...]


@dataclass(frozen=True, eq=False, slots=True)
class MakeEdits:
    """The result with these edits and no others; just now it is shown with those `shown`."""

    job: int
    edits: tuple[Edit, ...]
    shown: tuple[Edit, ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class MatchLoop:
    """Match a key scan to the surroundings of an earlier one, from a guess of how it lies there (x, y, θ)."""

    job: int
    in_force: tuple[Edit, ...]
    earlier: int
    scan: int
    guess: Float[np.ndarray, "3"]


@dataclass(frozen=True, slots=True)
class HandOver:
    """The result with these edits for the estimator."""

    job: int
    edits: tuple[Edit, ...]


EditRequest = Prepare | FindPreview | MakeEdits | MatchLoop | HandOver


@dataclass(frozen=True, eq=False, slots=True)
class Ghost:
    """What would look different: the path (None: hardly anywhere), the splines that would move or come, the ids of
    those that would be gone, the decisions of key scans, and the loop closures (None: the same)."""

    poses: Float[np.ndarray, "scans 3"] | None
    splines: SplineMap
    gone: tuple[int, ...] = ()
    decided: Mapping[int, tuple[Association, ...]] = field(default_factory=dict)
    closures: tuple[LoopClosure, ...] | None = None

    def over(self, snapshot: Snapshot) -> Snapshot:
        """The result that it is the ghost of, as it would look."""
        poses = snapshot.poses if self.poses is None or self.poses.shape != snapshot.poses.shape else self.poses
        splines = {spline.id: spline for spline in (*snapshot.map, *self.splines) if spline.id not in self.gone}
        ordered = SplineMap(tuple(splines[number] for number in sorted(splines)))
        closures = snapshot.loop_closures if self.closures is None else self.closures
        return replace(snapshot, poses=poses, map=ordered, loop_closures=closures)


@dataclass(frozen=True, eq=False, slots=True)
class Preview:
    """What edits would do, as names and values, with the ghost of the result; `refusal` says why they cannot be
    made."""

    rows: tuple[tuple[str, str], ...] = ()
    ghost: Ghost | None = None
    refusal: str | None = None
    final: bool = False


@dataclass(frozen=True, eq=False, slots=True)
class PreviewFound(Message):
    """A preview; a better one may follow."""

    preview: Preview


@dataclass(frozen=True, eq=False, slots=True)
class QuickAnswer(Message):
    """Where the edits take the map, nearly."""

    ghost: Ghost


@dataclass(frozen=True, eq=False, slots=True)
class EditsMade(Message):
    """The result with edits, for looking at; the decisions of key scans that are not those of the automatic result;
    what the solver did, and the figures of its solution. With `same_closures` the loop closures are as they were
    there."""

    snapshot: Snapshot
    associations: dict[int, tuple[Association, ...]]
    explanation: Explanation | None
    solution: Solution | None
    same_closures: bool = False


@dataclass(frozen=True, eq=False, slots=True)
class Handed(Message):
    """The result with these edits, packed for the estimator."""

    edits: tuple[Edit, ...]
    amended: bytes


@dataclass(frozen=True, eq=False, slots=True)
class DoubtsFound(Message):
    """The most doubtful decisions behind the map with the edits asked for, the worst first."""

    doubts: tuple[Doubt, ...]


@dataclass(frozen=True, eq=False, slots=True)
class LoopMatched(Message):
    """How the scan matcher would have the two scans lie (None: it found nothing), and how well they agree."""

    measured: Float[np.ndarray, "3"] | None
    sqrt_information: Float[np.ndarray, "3 3"] | None = None
    score: float = 0.0
    inliers: float = 0.0
    sentence: str = ""
