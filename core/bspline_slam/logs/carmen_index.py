"""The index pass over a CARMEN log: every line is looked at once, its readings and its poses are kept."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from bspline_slam.logs.carmen_line import LASERS, POSES, BadLine, LaserLine, parse_laser, parse_pose
from bspline_slam.logs.indexed_log import Progress
from bspline_slam.logs.script_line import CLOCK, SCRIPT_LASERS, SCRIPT_POSES, clock_of, script_pose

SCRIPT = (*SCRIPT_POSES, *SCRIPT_LASERS)
"""Words that begin a line of a script, though `#` begins a comment elsewhere."""

_SAMPLED_SCANS = 400


@dataclass(frozen=True, eq=False, slots=True)
class Entry:
    """A line that was understood: its tag, its stamp and the poses it carries; one of a laser as it is, too."""

    tag: bytes
    stamp: float
    pose: tuple[float, float, float]
    laser: tuple[float, float, float] | None = None
    line: LaserLine | None = None


@dataclass(eq=False, slots=True)
class CarmenIndex:
    """What the pass gathers: entries in the order of recording, PARAM values, and counts of what was met.

    `beams` (tag → number of beams → scans), `samples` (tag → some of its lines), `unmeasured` (tag → readings that are
    negative or not a number), `damaged` (number of the line, rule it breaks), `unknown` (first word → lines). `clock`
    (s) and `place` are the last that lines of a script told.
    """

    lines: int
    clock: float = 0.0
    place: tuple[float, float, float] = (0.0, 0.0, 0.0)
    entries: list[Entry] = field(default_factory=list)
    parameters: dict[str, str] = field(default_factory=dict)
    unknown: Counter[str] = field(default_factory=Counter)
    damaged: list[tuple[int, str]] = field(default_factory=list)
    beams: dict[bytes, Counter[int]] = field(default_factory=lambda: {tag: Counter() for tag in LASERS})
    samples: dict[bytes, list[LaserLine]] = field(default_factory=lambda: {tag: [] for tag in LASERS})
    unmeasured: Counter[bytes] = field(default_factory=Counter)

    @classmethod
    def from_text(cls, text: bytes, progress: Progress) -> CarmenIndex:
        """One pass over all lines: index those that are understood, count the others."""
        ends = np.flatnonzero(np.frombuffer(text, dtype=np.uint8) == ord("\n")).tolist()
        bounds = [-1, *ends] if text.endswith(b"\n") else [-1, *ends, len(text)]
        found = cls(lines=len(bounds) - 1)
        stride = max(found.lines // _SAMPLED_SCANS, 1)
        for number, (before, end) in enumerate(pairwise(bounds), start=1):
            if number % 1000 == 0:
                progress(end / len(text))
            fields = text[before + 1 : end].split()
            if not fields or (fields[0].startswith(b"#") and fields[0] not in SCRIPT):
                continue
            try:
                found.add(fields, sampled=number % stride == 0)
            except BadLine as rule:
                found.damaged.append((number, str(rule)))
        return found

    def add(self, fields: list[bytes], sampled: bool) -> None:
        """Take in one line. BadLine when it begins with a known word but breaks its rule."""
        tag = fields[0]
        if tag in LASERS:
            line = parse_laser(fields)
            stamp, pose, laser = line.stamp, line.pose, line.laser
            if tag in SCRIPT_LASERS:
                stamp, pose, laser = self._now(fields), self.place, self.place
            self.entries.append(Entry(tag, stamp, pose, laser, line))
            self.beams[tag][len(line.readings)] += 1
            self.unmeasured[tag] += len(line.readings) - int(np.count_nonzero(line.readings >= 0))
            if sampled or not self.samples[tag]:
                self.samples[tag].append(line)
        elif tag in POSES:
            pose = parse_pose(fields)
            self.entries.append(Entry(tag, pose.stamp, pose.pose))
        elif tag == CLOCK:
            self._now(fields)
        elif tag in SCRIPT_POSES:
            self.place = script_pose(fields)
            self.entries.append(Entry(b"ODOM", self._now(fields), self.place))
        elif tag == b"PARAM" and len(fields) > 2:
            self.parameters[fields[1].decode("latin-1")] = fields[2].decode("latin-1")
        else:
            word = tag[:24].decode("latin-1")
            self.unknown[word if word.isprintable() else "unreadable"] += 1

    def _now(self, fields: list[bytes]) -> float:
        """The time that a line of a script tells, or the last one told."""
        said = clock_of(fields)
        self.clock = self.clock if said is None else said
        return self.clock

    def parameter(self, name: str) -> float | None:
        """The value of a PARAM line; None where there is none or it is not a number."""
        try:
            value = float(self.parameters[name])
        except (KeyError, ValueError):
            return None
        return value if np.isfinite(value) else None
