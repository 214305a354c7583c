"""Strategies that draw edits and operations."""

from __future__ import annotations

from hypothesis import strategies as st

from bspline_slam.edits import edit as edits
from bspline_slam.edits.history import Accept, GoTo, Switch

# Edits of all kinds, with whatever numbers.
NUMBERS = st.integers(0, 5000)
METRES = st.floats(-100, 100)
TRIPLES = st.tuples(METRES, METRES, METRES)
PIECES = (NUMBERS, NUMBERS, NUMBERS, NUMBERS)
EDITS = st.one_of(
    *(st.builds(kind, *PIECES, NUMBERS) for kind in (edits.Force, edits.Forbid, edits.MakeNew)),
    st.builds(edits.Ignore, *PIECES),
    st.builds(edits.SplitSegment, NUMBERS, NUMBERS, NUMBERS),
    st.builds(edits.SplitSpline, NUMBERS, st.tuples(METRES, METRES), NUMBERS),
    st.builds(edits.MergeSplines, NUMBERS, NUMBERS),
    st.builds(edits.PinPose, NUMBERS, TRIPLES),
    st.builds(
        edits.PinSpline,
        NUMBERS,
        st.integers(1, 5),
        st.lists(METRES, max_size=5).map(tuple),
        st.lists(st.tuples(METRES, METRES), max_size=5).map(tuple),
        st.tuples(METRES, METRES),
    ),
    st.builds(edits.CloseLoop, NUMBERS, NUMBERS, TRIPLES, st.tuples(TRIPLES, TRIPLES, TRIPLES), METRES, METRES),
    st.builds(edits.DropLoop, NUMBERS, NUMBERS),
)
ACCEPTS = st.builds(
    Accept, st.text(max_size=10), st.floats(0, 1e10), st.lists(EDITS, min_size=1, max_size=3).map(tuple)
)
OPERATIONS = st.one_of(
    ACCEPTS, st.builds(Switch, st.integers(0, 8), st.booleans(), st.floats(0, 1e10)), st.builds(GoTo, st.integers(0, 8))
)
