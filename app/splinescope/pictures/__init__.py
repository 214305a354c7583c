"""Drawings beside the map: observations, residuals and consistency as SVG."""
