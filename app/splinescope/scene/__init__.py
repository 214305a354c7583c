"""Drawing: the scene is a function of the View."""

from splinescope.scene.scene import Scene, bounds_of

__all__ = ["Scene", "bounds_of"]
