"""Each wall one spline: merged where it is shown twice, parted at gaps."""
