"""From the standard errors of a fitted law to the uncertainty of the tip."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softlimb.arguments import shown
from softlimb.materials import Fit
from softlimb.posture import Posture

Array = NDArray[np.float64]


@dataclass(frozen=True)
class TipUncertainty:
    """Covariance of the tip, from that of material laws.

    Parameters
    ----------
    covariance : array, shape (6, 6)
        Of translation [m] and rotation vector [rad] of the tip, base axes, to first order.
    by_fit : dict of str to array of shape (6, 6)
        The part of each fit, by the first layer that it was named for.
    reference_length : float
        What per cent are of: the limb's length [m].
    """

    covariance: Array
    by_fit: dict[str, Array]
    reference_length: float

    @property
    def standard_deviations(self) -> Array:
        """Of the six numbers, shape (6,) [m, rad]."""
        found: Array = np.sqrt(np.diagonal(self.covariance))
        return found

    @property
    def position(self) -> float:
        """Root of the summed variances of the tip's coordinates [m]."""
        return float(np.sqrt(np.trace(self.covariance[:3, :3])))

    @property
    def position_percent(self) -> float:
        """`position` in per cent of ``reference_length``."""
        return 100.0 * self.position / self.reference_length


def tip_uncertainty(posture: Posture, fits: Mapping[str, Fit]) -> TipUncertainty:
    """How uncertain the tip is because the laws are.

    Parameters
    ----------
    posture : Posture
        Of a limb of tubes, at its pressures.
    fits : mapping of str to Fit
        From `fit_uniaxial`, by layer: ``layers[0]`` for that layer of every tube, ``segments[1].layers[0]`` for that of
        one segment. One and the same `Fit` under several names is one material, whose errors act together; different
        ones are independent.

    Returns
    -------
    TipUncertainty

    Raises
    ------
    ValueError
        No layer has that name, its law has other coefficients than the fit, an error of the fit is infinite, or two
        names stand for one layer.
    TypeError
        The posture is none, ``fits`` is no mapping, or one of them is no `Fit`.
    RuntimeError
        As for `Posture.derivative`.

    Notes
    -----
    ``J C J^T``, with J from `Posture.derivative`, at the coefficients of the posture's own laws. The points of one pull
    are not independent, and specimens differ, so that the errors of a single test are too small: so is this.
    """
    if not isinstance(posture, Posture):
        raise TypeError(f"posture must be a Posture, got {type(posture).__name__}")
    if not isinstance(fits, Mapping):
        raise TypeError(f"fits must be a mapping of layers to fits, got {type(fits).__name__}")
    for layer in fits:
        twice = [other for other in fits if str(other).endswith(f".{layer}")]
        if twice:
            raise ValueError(f"fits names one layer twice: {shown(layer)} holds {shown(twice[0])} already")
    if not fits:
        raise ValueError("fits must name at least one layer")
    columns: dict[int, Array] = {}
    first: dict[int, tuple[str, Any]] = {}
    for layer, fit in fits.items():
        if not isinstance(fit, Fit):
            raise TypeError(f"fits[{layer!r}] must be a Fit, got {type(fit).__name__}")
        if not np.isfinite(fit.covariance).all():
            raise ValueError(f"fits[{layer!r}] does not determine its coefficients: {'; '.join(fit.notes)}")
        each = "segment" if layer.startswith("segments[") else "limb"
        slopes = posture.derivative("tip", "law", each=each)  # type: ignore[arg-type]
        try:
            found = np.stack([slopes[f"{layer}.{name}"] for name in fit.coefficients], axis=1)
        except KeyError:
            known = ", ".join(slopes.columns)
            raise ValueError(
                f"fits names {shown(layer)} with {', '.join(fit.coefficients)}, but the coefficients there are {known}"
            ) from None
        columns[id(fit)] = columns.get(id(fit), 0.0) + found
        first.setdefault(id(fit), (layer, fit))
    by_fit = {layer: columns[key] @ fit.covariance @ columns[key].T for key, (layer, fit) in first.items()}
    total: Array = np.sum(list(by_fit.values()), axis=0)
    return TipUncertainty(total, by_fit, posture.limb.length)
