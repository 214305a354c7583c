"""Everything about the pipeline that can be tuned."""

from __future__ import annotations

from dataclasses import dataclass

from bspline_slam.adjustment.adjustment_config import AdjustmentConfig
from bspline_slam.association import AssociationConfig
from bspline_slam.backends import BACK_ENDS
from bspline_slam.errors import ConfigError
from bspline_slam.fitting import FittingConfig
from bspline_slam.front_end.far_loops import FarLoopConfig
from bspline_slam.front_end.loop_closure import LoopConfig
from bspline_slam.front_end.motion import MotionConfig
from bspline_slam.front_end.relocalisation import RelocalisationConfig
from bspline_slam.front_end.scan_matching import MatchingConfig
from bspline_slam.front_end.tracking_config import TrackingConfig
from bspline_slam.localisation import LocalisationConfig
from bspline_slam.models import ChordLengthConfig, make_model
from bspline_slam.models.protocol import Model
from bspline_slam.observation import MODELS
from bspline_slam.segmentation import SegmentationConfig
from bspline_slam.tidying.merging import MergingConfig


@dataclass(frozen=True, slots=True)
class SlamConfig:
    """Everything that can be tuned, stage by stage; the defaults serve every log.

    `model` says what an observation of a spline is, and so of what kind its curves are: its order is `fitting.degree`
    + 1, its knots `fitting.spacing` apart with "normal-distance", its control points `chord_length.control_points` in
    number with "chord-length". `back_end` solves the adjustment. Splines seen by fewer than `least_observations` key
    scans leave the finished map. The map goes along when a loop closure has moved a key scan by more than
    `rebuild_move` (m).
    """

    back_end: str = "direct"
    model: str = MODELS[0]
    segmentation: SegmentationConfig = SegmentationConfig()
    matching: MatchingConfig = MatchingConfig()
    motion: MotionConfig = MotionConfig()
    tracking: TrackingConfig = TrackingConfig()
    association: AssociationConfig = AssociationConfig()
    fitting: FittingConfig = FittingConfig()
    chord_length: ChordLengthConfig = ChordLengthConfig()
    loops: LoopConfig = LoopConfig()
    far_loops: FarLoopConfig = FarLoopConfig()
    relocalisation: RelocalisationConfig = RelocalisationConfig()
    merging: MergingConfig = MergingConfig()
    adjustment: AdjustmentConfig = AdjustmentConfig()
    localisation: LocalisationConfig = LocalisationConfig()
    least_observations: int = 3
    rebuild_move: float = 0.1


def model_of(config: SlamConfig) -> Model:
    """The observation model that a configuration asks for. Raises ConfigError for one that does not exist."""
    return make_model(config.model, config.fitting, config.chord_length)


def check_names(config: SlamConfig) -> None:
    """Raises ConfigError for a back end, a model or curves that do not exist, before any work is done."""
    if config.back_end not in BACK_ENDS:
        raise ConfigError(f'there is no back end "{config.back_end}": choose one of {", ".join(BACK_ENDS)}')
    model_of(config)
