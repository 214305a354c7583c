"""Beams as a robot at rest would have seen them, with a laser without bias.

`laser` is (sweep, interlace, offset) of a `LaserCalibration`, `velocity` that of the robot (m/s, m/s, rad/s, its own
frame) and `count` how many beams its scans have.
"""

import math

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def points_at_rest(points, beams, count, x, y, laser, velocity):
    """Beam ends in the robot frame, of beams by their number; the sensor is at (x, y)."""
    out = np.empty_like(points)
    for k in range(len(points)):
        out[k, 0], out[k, 1] = _end(points[k, 0] - x, points[k, 1] - y, beams[k], count, x, y, laser, velocity)
    return out


@njit(cache=True, nogil=True)
def scan_at_rest(ranges, bearings, least, most, x, y, heading, laser, velocity):
    """Ranges and bearings of a whole scan, bearings increasing; those of beams that ended nowhere between `least` and
    `most` stay as they are. The sensor is at (x, y, heading) in the robot frame."""
    new_ranges, new_bearings = ranges.copy(), bearings.copy()
    for k in range(len(ranges)):
        if not least < ranges[k] < most:
            continue
        angle = heading + bearings[k]
        across, up = ranges[k] * math.cos(angle), ranges[k] * math.sin(angle)
        end_x, end_y = _end(across, up, k, len(ranges), x, y, laser, velocity)
        across, up = end_x - x, end_y - y
        turned = math.atan2(up, across) - angle
        new_ranges[k] = math.sqrt(across * across + up * up)
        new_bearings[k] = bearings[k] + math.atan2(math.sin(turned), math.cos(turned))
    order = np.argsort(new_bearings)
    return new_ranges[order], new_bearings[order]


@njit(cache=True, nogil=True)
def _end(ray_x, ray_y, beam, count, x, y, laser, velocity):
    """Where the ray from the sensor ends, seen from where the robot is in the middle of its sweep."""
    sweep, interlace, offset = laser
    reach = math.sqrt(ray_x * ray_x + ray_y * ray_y)
    share = (reach - offset) / reach if reach > offset else 0.0
    px, py = x + share * ray_x, y + share * ray_y
    since = sweep * (beam / max(count - 1, 1) - 0.5) + interlace * (beam % 2 - 0.5)
    c, s = math.cos(since * velocity[2]), math.sin(since * velocity[2])
    return c * px - s * py + since * velocity[0], s * px + c * py + since * velocity[1]
