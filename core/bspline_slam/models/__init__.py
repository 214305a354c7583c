"""The observation models by name."""

from __future__ import annotations

from bspline_slam.errors import ConfigError
from bspline_slam.fitting import FittingConfig
from bspline_slam.models.chord_length import ChordLength, ChordLengthConfig
from bspline_slam.models.normal_distance import NormalDistance
from bspline_slam.models.protocol import Model
from bspline_slam.observation import MODELS

LARGEST_DEGREE = 5


def make_model(name: str, fitting: FittingConfig, chord_length: ChordLengthConfig) -> Model:
    """The model of this name.

    Raises ConfigError for an unknown name, a degree that is not offered, or fewer control points than it needs.
    """
    if name not in MODELS:
        raise ConfigError(f'there is no model "{name}": choose one of {", ".join(MODELS)}')
    if not 1 <= fitting.degree <= LARGEST_DEGREE:
        raise ConfigError(f"curves have a degree from 1 to {LARGEST_DEGREE}, not {fitting.degree}")
    if name == MODELS[0]:
        return NormalDistance(fitting)
    if chord_length.control_points <= fitting.degree:
        raise ConfigError(
            f"a spline of degree {fitting.degree} has at least {fitting.degree + 1} control points, "
            f"not {chord_length.control_points}"
        )
    return ChordLength(fitting, chord_length)
