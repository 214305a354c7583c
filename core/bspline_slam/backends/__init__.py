"""Back ends: each turns a Graph into an Estimate. `back_end("direct")` makes one by name."""

from __future__ import annotations

from importlib import import_module

from bspline_slam.backends.control_points import solve_control_points
from bspline_slam.backends.gauss_newton import Stopping
from bspline_slam.backends.protocol import BackEnd
from bspline_slam.errors import ConfigError

__all__ = ["BACK_ENDS", "FILTERS", "IN_ORDER", "ONE_PASS", "Stopping", "back_end", "solve_control_points"]

_CLASSES = {
    "direct": "Direct",
    "sam": "Sam",
    "isam2": "Isam2",
    "islsjf": "Islsjf",
    "ekf": "Ekf",
    "bs_slam": "BsSlam",
    "idmj": "Idmj",
    "pose_graph": "PoseGraph",
}
BACK_ENDS = tuple(_CLASSES)
"""Names of all back ends, the default first."""
FILTERS = ("ekf", "bs_slam")
"""Those that never come back to what they linearised."""
ONE_PASS = ("isam2", *FILTERS)
"""Those that go through the key scans once, in their order, instead of iterating over all of them."""
IN_ORDER = (*ONE_PASS, "islsjf")
"""Those that take the key scans in their order, whether or not they iterate over all of them in the end."""


def back_end(name: str, stopping: Stopping | None = None) -> BackEnd:
    """The back end of this name; its module is imported only now, for gtsam takes its time to load."""
    if name not in _CLASSES:
        raise ConfigError(f'there is no back end "{name}": choose one of {", ".join(BACK_ENDS)}')
    return getattr(import_module(f"bspline_slam.backends.{name}"), _CLASSES[name])(stopping)
