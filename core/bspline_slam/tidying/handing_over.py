"""Associations that follow their beams to other splines of the map."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float, Int

from bspline_slam.association import Association, Verdict
from bspline_slam.relation import Relation
from bspline_slam.sights import KeyObservations, Sights, pieces_of
from bspline_slam.spline_map import SplineMap


def handed_over(
    keys: Sequence[KeyObservations],
    splines: SplineMap,
    sights: Sights,
    owners: Int[np.ndarray, "m"],
    across: Float[np.ndarray, "m"],
) -> tuple[KeyObservations, ...]:
    """Key scans whose associations give each beam of `sights` to the spline with the id that `owners` says, cut where
    that changes.

    `splines` is the map that the sights were collected in, `across` how far each beam lies from its new spline (m).
    """
    ids = np.array([spline.id for spline in splines], dtype=np.int64)
    pieces = pieces_of(keys, splines)
    cuts = np.searchsorted(sights.piece, np.arange(len(pieces) + 1))
    parts: dict[tuple[int, int], tuple[Association, ...]] = {}
    for piece in np.unique(sights.piece[owners != ids[sights.spline]]).tolist():
        _, pose, number = pieces[piece]
        mine, association = slice(cuts[piece], cuts[piece + 1]), keys[pose].associations[number]
        beams = keys[pose].beams_of(association)
        parts[pose, number] = tuple(_parts(association, beams, owners[mine], across[mine]))
    touched = {pose for pose, _ in parts}
    return tuple(_with_parts(key, parts, pose) if pose in touched else key for pose, key in enumerate(keys))


def _parts(
    association: Association,
    beams: Int[np.ndarray, "m"],
    owners: Int[np.ndarray, "m"],
    across: Float[np.ndarray, "m"],
) -> Iterator[Association]:
    """An association cut where the owner of its beams changes; what another spline gets is matched to that."""
    starts = np.flatnonzero(np.diff(owners, prepend=-1))
    for a, b in zip(starts.tolist(), [*starts[1:].tolist(), len(beams)], strict=True):
        part = replace(association, first=int(beams[a]), last=int(beams[b - 1]))
        if owners[a] != association.spline:
            distance = float(np.sqrt(np.mean(across[a:b] ** 2)))
            part = replace(part, spline=int(owners[a]), verdict=Verdict.MATCHED, distance=distance)
            part = replace(part, relation=Relation.PART)
        yield part


def _with_parts(
    key: KeyObservations, parts: Mapping[tuple[int, int], tuple[Association, ...]], pose: int
) -> KeyObservations:
    pieces = (part for number, whole in enumerate(key.associations) for part in parts.get((pose, number), (whole,)))
    return replace(key, associations=tuple(pieces))


def renamed(keys: Sequence[KeyObservations], names: Mapping[int, int]) -> tuple[KeyObservations, ...]:
    """Key scans whose associations name splines by what these are called now."""
    return tuple(
        replace(key, associations=tuple(_renamed(association, names) for association in key.associations))
        for key in keys
    )


def _renamed(association: Association, names: Mapping[int, int]) -> Association:
    spline = association.spline
    return association if spline is None or spline not in names else replace(association, spline=names[spline])
