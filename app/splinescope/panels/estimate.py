"""Model and estimator: what the next run is made with; run it over the log or only solve the map again."""

from __future__ import annotations

import numpy as np
import viser

from splinescope import table
from splinescope.activity import Work, duration
from splinescope.commands import Choose
from splinescope.computing.solution import Solution
from splinescope.estimation_text import by_hand_in_words
from splinescope.panels.action_button import ActionButton
from splinescope.panels.panel import Post, on_change
from splinescope.panels.status import doing
from splinescope.recipe import ORDERS, Recipe
from splinescope.session import Session

ABOUT_BACK_ENDS = {
    "direct": "Gauss–Newton on all poses and control points at once, with a sparse Cholesky factor.",
    "sam": "The same problem, solved by gtsam: the reference.",
    "isam2": "The same problem again, fed to gtsam key scan by key scan: incremental smoothing.",
    "islsjf": "Local maps, one per key scan, joined one after another and linearised again: the same optimum.",
    "ekf": "A Kalman filter of the current pose and the map: no look back, no loop closures, costs may rise.",
    "bs_slam": "A Kalman filter too, but on the range of each beam to its curve (BS-SLAM).",
    "idmj": "Joining on relative feature information: odometry and loop closures have no say in the map.",
    "pose_graph": "Poses alone; the curves follow them and do not pull, so their cost may rise.",
}
ABOUT_MODELS = {
    "normal-distance": "Only the distance across a curve counts.",
    "chord-length": "The published observation: whole control points, at chord-length parameters.",
}
ROUNDS = "Each round finds anew which beams belong to which point of a curve; there the cost may jump."
SOLVES_EDITED = "Solving this map again solves it with its {}, by the estimator chosen here."
GREY = "#888888"


class EstimatePanel:
    """The choices, the two ways to run, Cancel, the cost curve and the figures of the result shown."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        self._post = post
        self._costs: tuple[float, ...] = ()
        self._model = gui.add_dropdown("Model", tuple(ABOUT_MODELS), hint="What counts as an observation of a curve")
        self._back_end = gui.add_dropdown(
            "Estimator", tuple(ABOUT_BACK_ENDS), hint="Who solves the least-squares problem"
        )
        self._about = gui.add_html("")
        self._order = gui.add_dropdown("Order", tuple(map(str, ORDERS)), hint="Degree of the curves plus one")
        self._spacing = gui.add_number("Knots (m)", Recipe().spacing, min=0.1, max=2.0, step=0.05)
        self._points = gui.add_number(
            "Control points", Recipe().control_points, min=2, max=60, step=1, hint="Of every spline; the knots follow"
        )
        for widget in (self._model, self._back_end, self._order, self._spacing, self._points):
            on_change(widget, self._choose)
        self._run = ActionButton(gui, post, "run", icon=viser.Icon.PLAYER_PLAY)
        self._solve = ActionButton(gui, post, "optimise", icon=viser.Icon.REFRESH)
        self._cancel = ActionButton(gui, post, "cancel", words="Cancel", icon=viser.Icon.PLAYER_STOP, color="gray")
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

    def refresh(self, session: Session) -> None:
        recipe = session.recipe
        self._model.value, self._back_end.value = recipe.model, recipe.back_end
        self._order.value, self._spacing.value = str(recipe.order), recipe.spacing
        self._points.value = recipe.control_points
        self._spacing.visible, self._points.visible = recipe.spaced, not recipe.spaced
        about = f"{ABOUT_MODELS[recipe.model]} {ABOUT_BACK_ENDS[recipe.back_end]}"
        self._about.content = table.block(table.paragraph(about, "dim"))
        for button in (self._run, self._solve, self._cancel):
            button.refresh(session)
        self._run.handle.visible = self._solve.handle.visible = not session.busy
        self._cancel.handle.visible = session.busy
        self._text.content = table.block(*report(session))
        if session.costs != self._costs:
            self._costs = session.costs
            self._draw(session.costs)

    def _choose(self) -> None:
        order, spacing, points = int(self._order.value), float(self._spacing.value), int(self._points.value)
        self._post(Choose(Recipe(self._model.value, self._back_end.value, order, spacing, points)))

    def _draw(self, costs: tuple[float, ...]) -> None:
        self._curve.visible = self._note.visible = len(costs) > 1
        if len(costs) > 1:
            self._curve.data = (np.arange(float(len(costs))), np.array(costs))


def report(session: Session) -> list[str]:
    """What the estimator does, did, or waits for, as HTML parts."""
    if session.busy:
        solving = session.activity is not None and session.activity.work is Work.OPTIMISING and session.costs
        return [table.paragraph(doing(session) + (f" · cost {session.costs[-1]:,.1f}" if solving else ""))]
    refusals = dict.fromkeys(refusal for refusal in (session.run_refusal, session.refusal) if refusal is not None)
    parts = [table.paragraph(refusal, "dim") for refusal in refusals]
    if session.result is not None and (by_hand := session.results.run_behind(session.result).edits):
        parts.append(table.paragraph(SOLVES_EDITED.format(by_hand_in_words(len(by_hand))), "dim"))
    if session.solution is not None and session.result is not None:
        parts += [table.heading(f"Result {session.result.label}"), table.pairs(figures(session.solution))]
    return parts


def figures(solution: Solution) -> list[tuple[str, str]]:
    """Names and values of a finished solve."""
    count = f"{solution.iterations}" + ("" if solution.converged else " (not converged)")
    return [
        ("cost before → after", f"{solution.cost_before:,.1f} → {solution.cost_after:,.1f}"),
        ("largest move of a pose", f"{1000 * solution.largest_move:.1f} mm"),
        ("χ² / degrees of freedom", f"{solution.chi2:,.0f} / {solution.dof:,} = {solution.chi2_per_dof:.2f}"),
        ("iterations", count),
        ("time", duration(solution.seconds) if solution.seconds >= 10 else f"{solution.seconds:.1f} s"),
    ]
