"""Readers of laser logs: `open_log` recognises the format and returns a ScanLog."""

from bspline_slam.logs.recognition import open_log

__all__ = ["open_log"]
