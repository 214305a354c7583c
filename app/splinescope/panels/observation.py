"""One observation, step by step: from the beams of a segment to the decision which part of its spline they saw."""

from __future__ import annotations

import numpy as np
import viser

from bspline_slam.relation import EndComparison, EndRelation, Relation
from splinescope import table
from splinescope.commands import Seek, Select, ShowObservation, StepObservation
from splinescope.observation_view import CHORD_LENGTH, ObservationStep, ObservationView
from splinescope.palette import theme
from splinescope.panels.panel import Post, on_choice, on_press
from splinescope.pictures.observation import observation_picture
from splinescope.session import Session
from splinescope.view import Selection

WIDTH = 360.0
"""Of the window (px)."""
BACK, NEXT = "← Back", "Next →"
MOST_ROWS = 9
"""Of a longer list so many rows are shown, evenly chosen."""
RELATIONS = {
    Relation.FULL: "Both ends coincide with those of the spline: the scan saw the full spline again.",
    Relation.PART: "Neither end goes beyond the spline: the scan saw a part of it.",
    Relation.EXTENSION: "The data go beyond an end of the spline: they extend it.",
}
ENDS = {EndRelation.COINCIDES: "coincides", EndRelation.INSIDE: "inside", EndRelation.BEYOND: "beyond"}


