"""The map adjusted: curves trimmed, knots chosen, poses and control points solved for."""
