"""The browser workbench of B-spline SLAM."""
