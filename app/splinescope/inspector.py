"""What a selected thing is: its numbers and its history, in words."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from bspline_slam.association import Association
from bspline_slam.corners import corners_of
from bspline_slam.front_end.loop_closure import LoopClosure
from bspline_slam.slam import SlamStep
from splinescope.pieces import every_piece, name_of_piece
from splinescope.view import FittedSegment, MapView, ScanView, Selection


@dataclass(frozen=True, slots=True)
class Description:
    """A title, a sentence, name–value rows, what happened, oldest first, and what was decided about it."""

    title: str
    sentence: str
    rows: tuple[tuple[str, str], ...] = ()
    history: tuple[str, ...] = ()
    decisions: tuple[str, ...] = ()


def describe(
    selection: Selection, scan: ScanView | None, world: MapView | None, steps: Mapping[int, SlamStep]
) -> Description:
    """The selected thing as it stands now; says so when it is not there any more."""
    match selection.kind:
        case "segment" if scan is not None and selection.id < len(scan.segments):
            return describe_segment(scan.segments[selection.id], scan)
        case "spline" if world is not None and selection.id in world.map:
            return describe_spline(selection.id, world, steps)
        case "control point" if (
            world is not None
            and selection.id in world.map
            and selection.sub < len(world.map[selection.id].curve.control_points)
        ):
            return describe_control_point(selection.id, selection.sub, world)
        case "key pose" if world is not None and selection.id in world.key_scans:
            return describe_key_pose(selection.id, world, steps.get(selection.id))
        case "closure" if world is not None and selection.id < len(world.loop_closures):
            return describe_closure(world.loop_closures[selection.id])
        case "pieces":
            return describe_pieces(selection, scan)
    name = f"{selection.kind.capitalize()} {selection.id}"
    return Description(name, "It is not in the map any more: it was merged, split or left out.")


def describe_segment(fit: FittedSegment, scan: ScanView) -> Description:
    """A run of beams of the current scan, its fitted curve, and what was decided about it."""
    segment = fit.segment
    decisions = [a for a in scan.associations if a.segment == segment.index]
    steps = np.linalg.norm(np.diff(segment.points, axis=0), axis=1)
    rows = [
        ("beams", f"{segment.beams[0]} … {segment.beams[-1]} ({len(segment.beams)})"),
        ("length", metres(float(steps.sum()))),
        ("begins at", segment.start.value),
        ("ends at", segment.end.value),
    ]
    if fit.curve is not None:
        rows.append(("fitted curve", f"degree {fit.curve.degree}, {len(fit.curve.control_points)} control points"))
        rows.append(("fit, RMS", millimetres(residual(fit))))
    sentence = "Neighbouring beams that saw one smooth piece of the world."
    if not scan.key:
        sentence += " This is not a key scan, so nothing of it is in the graph."
    title = f"Segment {segment.index} of scan {scan.scan.index}"
    return Description(title, sentence, tuple(rows), decisions=tuple(map(decision, decisions)))


def describe_pieces(selection: Selection, scan: ScanView | None) -> Description:
    """Several pieces of a key scan, each with the decision about it."""
    every = every_piece(scan) if scan is not None and scan.key and scan.scan.index == selection.id else ()
    chosen = [piece for piece in every if name_of_piece(piece) in selection.pieces]
    rows = ((f"segment {a.segment}, beams {a.first}–{a.last}", decision_in_short(a)) for a in chosen)
    sentence = "An edit is made of all of them at once; Shift and a click adds another."
    title = f"{len(selection.pieces)} pieces selected"
    return Description(title, f"They are of key scan {selection.id}. {sentence}", tuple(rows))


def decision_in_short(piece: Association) -> str:
    """Which spline a piece was given to."""
    return piece.verdict.value if piece.spline is None else f"spline {piece.spline}"


def residual(fit: FittedSegment) -> float:
    """RMS distance of a segment's beam ends from its fitted curve (m); NaN without a curve."""
    if fit.curve is None:
        return float("nan")
    off = fit.curve(fit.curve.foot_points(fit.segment.points)) - fit.segment.points
    return float(np.sqrt((off**2).sum(axis=1).mean()))


def decision(association: Association) -> str:
    """One decision in a sentence."""
    beams = f"Beams {association.first}–{association.last}: {association.verdict.value}"
    if association.spline is not None:
        beams += f", spline {association.spline}"
    if np.isfinite(association.distance):
        beams += f", {millimetres(association.distance)} of {millimetres(association.gate)} allowed"
    second = association.runner_up
    if second is not None:
        beams += f"; runner-up spline {second.spline} at {millimetres(second.distance)}"
    if association.by == "hand":
        beams += " (by hand)"
    return beams + "."


