"""B-spline SLAM on 2D laser logs: from a log file to a map of curves with covariances."""
