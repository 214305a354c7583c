"""Odometry filtered so that its steps tell what scans made of them, which takes out bias and lag at once."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.calibration.odometry import LEAST_TURNS, scan_records, steps
from bspline_slam.scan import Records

REACH = 1
"""A record may be behind its scan, or ahead of it, by so many records: that many steps on both sides have a say."""
LOOSE = 0.2
"""How far (1 σ) the weight of a step may lie from what odometry itself says, 1 for its own and 0 for the others."""
SURE = 1e-4
"""No step between scans is known better than this (m, rad)."""
ROUNDS = 5


def filtered_odometry(
    records: Records, scan_poses: Float[np.ndarray, "scans 3"]
) -> Float[np.ndarray, "records 3"] | None:
    """Odometry as the poses of the first scans say that it should be read; as it is where these tell too little.

    A turn is a weighted sum of the turns and distances of a few steps around it, a distance one of their distances, and
    the estimated frame swings about the wheels. Weights come by least squares from the steps between scans, however
    many records lie between, errors growing with the square root of that number.
    """
    odometry, places = records.odometry, scan_records(records, len(scan_poses))
    if odometry is None or len(places) <= LEAST_TURNS:
        return odometry
    raw, made = steps(odometry), steps(scan_poses)
    turns = _turns(raw, places, made)
    return _chained(odometry[0], np.column_stack([_moves(raw, turns, places, made), turns]))


def _turns(
    raw: Float[np.ndarray, "n 3"], places: Int[np.ndarray, "k"], made: Float[np.ndarray, "k1 3"]
) -> Float[np.ndarray, "n"]:
    """The turn of each step (rad)."""
    rows, plain = np.column_stack([_around(raw[:, 2]), _around(raw[:, 0])]), np.zeros(2 * (2 * REACH + 1))
    plain[REACH] = 1.0
    told, said = _between_scans(rows, places), _between_scans(raw[:, 2:], places)[:, 0]
    seen = said + se2.wrap(made[:, 2] - said)
    return rows @ _weights(told[:, None], seen[:, None], np.diff(places), plain)


def _moves(
    raw: Float[np.ndarray, "n 3"],
    turns: Float[np.ndarray, "n"],
    places: Int[np.ndarray, "k"],
    made: Float[np.ndarray, "k1 3"],
) -> Float[np.ndarray, "n 2"]:
    """The move of each step (m) in the frame of its start; what odometry says of moves aside stays as it is."""
    ahead = _around(raw[:, 0])
    rows = np.zeros((len(raw), 2, ahead.shape[1] + 1))
    rows[:, 0, :-1], rows[:, 1, -1] = ahead, turns
    plain = np.zeros(rows.shape[2])
    plain[REACH] = 1.0
    heading = np.concatenate([[0.0], np.cumsum(turns)])[:-1]
    since = np.zeros(len(raw))
    since[places[0] : places[-1]] = np.repeat(heading[places[:-1]], np.diff(places))
    turn = se2.rotation(heading - since)
    aside = np.column_stack([np.zeros(len(raw)), raw[:, 1]])
    told = _between_scans(turn @ rows, places)
    seen = made[:, :2] - _between_scans(np.einsum("nij,nj->ni", turn, aside), places)
    return rows @ _weights(told, seen, np.diff(places), plain) + aside


def _around(values: Float[np.ndarray, "n"]) -> Float[np.ndarray, "n taps"]:
    """Each value with those of its neighbours, the outermost repeated."""
    return np.lib.stride_tricks.sliding_window_view(np.pad(values, REACH, "edge"), 2 * REACH + 1)


def _between_scans(rows: Float[np.ndarray, "n *c"], places: Int[np.ndarray, "k"]) -> Float[np.ndarray, "k1 *c"]:
    """Sums over the steps from each scan to the next."""
    return np.add.reduceat(rows[: places[-1]], places[:-1])


def _weights(
    rows: Float[np.ndarray, "k d w"],
    seen: Float[np.ndarray, "k d"],
    records: Int[np.ndarray, "k"],
    plain: Float[np.ndarray, "w"],
) -> Float[np.ndarray, "w"]:
    """Least squares over the ordinary steps, those at most five times as far off as the usual one, about `plain`."""
    scale = 1.0 / np.sqrt(records)
    rows, left = rows * scale[:, None, None], (seen - rows @ plain) * scale[:, None]
    change = np.zeros(len(plain))
    for _ in range(ROUNDS):
        off = np.linalg.norm(left - rows @ change, axis=1)
        usual = max(float(np.median(off)), SURE)
        good = off <= 5.0 * usual
        a, b = rows[good].reshape(-1, len(plain)), left[good].ravel()
        change = np.linalg.solve(a.T @ a + np.eye(len(plain)) * (usual / LOOSE) ** 2, a.T @ b)
    return plain + change


def _chained(start: Float[np.ndarray, "3"], made: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "m 3"]:
    """The path of steps from a pose."""
    heading = start[2] + np.concatenate([[0.0], np.cumsum(made[:, 2])])
    moves = np.einsum("nij,nj->ni", se2.rotation(heading[:-1]), made[:, :2])
    places = start[:2] + np.concatenate([np.zeros((1, 2)), np.cumsum(moves, axis=0)])
    return np.column_stack([places, se2.wrap(heading)])
