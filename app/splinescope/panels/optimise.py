"""Optimise: solve the whole map with a chosen back end, watch the cost fall, read what it did."""

from __future__ import annotations

import numpy as np
import viser

from bspline_slam.adjustment import AdjustmentConfig
from splinescope import table
from splinescope.activity import Work, duration
from splinescope.commands import Cancel, ChooseBackEnd, Optimise
from splinescope.panels.panel import Post, on_change, on_press
from splinescope.panels.status import doing
from splinescope.session import Session
from splinescope.solution import Solution

BACK_ENDS = {
    "direct": "Gauss–Newton on all poses and control points at once, with a sparse Cholesky factor.",
    "sam": "The same problem, solved by gtsam: the reference.",
    "isam2": "The same problem again, fed to gtsam key scan by key scan: incremental smoothing.",
    "islsjf": "Local maps, one per key scan, joined one after another and linearised again: the same optimum.",
    "ekf": "A Kalman filter of the current pose and the map: no look back, no loop closures, costs may rise.",
    "bs_slam": "A Kalman filter too, but on the range of each beam to its curve (BS-SLAM).",
    "idmj": "Joining on relative feature information: odometry and loop closures have no say in the map.",
    "pose_graph": "Poses alone; the curves follow them and do not pull, so their cost may rise.",
}
MODEL = AdjustmentConfig().model
ROUNDS = "Each round finds anew which beams belong to which point of a curve; there the cost may jump."
GREY = "#888888"


class OptimisePanel:
    """Back end, Run, Cancel, the cost curve and the result."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        self._costs: tuple[float, ...] = ()
        self._back_end = gui.add_dropdown("Back end", tuple(BACK_ENDS), hint="Who solves the least-squares problem")
        self._about = gui.add_html("")
        self._run = gui.add_button("Optimise the whole map", icon=viser.Icon.PLAYER_PLAY)
        self._cancel = gui.add_button("Cancel", icon=viser.Icon.PLAYER_STOP, color="gray", visible=False)
        self._text = gui.add_html("")
        self._curve = gui.add_uplot(
            data=(np.arange(2.0), np.ones(2)),
            series=({"label": "iteration"}, {"label": "cost", "stroke": "#0072B2", "width": 2}),
            scales={"x": {"time": False}},
            axes=(
                {"label": "iteration", "stroke": GREY, "grid": {"stroke": GREY, "width": 0.3}},
                {"label": "cost", "stroke": GREY, "size": 64, "grid": {"stroke": GREY, "width": 0.3}},
            ),
            legend={"show": False},
            height=180,
            visible=False,
        )
        self._note = gui.add_html(table.block(table.paragraph(ROUNDS, "dim")), visible=False)
        on_press(self._run, lambda: post(Optimise()))
        on_change(self._back_end, lambda: post(ChooseBackEnd(self._back_end.value)))
        on_press(self._cancel, lambda: post(Cancel()))

    def refresh(self, session: Session) -> None:
        chosen = self._back_end.value = session.preferences.back_end
        about = f"{BACK_ENDS[chosen]} Observation model: {MODEL}."
        self._about.content = table.block(table.paragraph(about, "dim"))
        working = session.activity is not None and session.activity.work is Work.OPTIMISING
        self._run.disabled = session.refusal is not None
        self._run.visible, self._cancel.visible = not working, working
        self._text.content = table.block(*report(session))
        if session.costs != self._costs:
            self._costs = session.costs
            self._draw(session.costs)

    def _draw(self, costs: tuple[float, ...]) -> None:
        self._curve.visible = self._note.visible = len(costs) > 1
        if len(costs) > 1:
            self._curve.data = (np.arange(float(len(costs))), np.array(costs))


def report(session: Session) -> list[str]:
    """What the solver does, did, or waits for, as HTML parts."""
    refusal = session.refusal
    if session.activity is not None and session.activity.work is Work.OPTIMISING:
        cost = f" · cost {session.costs[-1]:,.1f}" if session.costs else ""
        return [table.paragraph(doing(session) + cost)]
    if session.solution is not None:
        return [table.heading("Result"), table.pairs(figures(session.solution))]
    return [table.paragraph(refusal or "Nothing has been optimised yet.", "dim")]


def figures(solution: Solution) -> list[tuple[str, str]]:
    """Names and values of a finished solve."""
    count = f"{solution.iterations}" + ("" if solution.converged else " (not converged)")
    return [
        ("back end", solution.back_end),
        ("cost before → after", f"{solution.cost_before:,.1f} → {solution.cost_after:,.1f}"),
        ("largest move of a pose", f"{1000 * solution.largest_move:.1f} mm"),
        ("χ² / degrees of freedom", f"{solution.chi2:,.0f} / {solution.dof:,} = {solution.chi2_per_dof:.2f}"),
        ("iterations", count),
        ("time", duration(solution.seconds) if solution.seconds >= 10 else f"{solution.seconds:.1f} s"),
    ]
