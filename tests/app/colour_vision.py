"""How people with another colour vision see colours, and how far two colours then lie apart."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, UInt8

FULL = np.eye(3)
PROTANOPIA = np.array(
    [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
)
DEUTERANOPIA = np.array(
    [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
)
TRITANOPIA = np.array(
    [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
)
"""On linear RGB, at full severity (Machado, Oliveira and Fernandes 2009)."""
VISIONS = {"full": FULL, "protanopia": PROTANOPIA, "deuteranopia": DEUTERANOPIA, "tritanopia": TRITANOPIA}

_XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)


def seen(colour: UInt8[np.ndarray, "3"], vision: Float[np.ndarray, "3 3"]) -> Float[np.ndarray, "3"]:
    """CIELAB coordinates (D65) of an sRGB colour as that vision sees it."""
    value = colour.astype(float) / 255.0
    linear = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    x, y, z = _XYZ @ np.clip(vision @ linear, 0.0, 1.0) / (_XYZ @ np.ones(3))
    f = [np.cbrt(v) if v > (6 / 29) ** 3 else v / (3 * (6 / 29) ** 2) + 4 / 29 for v in (x, y, z)]
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def distance(a: UInt8[np.ndarray, "3"], b: UInt8[np.ndarray, "3"], vision: Float[np.ndarray, "3 3"]) -> float:
    """ΔE (CIE 1976) of two colours in that vision; 2.3 is just noticeable."""
    return float(np.linalg.norm(seen(a, vision) - seen(b, vision)))
