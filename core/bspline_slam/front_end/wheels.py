"""What wheels say of the way, without their bias, and whether that is to be believed."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.front_end.motion import MotionConfig, OdometryCalibration, Unexplained, step_information, surprise


@dataclass
class Wheels:
    """State of odometry: the bias learnt so far, what it leaves unexplained, its poses at the last scan that was looked
    at and at the last key scan; and where it was `judged` last, as the number of a scan and the odometry there."""

    config: MotionConfig
    calibration: OdometryCalibration = field(default_factory=OdometryCalibration)
    unexplained: Unexplained = field(init=False)
    judged: tuple[int, Float[np.ndarray, "3"] | None] = (0, None)
    _unbiased: Float[np.ndarray, "3 3"] = field(default_factory=lambda: np.eye(3))
    _last: Float[np.ndarray, "3"] | None = None
    _last_key: Float[np.ndarray, "3"] | None = None

    def __post_init__(self) -> None:
        self.unexplained = Unexplained.at_start(self.config)

    @property
    def fit(self) -> bool:
        """Whether odometry fits what scans show."""
        return self.unexplained.fits

    def assume(self, signs: tuple[float, float, float]) -> None:
        """Take odometry (dx, dy, dθ) with these signs until there is something better to learn from."""
        self._calibrate(replace(self.calibration, signs=signs))

    def step(self, odometry: Float[np.ndarray, "3"] | None) -> Float[np.ndarray, "3"] | None:
        """The step since the last scan that was looked at, as read; None where there is no odometry."""
        return None if odometry is None or self._last is None else se2.between(self._last, odometry)

    def key_step(self, odometry: Float[np.ndarray, "3"] | None) -> Float[np.ndarray, "3"] | None:
        """The step since the last key scan."""
        return None if odometry is None or self._last_key is None else se2.between(self._last_key, odometry)

    def unbiased(self, step: Float[np.ndarray, "3"]) -> Float[np.ndarray, "3"]:
        """A step without what is known of its bias."""
        return self._unbiased @ step

    def at_scan(self, odometry: Float[np.ndarray, "3"] | None) -> None:
        """Odometry at a scan that was looked at: steps count from there."""
        self._last = odometry

    def at_key(self, odometry: Float[np.ndarray, "3"] | None) -> None:
        """Odometry at a key scan: key steps count from there."""
        self._last_key = odometry

    def learn(self, step: Float[np.ndarray, "3"], moved: Float[np.ndarray, "3"], gate: float) -> None:
        """Learn the bias from a step and what scans made of it; not from a wrong match or from wheels that slipped."""
        if not self.fit or min(self._off(step, moved)) < gate:
            self._calibrate(self.calibration.learned(step, moved, self.config))

    def judge(
        self,
        scan: int,
        odometry: Float[np.ndarray, "3"],
        made: Float[np.ndarray, "3"],
        seen: Float[np.ndarray, "3 3"],
    ) -> None:
        """Hold the stretch up to `scan`, since odometry was last judged, against what scans `made` of it with
        information `seen`, where it is long enough to tell anything."""
        _, before = self.judged
        assert before is not None
        wheels = self._unbiased @ se2.between(before, odometry)
        if self._counts(made) or self._counts(wheels):
            self.unexplained = self.unexplained.learned(wheels, made, seen, self.config)
            self.judged = (scan, odometry)
            if not self.fit:
                self._calibrate(replace(self.calibration, distrusted=True))

    def _off(self, step: Float[np.ndarray, "3"], moved: Float[np.ndarray, "3"]) -> tuple[float, float]:
        """How far (squared Mahalanobis distance) a matched step lies from odometry without its bias, and as it is."""
        information = step_information(step, self.config)
        unbiased, raw = (surprise(se2.between(told, moved), information) for told in (self._unbiased @ step, step))
        return unbiased, raw

    def _counts(self, step: Float[np.ndarray, "3"]) -> bool:
        return bool(np.hypot(step[0], step[1]) > self.config.judged_distance or abs(step[2]) > self.config.judged_turn)

    def _calibrate(self, calibration: OdometryCalibration) -> None:
        self.calibration, self._unbiased = calibration, calibration.matrix(self.config)
