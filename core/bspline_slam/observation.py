"""The spline observation (A, b): what one segment says about control points seen from one pose.

Both models end in the same factor e = A·vec(q) − b with q_i = Rᵀ(c_i − x), whitened: "normal-distance" measures only
across the curve; "chord-length" is the paper's, which claims to know the control points along it too.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from bspline_slam.bspline import BSpline, basis_rows
from bspline_slam.fitting import FittingConfig, beam_covariances

MODELS = ("normal-distance", "chord-length")
"""Names of the observation models, the default first."""


@dataclass(frozen=True, slots=True)
class ChordLengthNoise:
    """Terms that the paper adds to the fit's covariance: sensor resolution (m², eq. 13) and chord error (m², eq. 14).

    `unseen` is the standard deviation (m) given to control points that the segment does not reach.
    """

    resolution: float = 1e-4
    cons: float = 1e-3
    unseen: float = 10.0


@dataclass(frozen=True, eq=False, slots=True)
class SplineObservation:
    """Whitened rows on the consecutive control points `first … first + m − 1` of one curve, robot frame.

    Σ_j (r_j/σ_j)² = ‖A q − b‖² + constant, over `readings` beams.
    """

    first: int
    A: Float[np.ndarray, "r c"]
    b: Float[np.ndarray, "r"]
    readings: int
    constant: float

    def moved(self, by: Float[np.ndarray, "2"]) -> SplineObservation:
        """The same in a frame in which every point lies farther by `by` (m)."""
        return replace(self, b=self.b + self.A @ np.tile(by, self.A.shape[1] // 2))


def compress(
    A: Float[np.ndarray, "r c"], b: Float[np.ndarray, "r"]
) -> tuple[Float[np.ndarray, "q c"], Float[np.ndarray, "q"], float]:
    """The same quadratic ‖A q − b‖² with at most as many rows as columns, plus the constant left over (one QR)."""
    if len(A) <= A.shape[1]:
        return A, b, 0.0
    q, r = np.linalg.qr(A)
    top = q.T @ b
    return r, top, float(max(b @ b - top @ top, 0.0))


def normal_distance(
    curve: BSpline,
    t: Float[np.ndarray, "m"],
    normals: Float[np.ndarray, "m 2"],
    points: Float[np.ndarray, "m 2"],
    sigma: Float[np.ndarray, "m"],
) -> SplineObservation:
    """The tangent-free observation: r_j = n_jᵀ(Σ_i β_i(t_j) q_i − p_j), normals and points in the robot frame.

    Exact compression of the whitened rows by one QR; rank-deficient where the scan saw nothing.
    """
    index, values = basis_rows(curve.knots, curve.degree, t)
    first = int(index.min())
    width = int(index.max()) - first + curve.degree + 1
    rows = np.zeros((len(t), width, 2))
    weighted = values[:, :, None] * (normals / sigma[:, None])[:, None, :]
    columns = index[:, None] - first + np.arange(curve.degree + 1)
    rows[np.arange(len(t))[:, None], columns] = weighted
    right = (normals * points).sum(1) / sigma
    A, b, constant = compress(rows.reshape(len(t), 2 * width), right)
    return SplineObservation(first, A, b, len(t), constant)


def chord_length(
    curve: BSpline,
    t: Float[np.ndarray, "m"],
    points: Float[np.ndarray, "m 2"],
    fitting: FittingConfig,
    noise: ChordLengthNoise = ChordLengthNoise(),
) -> SplineObservation:
    """The paper's observation (eqs 4–15): control points by least squares at given parameters, P = P_s + P_t1 + P_t2.

    `t` are the parameters on the full spline (section 4.2); control points that the segment does not determine get
    the standard deviation `unseen`. Points in the frame of the sensor, and so are the control points observed.
    """
    index, _ = basis_rows(curve.knots, curve.degree, t)
    first = int(index.min())
    width = int(index.max()) - first + curve.degree + 1
    B = curve.basis(t)[:, first : first + width]
    gain = np.linalg.solve(B.T @ B + 1e-6 * np.eye(width), B.T)
    beams = beam_covariances(points, fitting.range_noise, fitting.bearing_noise)
    P = np.einsum("im,mab,jm->iajb", gain, beams, gain).reshape(2 * width, 2 * width)
    share = np.linspace(0.0, 1.0, width)
    P += np.kron(np.diag(noise.resolution + np.minimum(share, 1 - share) * noise.cons), np.eye(2))
    open_ = np.eye(width) - gain @ B
    P += np.kron(open_ @ open_.T * noise.unseen**2, np.eye(2))
    estimate = (gain @ points).reshape(-1)
    A = np.linalg.cholesky(np.linalg.inv(0.5 * (P + P.T))).T
    return SplineObservation(first, A, A @ estimate, len(t), 0.0)


def across_sigma(
    normals: Float[np.ndarray, "m 2"],
    directions: Float[np.ndarray, "m 2"],
    ranges: Float[np.ndarray, "m"],
    fitting: FittingConfig,
) -> Float[np.ndarray, "m"]:
    """Standard deviation of each beam end across the curve: σ_ρ along the beam, ρσ_φ beside it (m)."""
    along, beside = incidence(normals, directions)
    return np.sqrt((fitting.range_noise * along) ** 2 + (ranges * fitting.bearing_noise * beside) ** 2)


def incidence(
    normals: Float[np.ndarray, "m 2"], directions: Float[np.ndarray, "m 2"]
) -> tuple[Float[np.ndarray, "m"], Float[np.ndarray, "m"]]:
    """n·u and u × n of each beam: how much of a curve's normal lies along the beam, and how much beside it."""
    beside = normals[:, 1] * directions[:, 0] - normals[:, 0] * directions[:, 1]
    return (normals * directions).sum(1), beside
