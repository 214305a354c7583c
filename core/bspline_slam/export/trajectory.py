"""A trajectory: one pose for every record of a log, in the order of recording; TUM files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.bent_path import bent_through
from bspline_slam.calibration.odometry import scan_records
from bspline_slam.calibration.odometry_filter import filtered_odometry
from bspline_slam.errors import LogError
from bspline_slam.scan import Records, increasing_times

HEADER = (
    "# stamp x y z qx qy qz qw (s, m, unit quaternion; world frame; one line per record, in the order of recording)\n"
)


@dataclass(frozen=True, eq=False, slots=True)
class Trajectory:
    """Poses (world frame) with the stamps of their log (s), in the order of recording; stamps may step backwards."""

    stamps: Float[np.ndarray, "records"]
    poses: Float[np.ndarray, "records 3"]

    def __len__(self) -> int:
        return len(self.stamps)

    @classmethod
    def from_scan_poses(cls, records: Records, scan_poses: Float[np.ndarray, "scans 3"]) -> Trajectory:
        """The poses of the scans, and between them odometry with its closing difference spread over the records.

        Odometry is first filtered as the scans say that it should be read. Without odometry the pose between two scans
        is interpolated in time. Records before the first and after the last scan hang on that scan
        by odometry. `scan_poses` may be shorter than the log has scans.
        """
        places = scan_records(records, len(scan_poses))
        poses = scan_poses[records.scan_of_record[places]]
        count = len(records.stamps)
        odometry = filtered_odometry(records, scan_poses)
        if odometry is None:
            return cls(records.stamps, bent_through(np.zeros((count, 3)), places, poses, records.times))
        return cls(records.stamps, bent_through(odometry, places, poses))

    @classmethod
    def from_tum(cls, path: Path) -> Trajectory:
        """Read `stamp x y z qx qy qz qw` lines; raises LogError with the line that is none."""
        rows = []
        try:
            lines = path.read_text(encoding="utf-8").splitlines()
        except (OSError, UnicodeDecodeError) as error:
            raise LogError(path, f"is not a readable trajectory ({error})") from None
        for number, line in enumerate(lines, start=1):
            words = line.partition("#")[0].split()
            if not words:
                continue
            try:
                stamp, x, y, _, qx, qy, qz, qw = map(float, words)
            except ValueError:
                raise LogError(path, "a pose is `stamp x y z qx qy qz qw`, eight numbers", number) from None
            rows.append((stamp, x, y, np.arctan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz))))
        if not rows:
            raise LogError(path, "holds no poses")
        table = np.array(rows)
        return cls(table[:, 0], table[:, 1:])

    def to_tum(self, path: Path) -> None:
        """Write one line per record: stamp (s), position (m), unit quaternion."""
        half = 0.5 * self.poses[:, 2]
        zero = np.zeros(len(self))
        columns = [self.stamps, self.poses[:, 0], self.poses[:, 1], zero, zero, zero, np.sin(half), np.cos(half)]
        with path.open("w", encoding="utf-8") as file:
            file.write(HEADER)
            np.savetxt(file, np.stack(columns, -1), fmt="%.6f %.5f %.5f %g %g %g %.8f %.8f")

    def nearest(self, stamps: Float[np.ndarray, "n"]) -> tuple[Int[np.ndarray, "n"], Float[np.ndarray, "n"]]:
        """The record whose stamp is nearest to each, and how far off it is (s); of equal ones the first recorded."""
        order = np.argsort(self.stamps, kind="stable")
        increasing = self.stamps[order]
        right = np.clip(np.searchsorted(increasing, stamps), 1, max(len(self) - 1, 1))
        left = right - 1
        right = np.minimum(right, len(self) - 1)
        closer = np.where(stamps - increasing[left] <= increasing[right] - stamps, left, right)
        first = np.searchsorted(increasing, increasing[closer], side="left")
        return order[first], np.abs(increasing[closer] - stamps)

    def at(self, stamps: Float[np.ndarray, "n"], tolerance: float = 1e-4) -> Float[np.ndarray, "n 3"]:
        """The pose of the record that has this stamp (within `tolerance`, s), else interpolated between records.

        Interpolation runs on the increasing axis made from the stamps; NaN outside it.
        """
        record, off = self.nearest(stamps)
        times = increasing_times(self.stamps)
        right = np.clip(np.searchsorted(times, stamps), 1, max(len(self) - 1, 1))
        left, right = right - 1, np.minimum(right, len(self) - 1)
        span = np.where(times[right] > times[left], times[right] - times[left], 1.0)
        between = se2.interpolate(self.poses[left], self.poses[right], (stamps - times[left]) / span)
        between[(stamps < times[0]) | (stamps > times[-1])] = np.nan
        return np.where((off <= tolerance)[:, None], self.poses[record], between)
