"""From a uniaxial test to a material law: unweighted least squares of the nominal stress over a stated strain range.

A law is linear in some coefficients and, for Ogden and Gent, nonlinear in others (exponents, limit). The linear ones
follow from a QR factorisation; the others are found by variable projection (G. H. Golub and V. Pereyra, SIAM J. Numer.
Anal. 10 (1973) 413-432, in L. Kaufman's form), that is, a Levenberg-Marquardt search in which the linear ones are
solved for at every step, from several starts. Source: MECHANICS, "Material".
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from itertools import combinations
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb import arguments
from softlimb._core import DruckerCheck, Gent, MooneyRivlin, NeoHookean, Ogden, Yeoh
from softlimb.materials.law import Law
from softlimb.materials.tensile_csv import read_tensile_csv

Vector = NDArray[np.float64]

# A point at the edge of the range counts although 1 + 0.5 - 1 may differ from 0.5 by rounding.
_EDGE = 1e-9
# Below this a column of the scaled basis is a combination of the others for double precision.
_RANK_TOLERANCE = 1e-12
# Largest stress of the fit range [Pa]: within it squares and products of stresses stay inside double precision. A
# stress outside is a mistake in any unit.
_SMALLEST_STRESS, _LARGEST_STRESS = 1e-60, 1e60
_MOST_ITERATIONS = 200
# Searches from the best of the starts, by number of shape parameters: one parameter has one valley, or two (exponents
# of either sign); with three exponents every second search ends elsewhere.
_SEARCHES = {1: 3, 2: 6, 3: 8}


@dataclass(frozen=True)
class _Family:
    """How one name of `FIT_LAWS` is fitted.

    `basis(stretch, shape)` gives the stress that each linear coefficient contributes, (n, m); `shape` holds the
    nonlinear parameters, inside `bounds`; `starts(stretch)` are those to begin from.
    """

    linear: tuple[str, ...]
    shape: tuple[str, ...]
    basis: Callable[[Vector, Vector], Vector]
    make: Callable[[Vector, Vector, float, float], Law]
    bounds: Callable[[Vector], tuple[float, float]] = lambda stretch: (-np.inf, np.inf)
    starts: Callable[[Vector], Sequence[Sequence[float]]] = lambda stretch: [()]

    @property
    def names(self) -> tuple[str, ...]:
        return self.linear + self.shape


@dataclass(frozen=True, eq=False)
class Fit:
    """A law fitted to a uniaxial test.

    Attributes
    ----------
    law_name : str
        As given to `fit_uniaxial`, one of `FIT_LAWS`.
    coefficients : dict of str to float
        Fitted values by name, stresses in Pa; the terms of Ogden's law as ``mu[0]``, ``alpha[0]``...
    standard_errors : dict of str to float
        One standard deviation of each, from the scatter of the points about the law (independent errors of equal
        size); infinite where the points do not determine it, and when there are no more points than coefficients,
        which leave no scatter to see.
        The points of one pull are not independent, so these are too small for a single specimen.
    covariance : ndarray, shape (k, k)
        Of the coefficients, in the order of `coefficients`.
    r_squared, rmse : float
        Of the nominal stress over the points used; rmse in Pa. Where the points have one and the same stress,
        r_squared is 1 for a law that meets it and -inf for another.
    points : int
        Number of points used.
    max_strain : float
        Largest nominal strain of the fit range; the law carries it too.
    drucker : DruckerCheck or None
        Stability over the fit range in tension, planar and equibiaxial tension; None without a law.
    success : bool
        The search converged and the coefficients make a legal law.
    message : str
        The outcome in words.
    notes : tuple of str
        Things worth knowing that are no failure: rows dropped on reading, extrapolation, merged exponents.
    stretch, nominal_stress : ndarray, shape (n,)
        All points given, also those outside the range.
    in_range : ndarray of bool, shape (n,)
        Which of them were used.
    data_name : str
        Where the points come from, for titles.
    """

    law_name: str
    coefficients: dict[str, float]
    standard_errors: dict[str, float]
    covariance: Vector
    r_squared: float
    rmse: float
    points: int
    max_strain: float
    drucker: DruckerCheck | None
    success: bool
    message: str
    notes: tuple[str, ...]
    stretch: Vector
    nominal_stress: Vector
    in_range: NDArray[np.bool_]
    data_name: str
    _law: Law | None

    @property
    def law(self) -> Law:
        """The fitted law, with the fit range in its `max_strain`.

        Raises
        ------
        RuntimeError
            The coefficients make no legal law (`message` says why).
        """
        if self._law is None:
            raise RuntimeError(f"this fit gave no law: {self.message}")
        return self._law

    @property
    def stable(self) -> bool:
        """Whether the law is stable in Drucker's sense over the fit range."""
        return self.drucker is not None and self.drucker.stable

    @property
    def residuals(self) -> Vector:
        """Law minus measurement at every point given, in and outside the range, shape (n,) [Pa]."""
        return self.law.uniaxial_stress(self.stretch) - self.nominal_stress

    def __repr__(self) -> str:
        values = ", ".join(f"{name}={value:.6g}" for name, value in self.coefficients.items())
        return (
            f"Fit({self.law_name!r}, {values}, max_strain={self.max_strain:.4g}, points={self.points}, "
            f"r_squared={self.r_squared:.6f}, success={self.success})"
        )


