"""How much a match says of a pose, as information matrices (x, y, θ)."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.front_end.scan_matching import Match
from bspline_slam.front_end.tracking_config import TrackingConfig
from bspline_slam.graph import square_root


def matched_information(match: Match, config: TrackingConfig) -> Float[np.ndarray, "3 3"]:
    """Information (wΛ⁻¹ + F)⁻¹ of a match in the frame of its own pose (the frame of PoseFactor residuals).

    Λ is the information of the beams, w `widening` and F the squared `floor`; written so that Λ may be singular.
    """
    root = square_root(turned(match.information, -match.pose[2]))
    floor = np.diag(np.square(config.floor))
    return root.T @ np.linalg.inv(config.widening * np.eye(3) + root @ floor @ root.T) @ root


def turned(information: Float[np.ndarray, "3 3"], heading: float) -> Float[np.ndarray, "3 3"]:
    """An information matrix of a pose with the frame of its position turned by `heading`."""
    turn = np.eye(3)
    turn[:2, :2] = se2.rotation(heading)
    return turn @ information @ turn.T
