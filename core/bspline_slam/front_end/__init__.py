"""From scans to poses and a first map: odometry, matching, decisions scan by scan, loop closures."""