def fit_csv(path: str | PathLike[str], law: str = "yeoh", *, max_strain: float | None = None) -> Fit:
    """Fit a law to a tensile test in a file: `read_tensile_csv`, then `fit_uniaxial`.

    Parameters and errors are those of the two; what was done on reading stands in the fit's notes.
    """
    test = read_tensile_csv(path)
    try:
        fit = fit_uniaxial(test.stretch, test.nominal_stress, law, max_strain=max_strain)
    except ValueError as error:
        raise ValueError(f"{Path(path).name}: {error}") from None
    return replace(fit, notes=test.notes + fit.notes, data_name=test.name)


def fit_uniaxial(
    stretch: ArrayLike,
    nominal_stress: ArrayLike,
    law: str = "yeoh",
    *,
    max_strain: float | None = None,
    density: float = 1080.0,
) -> Fit:
    """Fit an incompressible law to a uniaxial test.

    Unweighted least squares of the nominal stress over all points with a nominal strain up to `max_strain`; no point is
    added at the origin.

    Parameters
    ----------
    stretch : array_like, shape (n,)
        1 + nominal strain, positive. Points in compression (below 1) are used as well.
    nominal_stress : array_like, shape (n,)
        Force over undeformed cross-section [Pa].
    law : str
        One of `FIT_LAWS`: "neo-hooke", "yeoh" (two terms), "yeoh3", "mooney-rivlin", "ogden1" to "ogden3", "gent".
    max_strain : float, optional
        End of the fit range, as nominal strain (0.5 is 50 %). Default: all points.
    density : float
        Handed on to the law [kg/m^3].

    Returns
    -------
    Fit
        With `success` false and the reason in `message` where the search did not converge or no legal law came out.

    Raises
    ------
    ValueError
        An argument is not made of finite real numbers, the largest stress is outside 1e-60 to 1e60 Pa, shapes differ,
        the law is not known, or the range holds fewer points than the law has
        coefficients, or points that cannot determine them (all at one stretch).
    """
    family = _family(law)
    points, stress = _checked_points(stretch, nominal_stress)
    density = arguments.one_real("density", density)
    limit = _checked_limit(points, max_strain)
    in_range = points - 1.0 <= limit + _EDGE
    x, y = points[in_range], stress[in_range]
    if x.size < len(family.names):
        raise ValueError(
            f"{x.size} points with nominal strain up to {limit:.6g}, but {law} has {len(family.names)} coefficients "
            f"({', '.join(family.names)})"
        )
    scale = float(np.abs(y).max())
    if scale == 0.0:
        raise ValueError("nominal_stress is zero at every point of the fit range")
    if scale < _SMALLEST_STRESS:
        raise ValueError(
            f"nominal_stress is at most {scale:.6g} Pa in the fit range: expected {_SMALLEST_STRESS:g} or more"
        )

    # A law that overflows at some point of the search costs infinitely much there, and a result that is not finite is
    # reported below: both are dealt with here, not warned of.
    with np.errstate(all="ignore"):
        search = _search(family, x, y / scale)
        jacobian = np.hstack([search.basis, _shape_slopes(family, x, search.shape, search.linear)])
        values = np.concatenate([search.linear * scale, search.shape])
        residual = family.basis(x, search.shape) @ values[: len(family.linear)] - y
        covariance = _covariance(
            jacobian, residual / scale, np.array([scale] * len(family.linear) + [1.0] * search.shape.size)
        )
        r_squared, rmse = _quality(y, residual)
    # The law knows its range: what was asked for, but never more than the points reach.
    furthest = float(points.max() - 1.0)
    reach = max(limit if furthest >= limit - _EDGE else furthest, 0.0)
    fitted, problem = _make_law(family, values, density, reach)
    if not (np.isfinite(values).all() and np.isfinite(residual).all()):
        fitted, problem = None, "the law overflows: are stretch and stress in their units?"
    drucker = fitted.check_drucker(reach) if fitted is not None and reach > 0.0 else None
    errors = dict(zip(family.names, np.sqrt(np.diag(covariance)).tolist(), strict=True))
    message = "; ".join(filter(None, [search.problem, problem])) or "converged"
    return Fit(
        law_name=law,
        coefficients=dict(zip(family.names, values.tolist(), strict=True)),
        standard_errors=errors,
        covariance=covariance,
        r_squared=r_squared,
        rmse=rmse,
        points=int(x.size),
        max_strain=reach,
        drucker=drucker,
        success=not search.problem and fitted is not None,
        message=message,
        notes=_notes(points, stress, limit, max_strain) + _undetermined(family.names, values, errors, x.size),
        stretch=points,
        nominal_stress=stress,
        in_range=in_range,
        data_name="",
        _law=fitted,
    )