def describe_spline(spline_id: int, world: MapView, steps: Mapping[int, SlamStep]) -> Description:
    """A landmark of the map."""
    spline = world.map[spline_id]
    seen = sightings(spline_id, steps.values())
    rows = [
        ("length", metres(spline.length)),
        ("control points", f"{len(spline.curve.control_points)} (degree {spline.curve.degree})"),
        ("started at scan", f"{spline.born:,}"),
        ("seen by key scans", f"{spline.observations:,}"),
    ]
    if seen:
        rows.append(("last seen at scan", f"{seen[-1]:,}"))
    for corner in corners_of(world.map):
        if corner.after == spline_id:
            rows.append(("corner at its start", f"with spline {corner.before}"))
        if corner.before == spline_id:
            rows.append(("corner at its end", f"with spline {corner.after}"))
    covariance = world.covariances.get(spline_id)
    if covariance is not None:
        largest = max(
            ellipse_axes(covariance[2 * i : 2 * i + 2, 2 * i : 2 * i + 2])[0] for i in range(len(covariance) // 2)
        )
        rows.append(("least certain point, 2σ", millimetres(largest)))
    if spline.left_out > 0.0:
        rows.append(("waves left out, 2σ", millimetres(2.0 * np.sqrt(spline.left_out))))
    return Description(
        f"Spline {spline_id}", "A curve of the map that key scans are tied to.", tuple(rows), spline.history
    )


def sightings(spline_id: int, steps: Iterable[SlamStep]) -> list[int]:
    """Key scans with a piece that was given to the spline, in order."""
    return sorted(s.scan for s in steps if s.associations and any(a.spline == spline_id for a in s.associations))


def describe_control_point(spline_id: int, number: int, world: MapView) -> Description:
    """One control point of a map spline and how well it is known."""
    spline = world.map[spline_id]
    x, y = spline.curve.control_points[number]
    rows = [("position", f"{x:.3f}, {y:.3f} m"), ("spline", str(spline_id))]
    covariance = world.covariances.get(spline_id)
    if covariance is not None:
        block = block_of(covariance, number)
        major, minor = ellipse_axes(block)
        rows += [
            ("2σ ellipse, half axes", f"{1000 * major:.1f} × {1000 * minor:.1f} mm"),
            ("σ in x, in y", f"{1000 * np.sqrt(block[0, 0]):.1f}, {1000 * np.sqrt(block[1, 1]):.1f} mm"),
        ]
    else:
        rows.append(("2σ ellipse", "not computed yet"))
    used = bool(spline.curve.active(spline.span)[number])
    sentence = "It shapes the curve" + (" where scans support it." if used else " only beyond what scans support.")
    return Description(f"Control point {number} of spline {spline_id}", sentence, tuple(rows), spline.history)


def block_of(covariance: Float[np.ndarray, "d d"], number: int) -> Float[np.ndarray, "2 2"]:
    """The part of a spline's covariance that is about one control point."""
    return covariance[2 * number : 2 * number + 2, 2 * number : 2 * number + 2]


def ellipse_axes(covariance: Float[np.ndarray, "2 2"]) -> tuple[float, float]:
    """Half axes of the 2σ ellipse (m), the larger one first; a direction of negative variance counts as zero."""
    small, large = np.sqrt(np.maximum(np.linalg.eigvalsh(covariance), 0.0))
    return 2.0 * float(large), 2.0 * float(small)


def describe_key_pose(scan: int, world: MapView, step: SlamStep | None) -> Description:
    """A pose of the graph and what its scan brought."""
    x, y, heading = world.key_poses[world.key_scans.index(scan)]
    rows = [("position", f"{x:.3f}, {y:.3f} m"), ("heading", f"{np.degrees(heading):.2f}°")]
    history: list[str] = []
    if step is not None:
        correction = step.pose - step.predicted
        rows += [
            ("score of the match", f"{step.score:.2f}" + (" (lost: odometry was trusted)" if step.lost else "")),
            ("matching moved it by", millimetres(float(np.hypot(correction[0], correction[1])))),
            ("segments", str(len(step.segments))),
        ]
        history = [decision(association) for association in step.associations]
    history += [
        f"Loop closure with scan {loop.scan if loop.earlier == scan else loop.earlier}: {loop.verdict}, {loop.reason}"
        for loop in world.loop_closures
        if scan in (loop.earlier, loop.scan)
    ]
    return Description(f"Key scan {scan}", "The pose of a scan that is part of the graph.", tuple(rows), tuple(history))


def describe_closure(loop: LoopClosure) -> Description:
    """A tie between two key scans that saw the same place, or seemed to."""
    x, y, turn = loop.measured
    rows = (
        ("correlation", f"{loop.score:.2f}"),
        ("beams on the earlier map", f"{loop.inliers:.0%}"),
        ("seen from the earlier scan", f"{x:.2f}, {y:.2f} m, {np.degrees(turn):.1f}°"),
    )
    reason = f"{loop.verdict.capitalize()}: {loop.reason}."
    return Description(f"Loop closure of scans {loop.earlier:,} and {loop.scan:,}", reason, rows)


def metres(value: float) -> str:
    return f"{value:.2f} m"


def millimetres(value: float) -> str:
    return f"{1000 * value:.1f} mm" if np.isfinite(value) else "–"
