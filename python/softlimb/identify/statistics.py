"""What confidence needs beside a covariance: Student's quantiles, robust losses, and a robust scale."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Loss = Literal["square", "huber", "cauchy"]

LOSSES = ("square", "huber", "cauchy")

_MANY = 100_000  # degrees of freedom from which Student's distribution is the normal one to 1e-5 of a quantile
_NORMAL_MAD = 0.6744897501960817  # median of |x| for a standard normal x


def student_probability(t: float, degrees_of_freedom: int) -> float:
    """Probability of ``|x| <= t`` for Student's distribution.

    The finite series of M. Abramowitz and I. Stegun, Handbook of Mathematical Functions, 26.7.3 and 26.7.4.
    """
    if degrees_of_freedom >= _MANY:
        return math.erf(t / math.sqrt(2.0))
    angle = math.atan(t / math.sqrt(degrees_of_freedom))
    cosine, sine = math.cos(angle), math.sin(angle)
    odd = degrees_of_freedom % 2 == 1
    count = (degrees_of_freedom - 1) // 2 if odd else degrees_of_freedom // 2
    k = np.arange(1, count)
    ratios = (2 * k) / (2 * k + 1) if odd else (2 * k - 1) / (2 * k)
    total = float(np.cumprod(np.concatenate([[1.0], ratios * cosine**2])).sum()) if count else 0.0
    if odd:
        return 2.0 / math.pi * (angle + sine * cosine * total)
    return sine * total


def student_quantile(confidence: float, degrees_of_freedom: int) -> float:
    """The t with ``P(|x| <= t) = confidence``, by bisection; infinite without a degree of freedom."""
    if degrees_of_freedom < 1:
        return math.inf
    # In the angle whose tangent t is: a finite range, in which every bisection halves the error.
    low, high = 0.0, 0.5 * math.pi
    for _ in range(60):
        middle = 0.5 * (low + high)
        if student_probability(math.tan(middle), degrees_of_freedom) < confidence:
            low = middle
        else:
            high = middle
    return math.tan(0.5 * (low + high))


@dataclass(frozen=True)
class _LossKind:
    """rho(x), psi = rho', psi', and the weight psi(x)/x, of residuals in units of their scale.

    The constants give 95 % of the efficiency of least squares where the noise is normal after all. Source: P. J. Huber,
    Robust Statistics, 1981; for Cauchy's, P. W. Holland and R. E. Welsch, Commun. Statist. A6 (1977) 813-827.
    """

    name: Loss
    constant: float

    def rho(self, x: Array) -> Array:
        """Twice the loss, so that it is x^2 for small x."""
        c = self.constant
        if self.name == "huber":
            size = np.abs(x)
            return np.where(size <= c, x * x, 2.0 * c * size - c * c)
        if self.name == "cauchy":
            return c * c * np.log1p((x / c) ** 2)
        return x * x

    def weight(self, x: Array) -> Array:
        """psi(x)/x."""
        c = self.constant
        if self.name == "huber":
            return c / np.maximum(np.abs(x), c)
        if self.name == "cauchy":
            return 1.0 / (1.0 + (x / c) ** 2)
        return np.ones_like(x)

    def slope(self, x: Array) -> Array:
        """psi'(x)."""
        c = self.constant
        if self.name == "huber":
            return (np.abs(x) <= c).astype(float)
        if self.name == "cauchy":
            y = (x / c) ** 2
            found: Array = (1.0 - y) / (1.0 + y) ** 2
            return found
        return np.ones_like(x)


def loss_kind(name: Loss) -> _LossKind:
    """The loss of that name."""
    return _LossKind(name, {"square": math.inf, "huber": 1.345, "cauchy": 2.385}[name])


def robust_scale(residuals: Array, parameters: int) -> float:
    """Standard deviation of the normal noise in residuals, from the median of their sizes.

    The ``parameters - 1`` smallest are left out: so many can be made zero by the fit.
    """
    sizes = np.sort(np.abs(residuals))[max(parameters - 1, 0) :]
    return float(np.median(sizes)) / _NORMAL_MAD if sizes.size else 0.0


def variance_factor(kind: _LossKind, x: Array, parameters: int) -> float:
    """What multiplies scale^2 (J^T J)^-1 to give the covariance: 1 for least squares with normal residuals.

    P. J. Huber, Robust Statistics, 1981, section 7.6, with his correction for few points. ``x`` are residuals in units
    of the scale.
    """
    n = x.size
    slope = kind.slope(x)
    mean = float(slope.mean())
    if mean <= 0.0 or n <= parameters:
        return math.inf
    correction = 1.0 + parameters / n * float(slope.var()) / mean**2
    psi = kind.weight(x) * x
    return correction**2 * float(psi @ psi) / (n - parameters) / mean**2