# --- arguments --------------------------------------------------------------------------------


def _family(law: str) -> _Family:
    if not isinstance(law, str) or law not in _FAMILIES:
        near = get_close_matches(str(law), _FAMILIES, n=1)
        hint = f": did you mean {near[0]!r}?" if near else ""
        raise ValueError(f"law must be one of {', '.join(_FAMILIES)}, got {arguments.shown(law)}{hint}")
    return _FAMILIES[law]


def _checked_points(stretch: ArrayLike, nominal_stress: ArrayLike) -> tuple[Vector, Vector]:
    points, stress = arguments.real_array("stretch", stretch), arguments.real_array("nominal_stress", nominal_stress)
    if points.ndim != 1 or points.shape != stress.shape:
        raise ValueError(
            f"stretch and nominal_stress must be one-dimensional and of equal length, got shapes {points.shape} and "
            f"{stress.shape}"
        )
    if points.size == 0:
        raise ValueError("stretch is empty: expected one value per point")
    for name, array in (("stretch", points), ("nominal_stress", stress)):
        bad = np.flatnonzero(~np.isfinite(array))
        if bad.size:
            raise ValueError(f"{name}[{bad[0]}] must be finite, got {array[bad[0]]}")
    bad = np.flatnonzero(points <= 0.0)
    if bad.size:
        raise ValueError(
            f"stretch[{bad[0]}] must be positive, got {points[bad[0]]:.6g} "
            "(was it given as strain? stretch is 1 + strain)"
        )
    bad = np.flatnonzero(np.abs(stress) > _LARGEST_STRESS)
    if bad.size:
        raise ValueError(f"nominal_stress[{bad[0]}] must be within {_LARGEST_STRESS:g} Pa, got {stress[bad[0]]:.6g}")
    return points, stress


def _checked_limit(points: Vector, max_strain: float | None) -> float:
    if max_strain is None:
        return float(points.max() - 1.0)
    limit = arguments.one_real("max_strain", max_strain)
    if not (np.isfinite(limit) and limit > 0.0):
        raise ValueError(f"max_strain must be finite and positive, got {limit}")
    return limit


def _notes(points: Vector, stress: Vector, limit: float, max_strain: float | None) -> tuple[str, ...]:
    notes = []
    if max_strain is not None and points.max() - 1.0 < limit - _EDGE:
        notes.append(
            f"the points end at a nominal strain of {points.max() - 1.0:.4g}, before the max_strain of {limit:.4g} "
            "asked for"
        )
    if np.any((points < 1.0) & (stress > 0.0)):
        notes.append("stretches below 1 with a positive stress: was strain given as stretch? stretch is 1 + strain")
    return tuple(notes)


