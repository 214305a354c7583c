"""Compiled inner loops: numba, plain NumPy arguments, cached on disk; nothing here knows the values of the library."""