class ObservationPanel:
    """A window beside the map: the steps of the selected segment, with buttons to go on, back, and elsewhere."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        self._segment: Selection | None = None
        self._piece: Selection | None = None
        self._key_scan = 0
        self._window = gui.add_panel(visible=False)
        with self._window.add_tab("Observation"):
            self._head = gui.add_html("")
            self._steps = gui.add_button_group("Step", (BACK, NEXT), visible=False)
            self._body = gui.add_html("")
            self._next_key = gui.add_button("Go to the next key scan", visible=False)
            self._next_piece = gui.add_button("Next piece of this segment", color="gray", visible=False)
            self._next_segment = gui.add_button("Take the longest segment", visible=False)
            close = gui.add_button("Close", hint="Key s", color="gray")
        self._window.dock_left()
        self._window.set_width(WIDTH)
        on_choice(self._steps, lambda chosen: post(StepObservation(1 if chosen == NEXT else -1)))
        on_press(close, lambda: post(ShowObservation(False)))
        on_press(self._next_piece, lambda: post(Select(self._piece)))
        on_press(self._next_segment, lambda: post(Select(self._segment)))
        on_press(self._next_key, lambda: post(Seek(self._key_scan)))

    def refresh(self, session: Session) -> None:
        self._window.visible = session.observing
        if not session.observing:
            return
        view, step = session.observation, session.observation_step
        self._head.content = table.block(*headline(view))
        self._steps.visible = self._body.visible = isinstance(view, ObservationView)
        self._steps.label = f"Step {step.number} of {len(ObservationStep)}"
        if isinstance(view, ObservationView):
            drawn = observation_picture(view, step, theme(session.preferences.dark))
            title = table.heading(f"{step.number}. {step.value}")
            self._body.content = table.block(title, drawn, *explanation(view, step))
        self._offer(session, view)

    def _offer(self, session: Session, view: ObservationView | str) -> None:
        """The ways to something else to step through."""
        scan = session.scan_view
        self._next_segment.visible = scan is not None and scan.key and len(scan.segments) > 0
        if scan is not None and scan.segments:
            self._segment = following_segment(view, [len(f.segment.beams) for f in scan.segments])
        self._next_segment.label = "Next segment" if isinstance(view, ObservationView) else "Take the longest segment"
        self._next_piece.visible = isinstance(view, ObservationView) and view.pieces > 1
        if isinstance(view, ObservationView):
            self._piece = Selection("segment", view.segment.index, (view.piece + 1) % max(view.pieces, 1))
        following = following_key_scan(session)
        self._next_key.visible = scan is not None and not scan.key and following is not None
        self._key_scan = following or 0


def following_segment(view: ObservationView | str, beams: list[int]) -> Selection:
    """The segment after the one in view; the one of most beams to begin with."""
    index = (view.segment.index + 1) % len(beams) if isinstance(view, ObservationView) else int(np.argmax(beams))
    return Selection("segment", index)


def following_key_scan(session: Session) -> int | None:
    """The nearest key scan after the cursor, else the last one before it."""
    keys = [step.scan for step in session.findings.steps.values() if step.key]
    return min((scan for scan in keys if scan > session.cursor), default=max(keys, default=None))


def headline(view: ObservationView | str) -> list[str]:
    """Which observation it is, or what is missing, as HTML parts."""
    if isinstance(view, str):
        return [table.paragraph(ABOUT, "dim"), table.paragraph(view)]
    piece = f" · piece {view.piece + 1} of {view.pieces}" if view.pieces > 1 else ""
    beams = f"{len(view.segment.beams)} beams{piece} · keys b, n"
    parts = [table.paragraph(f"Segment {view.segment.index} of key scan {view.scan} · {beams}", "dim")]
    if view.model != CHORD_LENGTH:
        parts.append(table.paragraph(f"This run observes by {view.model}; the paper would do it so:", "dim"))
    return parts


ABOUT = (
    "How a segment becomes an observation, as the paper has it: chord-length parameters, basis, control points, "
    "covariance, and the decision which part of its spline was seen."
)


def explanation(view: ObservationView, step: ObservationStep) -> list[str]:
    """A step in words and numbers, as HTML parts."""
    match step:
        case ObservationStep.PARAMETERS:
            return _parameters(view)
        case ObservationStep.BASIS:
            return _basis(view)
        case ObservationStep.CONTROL_POINTS:
            return _control_points(view)
        case ObservationStep.COVARIANCE:
            return _covariance(view)
        case ObservationStep.RELATION:
            return _relation(view)


def chosen(count: int) -> list[int]:
    """Which of so many rows a list shows."""
    return np.unique(np.linspace(0, count - 1, min(count, MOST_ROWS)).round().astype(int)).tolist()


def _parameters(view: ObservationView) -> list[str]:
    steps = view.steps
    rows = [
        (str(j + 1), str(view.segment.beams[j]), f"{steps.lengths[j]:.3f}", f"{steps.parameters[j]:.3f}")
        for j in chosen(len(steps.points))
    ]
    return [
        table.paragraph(
            "Where on its curve does a beam end lie? The length l of the chords up to it, as a share of the whole "
            f"length of {steps.lengths[-1]:.2f} m: t = l / {steps.lengths[-1]:.2f} m (eqs 8–10). Noise makes chords "
            "longer, so t depends a little on where the robot stood."
        ),
        table.table(("j", "Beam", "Length l (m)", "t"), rows, numbers=range(4)),
        *_some_of(len(steps.points), "points"),
    ]


def _some_of(count: int, what: str) -> list[str]:
    return [table.paragraph(f"{len(chosen(count))} of {count} {what}.", "dim")] if count > MOST_ROWS else []


def _basis(view: ObservationView) -> list[str]:
    m, n = view.steps.basis.shape
    degree = view.steps.curve.degree
    return [
        table.paragraph(
            f"The curve is a sum of {n} basis functions of degree {degree}, each times its control point. Row j of "
            f"the {m} × {n} matrix B holds their values at the parameter of point j (a tick below): at most "
            f"{degree + 1} are not zero, and they add up to 1 (eqs 2, 3, 7). A stronger square is a larger value."
        )
    ]


def _control_points(view: ObservationView) -> list[str]:
    steps = view.steps
    rows = [(str(i + 1), f"{x:.3f}", f"{y:.3f}") for i, (x, y) in enumerate(steps.curve.control_points)]
    return [
        table.paragraph(
            "Least squares: the control points q that bring the curve nearest to all points at their parameters, "
            f"q = (BᵀB)⁻¹Bᵀd (eqs 4–6). What is left is {1000 * steps.rms:.1f} mm (root mean square)."
        ),
        table.table(("i", "x (m)", "y (m)"), rows, numbers=range(3)),
        table.paragraph("Seen from the sensor: x ahead, y to the left.", "dim"),
    ]


def _covariance(view: ObservationView) -> list[str]:
    terms, noise = view.steps.terms, view.steps.noise
    deviations = [deviation(blocks) for blocks in (terms.noise, terms.resolution, terms.chord_error, terms.total)]
    rows = [(str(i + 1), *(f"{1000 * column[i]:.1f}" for column in deviations)) for i in range(len(terms.noise))]
    return [
        table.paragraph(
            "How far off may a control point be? Three terms add up: the noise of the beams carried through the fit, "
            f"P_s (eqs 11, 12); the resolution of the sensor, P_t1 = {noise.resolution:g} m² (eq. 13); and chords "
            f"taken for arcs, P_t2 = min(t, 1 − t) · {noise.cons:g} m², nothing at the ends and most in the middle "
            "(eq. 14)."
        ),
        table.table(("i", "P_s", "P_t1", "P_t2", "Sum"), rows, numbers=range(5)),
        table.paragraph("Largest standard deviation of each control point (mm).", "dim"),
    ]


def deviation(blocks: np.ndarray) -> np.ndarray:
    """Standard deviation of each control point in its least certain direction (m)."""
    return np.sqrt(np.maximum(np.linalg.eigvalsh(blocks)[:, -1], 0.0))


def _relation(view: ObservationView) -> list[str]:
    if isinstance(view.relation, str):
        return [table.paragraph(view.relation)]
    association, seen = view.association, view.relation
    threshold = np.degrees(seen.config.threshold)
    spline = association.spline if association is not None else None
    noted = association.relation.value if association is not None and association.relation is not None else "–"
    ends = (("start (d_s, s_s)", seen.decision.start, True), ("end (d_e, s_e)", seen.decision.end, False))
    rows = [end_row(name, end, is_start, seen.decision.start, seen.decision.end) for name, end, is_start in ends]
    first, last = seen.decision.span
    return [
        table.paragraph(
            f"Which part of spline {spline} did these beams see? The bearings of the ends of the data are compared "
            f"with those of the ends of the spline; less than h = {threshold:g}° apart counts as the same (section 4)."
        ),
        table.table(("End", "Data", "Spline", "Inwards", "Decision"), rows, numbers=(1, 2, 3, 4)),
        table.heading(f"Relation: {seen.decision.relation.value}"),
        table.paragraph(RELATIONS[seen.decision.relation]),
        table.pairs(
            [
                ("parameters of both ends on the spline", f"{first:.2f} … {last:.2f} m"),
                ("its domain", "{:.2f} … {:.2f} m".format(*seen.full_spline.domain)),
                ("turns until the end beams hit it", f"{seen.decision.start.turns}, {seen.decision.end.turns}"),
                ("noted when the scan was taken in", noted),
            ]
        ),
        table.paragraph("The spline is the one on the map now, which holds this scan too.", "dim"),
    ]


def end_row(
    name: str, end: EndComparison, is_start: bool, start: EndComparison, stop: EndComparison
) -> tuple[str, ...]:
    """One end: both bearings, by how much the data stop short of the spline's end, and what that means."""
    sense = 1.0 if stop.data_bearing >= start.data_bearing else -1.0
    inwards = (sense if is_start else -sense) * (end.data_bearing - end.spline_bearing)
    data, spline = (f"{np.degrees(bearing):.1f}°" for bearing in (end.data_bearing, end.spline_bearing))
    return name, data, spline, f"{np.degrees(inwards):+.1f}°", ENDS[end.relation]