def _quality(y: Vector, residual: Vector) -> tuple[float, float]:
    """R^2 and rmse."""
    rmse = float(np.sqrt(np.mean(residual**2)))
    if float(np.ptp(y)) > 0.0:
        return 1.0 - float(residual @ residual) / float(np.sum((y - y.mean()) ** 2)), rmse
    return 1.0 if rmse <= 1e-12 * float(np.abs(y).max()) else -np.inf, rmse


def _undetermined(
    names: Sequence[str], values: Vector, errors: dict[str, float], points: int
) -> tuple[str, ...]:
    if points == len(names):
        return ("no more points than coefficients: the standard errors are unknown, shown as infinite",)
    loose = [name for name, value in zip(names, values, strict=True) if errors[name] > abs(value)]
    if not loose:
        return ()
    return (f"the points do not determine {', '.join(loose)}: standard error above the value; try fewer coefficients",)


def _make_law(family: _Family, values: Vector, density: float, max_strain: float) -> tuple[Law | None, str]:
    count = len(family.linear)
    try:
        return family.make(values[:count], values[count:], density, max_strain), ""
    except ValueError as error:
        if not (np.isfinite(density) and density > 0.0):
            raise
        return None, f"the points ask for coefficients that make no legal law: {error}"


# --- least squares --------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Projection:
    """Linear coefficients at given shape: basis (n, m), orthonormal factor, coefficients, residual."""

    shape: Vector
    basis: Vector
    orthonormal: Vector
    linear: Vector
    residual: Vector
    full_rank: bool

    @property
    def cost(self) -> float:
        return float(self.residual @ self.residual) if self.full_rank else np.inf


@dataclass(frozen=True)
class _Search:
    shape: Vector
    basis: Vector
    linear: Vector
    cost: float
    problem: str


def _project(family: _Family, x: Vector, y: Vector, shape: Vector) -> _Projection:
    basis = family.basis(x, shape)
    size = np.linalg.norm(basis, axis=0)
    usable = bool(np.all(np.isfinite(size)) and np.all(size > 0.0))
    if not usable:
        return _Projection(shape, basis, basis, np.full(basis.shape[1], np.nan), np.full(x.size, np.inf), False)
    orthonormal, triangle = np.linalg.qr(basis / size)
    full_rank = bool(np.abs(np.diag(triangle)).min() > _RANK_TOLERANCE)
    if not full_rank:
        return _Projection(shape, basis, orthonormal, np.full(basis.shape[1], np.nan), np.full(x.size, np.inf), False)
    share = orthonormal.T @ y
    return _Projection(
        shape, basis, orthonormal, np.linalg.solve(triangle, share) / size, orthonormal @ share - y, True
    )


def _shape_slopes(family: _Family, x: Vector, shape: Vector, linear: Vector) -> Vector:
    """Derivatives of the stress in the shape parameters, (n, s).

    Central differences of fourth order: with a step of 1e-3 the truncation (h^4/30) and rounding (eps/h) are both near
    1e-13, so the fit's stationary point and its standard errors are those of exact derivatives to twelve digits.
    """
    slopes = np.empty((x.size, shape.size))
    for k in range(shape.size):
        step = 1e-3 * max(1.0, abs(float(shape[k])))
        if abs(shape[k]) < 3.0 * step:  # no crossing of the exponent zero
            step = 0.2 * abs(float(shape[k]))

        def stress(steps: float, k: int = k, step: float = step) -> Vector:
            moved = shape.copy()
            moved[k] += steps * step
            return family.basis(x, moved) @ linear

        slopes[:, k] = (8.0 * (stress(1.0) - stress(-1.0)) - (stress(2.0) - stress(-2.0))) / (12.0 * step)
    return slopes


def _search(family: _Family, x: Vector, y: Vector) -> _Search:
    if not family.shape:
        only = _project(family, x, y, np.empty(0))
        if not only.full_rank:
            raise ValueError(
                f"the points cannot determine {', '.join(family.linear)}: they lie at too few different stretches"
            )
        return _Search(only.shape, only.basis, only.linear, only.cost, "")
    starts = sorted((_project(family, x, y, np.array(s, dtype=float)) for s in family.starts(x)), key=lambda p: p.cost)
    starts = [start for start in starts[: _SEARCHES[len(family.shape)]] if start.full_rank]
    if not starts:
        raise ValueError(
            f"the points cannot determine {', '.join(family.names)}: they lie at too few different stretches"
        )
    found = [_descend(family, x, y, start) for start in starts]
    # A legal law that fits a little worse is of more use than a closer curve that no material can follow.
    return min(
        found, key=lambda end: (_make_law(family, np.append(end.linear, end.shape), 1.0, 0.0)[0] is None, end.cost)
    )


