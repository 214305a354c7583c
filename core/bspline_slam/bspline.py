"""B-spline curves in the plane as values: evaluate, differentiate, project, cut with rays, insert knots, extend."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float, Int

from bspline_slam import se2
from bspline_slam.errors import GeometryError
from bspline_slam.kernels import basis as kernels


def clamped_knots(count: int, degree: int = 3) -> Float[np.ndarray, "knots"]:
    """Clamped uniform knot vector on [0, 1] for `count` control points (paper, section 2.1)."""
    inner = np.linspace(0.0, 1.0, count - degree + 1)
    return np.concatenate([np.zeros(degree), inner, np.ones(degree)])


def clamped_between(low: float, high: float, count: int, degree: int = 3) -> Float[np.ndarray, "knots"]:
    """Clamped uniform knot vector on [low, high] for `count` control points."""
    return low + (high - low) * clamped_knots(count, degree)


def uniform_knots(start: float, spacing: float, count: int, degree: int = 3) -> Float[np.ndarray, "knots"]:
    """Uniform knot vector whose domain starts at `start`, for `count` control points.

    Such a curve grows by appending control points: the ones it has keep their place and their meaning.
    """
    return start + spacing * (np.arange(count + degree + 1) - degree)


def basis_rows(
    knots: Float[np.ndarray, "knots"], degree: int, t: Float[np.ndarray, "m"], derivative: int = 0
) -> tuple[Int[np.ndarray, "m"], Float[np.ndarray, "m k"]]:
    """The k = degree + 1 basis functions that do not vanish at each t (Cox–de Boor; paper, eqs 2–3).

    Returns the index of the first of them and their values (or `derivative`-th derivatives). Parameters outside
    the domain
    continue the polynomial of the end piece.
    """
    return kernels.basis_rows(knots, degree, np.asarray(t, dtype=float), derivative)


@dataclass(frozen=True, eq=False)
class BSpline:
    """A planar B-spline curve s(t) = Σ_i c_i β_i(t) of `degree` (order k = degree + 1) (paper, eq. 1).

    `knots` (n + degree + 1, non-decreasing) and `control_points` (n, 2), metres. The domain is [knots[degree],
    knots[n]].
    """

    degree: int
    knots: Float[np.ndarray, "knots"]
    control_points: Float[np.ndarray, "n 2"]

    def __post_init__(self) -> None:
        count = len(self.control_points)
        if self.degree < 1:
            raise GeometryError(f"a spline needs a degree of at least 1, got {self.degree}")
        if count < self.degree + 1:
            raise GeometryError(
                f"degree-{self.degree} spline needs at least {self.degree + 1} control points, got {count}"
            )
        if len(self.knots) != count + self.degree + 1:
            raise GeometryError(
                f"{count} control points of degree {self.degree} need {count + self.degree + 1} knots, "
                f"got {len(self.knots)}"
            )
        if (self.knots[1:] < self.knots[:-1]).any() or not self.knots[self.degree] < self.knots[count]:
            raise GeometryError("knots must not decrease, and the domain must not be empty")

    # -- values ------------------------------------------------------------------------------------------------
    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter at which all k basis functions live."""
        return float(self.knots[self.degree]), float(self.knots[len(self.control_points)])

    def __call__(self, t: Float[np.ndarray, "m"], derivative: int = 0) -> Float[np.ndarray, "m 2"]:
        """Points of the curve at t (or its `derivative`-th derivative by t)."""
        t = np.atleast_1d(np.asarray(t, dtype=float))
        return kernels.curve_points(self.knots, self.degree, self.control_points, t, derivative)

    def basis(self, t: Float[np.ndarray, "m"], derivative: int = 0) -> Float[np.ndarray, "m n"]:
        """Collocation matrix B_ji = β_i(t_j) (paper, eq. 7)."""
        t = np.atleast_1d(t)
        first, values = basis_rows(self.knots, self.degree, t, derivative)
        out = np.zeros((len(t), len(self.control_points)))
        np.put_along_axis(out, first[:, None] + np.arange(self.degree + 1), values, axis=1)
        return out

    def normals(self, t: Float[np.ndarray, "m"]) -> Float[np.ndarray, "m 2"]:
        """Unit normals, the tangent turned left."""
        tangent = self(t, derivative=1)
        tangent = tangent / np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-12)
        return tangent[:, ::-1] * (-1.0, 1.0)

    @cached_property
    def _dense(self) -> tuple[Float[np.ndarray, "s"], Float[np.ndarray, "s 2"]]:
        breaks = np.unique(np.clip(self.knots, *self.domain))
        t = np.unique(np.concatenate([np.linspace(a, b, 9) for a, b in pairwise(breaks)]))
        return t, self(t)

    def sample(
        self, spacing: float, span: tuple[float, float] | None = None
    ) -> tuple[Float[np.ndarray, "s"], Float[np.ndarray, "s 2"]]:
        """Parameters and points at most about `spacing` metres apart, over the domain or a part of it."""
        t, points, _ = self.sample_with_normals(spacing, span)
        return t, points

    def sample_with_normals(
        self, spacing: float, span: tuple[float, float] | None = None
    ) -> tuple[Float[np.ndarray, "s"], Float[np.ndarray, "s 2"], Float[np.ndarray, "s 2"]]:
        """The same with unit normals, the tangent turned left."""
        low, high = span or self.domain
        return kernels.samples(self.knots, self.degree, self.control_points, float(low), float(high), spacing)

    def length(self, span: tuple[float, float] | None = None) -> float:
        """Arc length (m)."""
        a, b = span or self.domain
        return float(
            np.linalg.norm(np.diff(self(np.linspace(a, b, 16 * len(self.control_points))), axis=0), axis=1).sum()
        )

    # -- where things meet the curve ---------------------------------------------------------------------------
    def foot_points(self, points: Float[np.ndarray, "m 2"], iterations: int = 8) -> Float[np.ndarray, "m"]:
        """Parameter of the nearest curve point of each point, inside the domain.

        Newton from the nearest chord between dense samples; the best of its iterates counts, for at a corner of the
        curve it jumps between the two sides.
        """
        points = np.atleast_2d(points)
        t, low, high = self._on_nearest_chord(points)
        best, least = t, np.full(len(points), np.inf)
        for _ in range(iterations + 1):
            off, d1, d2 = self(t) - points, self(t, 1), self(t, 2)
            distance = (off * off).sum(1)
            best, least = np.where(distance < least, t, best), np.minimum(distance, least)
            gradient = (off * d1).sum(1)
            curvature = (d1 * d1).sum(1) + (off * d2).sum(1)
            safe = np.where(curvature > 1e-12, curvature, (d1 * d1).sum(1) + 1e-12)
            t = np.clip(t - gradient / safe, low, high)
        return best

    def _on_nearest_chord(
        self, points: Float[np.ndarray, "m 2"]
    ) -> tuple[Float[np.ndarray, "m"], Float[np.ndarray, "m"], Float[np.ndarray, "m"]]:
        """Parameter of each point's projection on the nearest chord of the dense samples, and the stretch between
        the far ends of its two neighbours."""
        dense_t, dense = self._dense
        start, along = dense[:-1], np.diff(dense, axis=0)
        squared_length = np.maximum((along * along).sum(1), 1e-18)
        projection = points @ along.T - (start * along).sum(1)
        shares = np.clip(projection / squared_length, 0.0, 1.0)
        to_start = (start * start).sum(1) - 2.0 * points @ start.T
        chord = np.argmin(to_start - 2.0 * shares * projection + shares**2 * squared_length, axis=1)
        share = shares[np.arange(len(points)), chord]
        t = dense_t[chord] + share * (dense_t[chord + 1] - dense_t[chord])
        return t, dense_t[np.maximum(chord - 1, 0)], dense_t[np.minimum(chord + 2, len(dense_t) - 1)]

    def ray_hits(
        self, origin: Float[np.ndarray, "2"], directions: Float[np.ndarray, "m 2"]
    ) -> tuple[Float[np.ndarray, "m"], Float[np.ndarray, "m"]]:
        """First hit of each ray: range (m) and parameter; NaN where a ray misses. Directions are unit vectors."""
        ray, distance, t = self.ray_crossings(origin, directions)
        order = np.lexsort((distance, ray))
        rays, first = np.unique(ray[order], return_index=True)
        ranges, parameters = np.full(len(directions), np.nan), np.full(len(directions), np.nan)
        ranges[rays], parameters[rays] = distance[order][first], t[order][first]
        return ranges, parameters

    def ray_crossings(
        self, origin: Float[np.ndarray, "2"], directions: Float[np.ndarray, "m 2"]
    ) -> tuple[Int[np.ndarray, "h"], Float[np.ndarray, "h"], Float[np.ndarray, "h"]]:
        """Every crossing of rays and curve: number of the ray, range (m) and parameter, in no order."""
        dense_t, dense = self._dense
        off = dense - origin
        across = directions[:, :1] * off[None, :, 1] - directions[:, 1:] * off[None, :, 0]
        crosses = (across[:, :-1] * across[:, 1:] <= 0) & (across[:, :-1] != across[:, 1:])
        ray, piece = np.nonzero(crosses)
        a, b = across[ray, piece], across[ray, piece + 1]
        low, high = dense_t[piece].copy(), dense_t[piece + 1].copy()
        t = low + (high - low) * a / (a - b)
        u = directions[ray]
        for _ in range(30):
            rel = self(t) - origin if len(t) else np.zeros((0, 2))
            value = u[:, 0] * rel[:, 1] - u[:, 1] * rel[:, 0]
            moving = np.abs(value) >= 1e-13
            if not moving.any():
                break
            same = np.sign(value) == np.sign(a)
            low, high = np.where(same, t, low), np.where(same, high, t)
            d = self(t, 1)
            slope = u[:, 0] * d[:, 1] - u[:, 1] * d[:, 0]
            newton = t - value / np.where(np.abs(slope) > 1e-12, slope, np.inf)
            stepped = np.where((newton > low) & (newton < high), newton, 0.5 * (low + high))
            t = np.where(moving, stepped, t)
        distance = (u * (self(t) - origin)).sum(1)
        ahead = distance > 1e-9
        return ray[ahead], distance[ahead], t[ahead]

    # -- changed curves ----------------------------------------------------------------------------------------
    def insert_knot(self, t: float) -> BSpline:
        """The same curve with one more knot at t (Boehm)."""
        a, b = self.domain
        if not a < t < b:
            raise GeometryError(f"a knot can be inserted inside ({a:g}, {b:g}), not at {t:g}")
        span = int(np.searchsorted(self.knots, t, side="right")) - 1
        k, p = self.knots, self.degree
        rows = []
        for i in range(len(self.control_points) + 1):
            if i <= span - p:
                rows.append(self.control_points[i])
            elif i > span:
                rows.append(self.control_points[i - 1])
            else:
                weight = (t - k[i]) / (k[i + p] - k[i])
                rows.append(weight * self.control_points[i] + (1 - weight) * self.control_points[i - 1])
        return BSpline(p, np.insert(k, span + 1, t), np.array(rows))

    def extended(self, before: int = 0, after: int = 0) -> BSpline:
        """A uniform curve grown by control points at its ends, continuing its end pieces in a straight line.

        The control points it has keep their values, so the curve on the old domain does not change.
        """
        spacing = float(self.knots[self.degree + 1] - self.knots[self.degree])
        c = self.control_points
        head = c[0] + np.arange(before, 0, -1)[:, None] * (c[0] - c[1])
        tail = c[-1] + np.arange(1, after + 1)[:, None] * (c[-1] - c[-2])
        start = self.domain[0] - before * spacing
        grown = np.concatenate([head, c, tail])
        return BSpline(self.degree, uniform_knots(start, spacing, len(grown), self.degree), grown)

    def with_control_points(self, control_points: Float[np.ndarray, "n 2"]) -> BSpline:
        """The same basis with other control points."""
        return BSpline(self.degree, self.knots, np.asarray(control_points, dtype=float))

    def moved(self, pose: Float[np.ndarray, "3"]) -> BSpline:
        """A curve given in the frame of `pose`, in the frame that the pose is given in."""
        return self.with_control_points(se2.transform(pose, self.control_points))

    def reversed(self) -> BSpline:
        """The same curve run through from its other end."""
        return BSpline(self.degree, (self.knots[0] + self.knots[-1] - self.knots)[::-1], self.control_points[::-1])

    def reaching(self, span: tuple[float, float]) -> BSpline:
        """The same curve on a domain that holds `span` too: its end pieces go on as the polynomials that they are."""
        low, high = self.domain
        before, after = max(low - span[0], 0.0), max(span[1] - high, 0.0)
        if before == after == 0.0:
            return self
        knots, count = self.knots.copy(), len(self.control_points)
        knots[: self.degree + 1] -= before
        knots[count:] += after
        wider = BSpline(self.degree, knots, self.control_points)
        places = wider.greville()
        return wider.with_control_points(np.linalg.solve(wider.basis(places), self(places)))

    def greville(self) -> Float[np.ndarray, "n"]:
        """Greville abscissae: where each control point has most of its say."""
        index = np.arange(len(self.control_points))[:, None] + np.arange(1, self.degree + 1)
        return self.knots[index].mean(1)

    def restricted(self, span: tuple[float, float]) -> BSpline:
        """The same curve on `span`, without the control points that have no say there."""
        kept = np.flatnonzero(self.active(span))
        first, last = int(kept[0]), int(kept[-1]) + 1
        return BSpline(self.degree, self.knots[first : last + self.degree + 1], self.control_points[first:last])

    def clamped(self, span: tuple[float, float]) -> BSpline:
        """The same curve with `span`, inside the domain, as all of its domain; it runs through its end points there."""
        curve, (low, high) = self, self.domain
        for end in span:
            inside = low < end < high
            for _ in range(self.degree - int(np.count_nonzero(self.knots == end)) if inside else 0):
                curve = curve.insert_knot(end)
        return curve.restricted(span)

    def active(self, span: tuple[float, float]) -> Bool[np.ndarray, "n"]:
        """Control points that shape the curve somewhere inside `span`."""
        reach = np.arange(len(self.control_points))
        return (self.knots[reach + self.degree + 1] > span[0]) & (self.knots[reach] < span[1])