def _descend(family: _Family, x: Vector, y: Vector, start: _Projection) -> _Search:
    """Levenberg-Marquardt on the shape parameters, damped in the scale of each column."""
    low, high = family.bounds(x)
    current, damping = start, 1e-3
    problem = f"the search did not converge in {_MOST_ITERATIONS} steps"
    floor = x.size * (4.0 * np.finfo(float).eps) ** 2  # y is scaled to one: a residual of rounding alone
    for _ in range(_MOST_ITERATIONS):
        slopes = _shape_slopes(family, x, current.shape, current.linear)
        # Kaufman: what the linear coefficients can follow drops out of the slopes.
        slopes = slopes - current.orthonormal @ (current.orthonormal.T @ slopes)
        gradient = slopes.T @ current.residual
        size = np.linalg.norm(slopes, axis=0)
        if not (np.isfinite(gradient).all() and np.isfinite(slopes.T @ slopes).all()):
            problem = "the law overflows in the search: are stretch and stress in their units?"
            break
        if current.cost <= floor or np.all(np.abs(gradient) <= 1e-10 * size * np.sqrt(current.cost)):
            problem = ""
            break
        normal = slopes.T @ slopes
        accepted = False
        while damping < 1e12:
            trial_shape = (
                current.shape
                - np.linalg.lstsq(normal + damping * np.diag(np.maximum(size**2, 1e-30)), gradient, rcond=None)[0]
            )
            trial = _project(family, x, y, np.clip(trial_shape, low, high))
            if trial.cost < current.cost:
                accepted = True
                break
            damping *= 8.0
        if not accepted:
            # No step lowers the cost: the point is as good as rounding allows, or the model is degenerate there.
            still = np.abs(gradient) <= 1e-5 * size * np.sqrt(current.cost)
            problem = "" if np.all(still) else "the search stopped without reaching a minimum"
            break
        step = np.abs(trial.shape - current.shape)
        current, damping = trial, max(damping / 10.0, 1e-14)
        if np.all(step <= 1e-13 * (1.0 + np.abs(current.shape))):
            problem = ""
            break
    at_bound = (current.shape <= low) | (current.shape >= high)
    if np.any(at_bound):
        named = ", ".join(name for name, bound in zip(family.shape, at_bound, strict=True) if bound)
        problem = f"{named} ran to the end of its range: the points do not determine it"
    ordered = _project(family, x, y, np.sort(current.shape))  # the order of like terms is the search's accident
    return _Search(ordered.shape, ordered.basis, ordered.linear, ordered.cost, problem)


def _covariance(jacobian: Vector, residual: Vector, scale: Vector) -> Vector:
    """s^2 (J^T J)^-1 with s^2 the residual variance; `scale` brings the coefficients back to Pa."""
    n, k = jacobian.shape
    if n == k:
        return np.full((k, k), np.inf)
    size = np.linalg.norm(jacobian, axis=0)
    triangle = np.linalg.qr(jacobian / size, mode="r")
    if not np.abs(np.diag(triangle)).min() > _RANK_TOLERANCE:  # NaN included: a column of zeros, or an overflow
        return np.full((k, k), np.inf)
    inverse = np.linalg.inv(triangle) / size[:, None] * scale[:, None]
    covariance: Vector = inverse @ inverse.T * float(residual @ residual) / (n - k)
    return covariance if np.isfinite(covariance).all() else np.full((k, k), np.inf)


# --- the laws --------------------------------------------------------------------------------
# The stress of a law is linear in some coefficients, so what one of them contributes is the stress of the law in which
# it is one, less that of the law in which it is zero: the formulas stay in the C++ core alone.


def _neo_hooke_basis(stretch: Vector, shape: Vector) -> Vector:
    return NeoHookean(c1=1.0).uniaxial_stress(stretch)[:, None]


def _yeoh_basis(terms: int) -> Callable[[Vector, Vector], Vector]:
    def basis(stretch: Vector, shape: Vector) -> Vector:
        first = Yeoh(c1=1.0, c2=0.0).uniaxial_stress(stretch)
        second = Yeoh(c1=1.0, c2=1.0).uniaxial_stress(stretch) - first
        third = Yeoh(c1=1.0, c2=0.0, c3=1.0).uniaxial_stress(stretch) - first
        return np.stack([first, second, third][:terms], axis=1)

    return basis


def _mooney_rivlin_basis(stretch: Vector, shape: Vector) -> Vector:
    return np.stack(
        [
            MooneyRivlin(c10=1.0, c01=0.0).uniaxial_stress(stretch),
            MooneyRivlin(c10=0.0, c01=1.0).uniaxial_stress(stretch),
        ],
        axis=1,
    )


def _ogden_basis(stretch: Vector, shape: Vector) -> Vector:
    # mu and alpha of like sign make a legal one-term law; the sign comes off again.
    columns = [
        np.sign(alpha) * Ogden(mu=[float(np.sign(alpha))], alpha=[float(alpha)]).uniaxial_stress(stretch)
        for alpha in np.where(shape == 0.0, 1e-6, shape)
    ]
    return np.stack(columns, axis=1)


def _ogden_starts(terms: int) -> Callable[[Vector], Sequence[Sequence[float]]]:
    exponents = {1: (-8, -4, -2, -1, 1, 2, 4, 8), 2: (-6, -3, -1, 1, 2, 4, 8, 12), 3: (-6, -2, 1, 2, 5, 10)}[terms]
    return lambda stretch: list(combinations(map(float, exponents), terms))


def _ogden(terms: int) -> _Family:
    return _Family(
        tuple(f"mu[{p}]" for p in range(terms)),
        tuple(f"alpha[{p}]" for p in range(terms)),
        _ogden_basis,
        lambda linear, shape, density, max_strain: Ogden(
            mu=linear.tolist(), alpha=shape.tolist(), density=density, max_strain=max_strain
        ),
        bounds=lambda stretch: (-49.0, 49.0),  # inside what the law accepts, with room for the differences
        starts=_ogden_starts(terms),
    )


def _reached(stretch: Vector) -> float:
    """Largest I1 - 3 among the points."""
    return float(np.max(stretch**2 + 2.0 / stretch - 3.0))


def _gent_basis(stretch: Vector, shape: Vector) -> Vector:
    jm = float(shape[0])
    if not jm > _reached(stretch):
        return np.full((stretch.size, 1), np.nan)
    return Gent(mu=1.0, jm=jm).uniaxial_stress(stretch)[:, None]


_FAMILIES: dict[str, _Family] = {
    "neo-hooke": _Family(
        ("c1",),
        (),
        _neo_hooke_basis,
        lambda c, _, density, limit: NeoHookean(c1=c[0], density=density, max_strain=limit),
    ),
    "yeoh": _Family(
        ("c1", "c2"),
        (),
        _yeoh_basis(2),
        lambda c, _, density, limit: Yeoh(c1=c[0], c2=c[1], density=density, max_strain=limit),
    ),
    "yeoh3": _Family(
        ("c1", "c2", "c3"),
        (),
        _yeoh_basis(3),
        lambda c, _, density, limit: Yeoh(c1=c[0], c2=c[1], c3=c[2], density=density, max_strain=limit),
    ),
    "mooney-rivlin": _Family(
        ("c10", "c01"),
        (),
        _mooney_rivlin_basis,
        lambda c, _, density, limit: MooneyRivlin(c10=c[0], c01=c[1], density=density, max_strain=limit),
    ),
    "ogden1": _ogden(1),
    "ogden2": _ogden(2),
    "ogden3": _ogden(3),
    "gent": _Family(
        ("mu",),
        ("jm",),
        _gent_basis,
        lambda c, shape, density, limit: Gent(mu=c[0], jm=shape[0], density=density, max_strain=limit),
        bounds=lambda stretch: (_reached(stretch) * (1.0 + 1e-9), 1e4 * max(_reached(stretch), 1.0)),
        starts=lambda stretch: [
            (_reached(stretch) * factor,) for factor in (1.02, 1.1, 1.4, 2.0, 4.0, 10.0, 40.0, 200.0)
        ],
    ),
}

FIT_LAWS: tuple[str, ...] = tuple(_FAMILIES)
"""Names that `fit_uniaxial` and the command line accept."""
