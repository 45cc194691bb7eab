"""Parameters of a model from measured numbers, by nonlinear least squares; what the data say of them, and what not.

Levenberg-Marquardt on residuals in units of their noise, with the model's own derivatives; outliers by reweighting.
Source: MECHANICS, "Identification".
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb.arguments import finite_array, one_finite, one_of, positive_array, shown
from softlimb.identify.statistics import (
    LOSSES,
    Loss,
    loss_kind,
    robust_scale,
    student_quantile,
    variance_factor,
)
from softlimb.text_tables import signed_parts

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Noise = Literal["estimated", "given"]
Model = Callable[[Array], tuple[Array, Array]]
HoldOut = Any  # mask, places or a slice of the measured numbers

_MOST_STEPS = 100
# Steps after which the search no longer goes along what the data cannot see: such valleys are bent and without end.
_PATIENCE = 30
_MOST_SCALES = 30  # rounds of reweighting; each halves the scale's change or better
# Of the largest singular value: no step goes along what is smaller while it does not show above the residuals.
_HARDLY_SEEN = 1e-4
_NUMERICAL_RANK = 1e-9  # of the largest singular value: what is smaller is rounding of model and derivatives
# Share of the residual along the slopes at which the search ends; and at which it ends where a step brings no gain,
# because what is left is the rounding of the model.
_FLAT, _NO_GAIN = 1e-9, 1e-4
_SMALL_STEP = 1e-9  # of a parameter's scale
_PROFILE_REACH = 30.0  # standard errors beyond which an interval counts as open


class Block(NamedTuple):
    """Rows ``first`` to ``last`` (exclusive) of the measured numbers: one quantity in one unit."""

    name: str
    unit: str
    first: int
    last: int


@dataclass(frozen=True)
class Profile:
    """How much worse the data are met when one parameter is held and all others follow.

    Parameters
    ----------
    name : str
    values : array, shape (n,)
        Of the parameter, ascending.
    distance : array, shape (n,)
        Signed root of the growth of the sum of squares over the noise's variance: a straight line of slope 1 over the
        standard error where the model is as good as linear.
    interval : tuple of 2 float
        Where the distance meets Student's quantile; infinite where it does not within 30 standard errors or the bounds.
    quantile : float
    estimate, standard_error : float
    """

    name: str
    values: Array
    distance: Array
    interval: tuple[float, float]
    quantile: float
    estimate: float
    standard_error: float


@dataclass(frozen=True)
class Identified:
    """Parameters that explain measured numbers, and how well the numbers determine them.

    Parameters
    ----------
    names : tuple of str
        Of the k parameters.
    estimates : array, shape (k,)
        Those of an unidentifiable direction say nothing. Where it moves the data 1e-4 times as much as the best seen
        direction or less, they stay near where the search began; else they may go as far as the noise takes them.
    covariance : array, shape (k, k)
        To first order, of independent errors; infinite along what the data cannot see at all.
    residuals : array, shape (n,)
        Measured less model, in the units given; held-out rows included.
    weights : array, shape (n,)
        1 for a row that counts in full, less for one taken for an outlier, 0 for one held out.
    noise : float
        Standard deviation of the residuals in units of ``sigma``; with noise "estimated" this scales the errors.
    degrees_of_freedom : int
        Rows used less parameters.
    scale : array, shape (k,)
        Change of each parameter that counts as large.
    singular_values : array, shape (k,)
        Standard deviations of the noise by which the data move, when parameters change by ``scale`` along each of
        ``directions``; largest first.
    directions : array, shape (k, k)
        Rows: combinations of parameters in units of ``scale``.
    unidentifiable : tuple of str
        In words, the directions with a singular value below 1: a change as large as the scale stays within the noise.
    confidence : float
    at_bound : tuple of str
        Parameters that ended at a bound: their intervals do not hold.
    used : array of bool, shape (n,)
        Rows of the fit; the others were held out.
    blocks : tuple of Block
        What the rows are.
    notes : tuple of str
        What to know before trusting the intervals.
    status : str
        ``converged``, ``max_iterations``, ``no_progress``, ``not_finite`` (the model has no answer at the start).
    iterations : int
    model : object
        What was identified, with the estimates in it, where `identify` was given one.
    """

    names: tuple[str, ...]
    estimates: Array
    covariance: Array
    residuals: Array
    weights: Array
    noise: float
    degrees_of_freedom: int
    scale: Array
    singular_values: Array
    directions: Array
    unidentifiable: tuple[str, ...]
    confidence: float
    at_bound: tuple[str, ...]
    used: Mask
    blocks: tuple[Block, ...]
    notes: tuple[str, ...]
    status: str
    iterations: int
    model: Any = None
    _problem: _Problem | None = field(default=None, repr=False)

    @property
    def success(self) -> bool:
        """True when no small change of the parameters meets the data better."""
        return self.status == "converged"

    @property
    def identifiable(self) -> bool:
        """True when every combination of parameters shows in the data."""
        return self.success and not self.unidentifiable

    def _index(self, name: str) -> int:
        if name not in self.names:
            raise KeyError(f"there is no parameter {shown(name)}; there are {', '.join(self.names)}")
        return self.names.index(name)

    def __getitem__(self, name: str) -> float:
        """The estimate of a parameter; KeyError where there is none of that name."""
        return float(self.estimates[self._index(name)])

    @property
    def values(self) -> dict[str, float]:
        """Estimates by name."""
        return dict(zip(self.names, self.estimates.tolist(), strict=True))

    @property
    def standard_errors(self) -> dict[str, float]:
        """Of each parameter, by name."""
        return dict(zip(self.names, np.sqrt(np.diagonal(self.covariance)).tolist(), strict=True))

    @property
    def quantile(self) -> float:
        """Student's quantile of the confidence; the normal one where the noise was given."""
        known = self._problem is not None and self._problem.noise == "given"
        return student_quantile(self.confidence, 10**9 if known else self.degrees_of_freedom)

    @property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """Estimate -+ quantile times standard error; `profile` gives intervals without linearising."""
        errors, quantile = self.standard_errors, self.quantile
        return {name: (value - quantile * errors[name], value + quantile * errors[name])
                for name, value in self.values.items()}

    @property
    def correlation(self) -> Array:
        """Of the parameters' errors, shape (k, k); NaN where an error is infinite."""
        sizes = np.sqrt(np.diagonal(self.covariance))
        with np.errstate(invalid="ignore", divide="ignore"):
            found: Array = self.covariance / np.outer(sizes, sizes)
        return found

    def rms(self, block: str | None = None, *, held_out: bool = False) -> float:
        """Root mean square of the residuals of one block, or of all, of the rows used or held out; NaN without rows."""
        chosen = ~self.used if held_out else self.used.copy()
        if block is not None:
            inside = np.zeros_like(chosen)
            named = [b for b in self.blocks if b.name == block]
            if not named:
                raise KeyError(f"there is no block {shown(block)}; there are {', '.join(b.name for b in self.blocks)}")
            for b in named:
                inside[b.first : b.last] = True
            chosen &= inside
        return float(np.sqrt(np.mean(self.residuals[chosen] ** 2))) if chosen.any() else float("nan")

    @cached_property
    def curved(self) -> dict[str, tuple[float, float]]:
        """Parameters whose intervals do not hold, because the model bends: for them `profile` has the interval.

        At either end of a parameter's interval, the others where the linearised model has them, the data should be off
        by the quantile; here is by how many quantiles they are, for parameters where that is not within 0.7 and 1.4.
        Infinite errors, and an end where the model has no answer, count as bent.
        """
        if not self.success or self._problem is None:
            return {}
        lengths, found = _lengths(self, self._problem), {}
        for number, name in enumerate(self.names):
            error = np.sqrt(self.covariance[number, number])
            if not np.isfinite(self.covariance[:, number]).all() or error == 0.0:
                found[name] = (float("nan"), float("nan"))
                continue
            along = self.covariance[:, number] / error
            ends = [lengths(self.estimates + side * self.quantile * along) / self.quantile for side in (-1.0, 1.0)]
            if not all(0.7 <= end <= 1.4 for end in ends):
                found[name] = (ends[0], ends[1])
        return found

    def report(self) -> str:
        """Estimates with errors and intervals, what cannot be known, and what to be wary of, as text."""
        errors, intervals = self.standard_errors, self.intervals
        width = max(len(name) for name in self.names)
        level = f"{100.0 * self.confidence:g} %"
        lines = [
            f"{name:<{width}} = {value:.5g} +- {errors[name]:.2g}   {level}: {low:.5g} .. {high:.5g}"
            for (name, value), (low, high) in zip(self.values.items(), intervals.values(), strict=True)
        ]
        lines.append(f"outcome: {self.status}; {int(self.used.sum())} numbers used, {int((~self.used).sum())} held out")
        blind = len(self.names) - len(self.unidentifiable)
        lines += [
            f"not identifiable from these data: {what}: a change as large as the scale moves them by {shown_by:.2g} "
            "standard deviations of the noise"
            for what, shown_by in zip(self.unidentifiable, self.singular_values[blind:], strict=True)
        ]
        if not self.success:
            lines.append(f"not identifiable: the search did not converge ({self.status})")
        if self.curved:
            lines.append(f"the model bends within the interval of {', '.join(self.curved)}: use its profile")
        lines += [f"at its bound: {name}" for name in self.at_bound]
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])

    def profile(self, name: str, points: int = 8) -> Profile:
        """The profile of one parameter and the interval that it gives.

        Parameters
        ----------
        name : str
        points : int
            On each side of the estimate.

        Raises
        ------
        KeyError
            There is no such parameter.
        ValueError
            Fewer than 2 points a side.
        RuntimeError
            The search did not converge.
        """
        number = self._index(name)
        if not isinstance(points, int) or points < 2:
            raise ValueError(f"points must be a whole number of at least 2, got {shown(points)}")
        if not self.success or self._problem is None:
            raise RuntimeError(f"a profile exists of a fit that converged; this one ended with {self.status!r}")
        return _profile(self, self._problem, number, points)

    def __repr__(self) -> str:
        errors = self.standard_errors
        values = ", ".join(f"{name}={value:.6g}+-{errors[name]:.2g}" for name, value in self.values.items())
        verdict = "" if not self.unidentifiable else f", not identifiable: {'; '.join(self.unidentifiable)}"
        return f"Identified({self.status}, {values}{verdict})"


@dataclass(frozen=True)
class _Problem:
    """What a search needs; rows that are held out are in none of its sums."""

    model: Model
    measured: Array
    sigma: Array
    used: Mask
    scale: Array
    low: Array
    high: Array
    noise: Noise
    loss: Loss

    def residual(self, values: Array) -> tuple[Array, Array] | None:
        """Whitened residuals of the used rows, and slopes to parameters in units of their scale; None: no answer."""
        predicted, jacobian = self.model(values)
        used = self.used
        if not np.isfinite(predicted[used]).all():
            return None
        whitened = (predicted[used] - self.measured[used]) / self.sigma[used]
        return whitened, jacobian[used] * self.scale / self.sigma[used, None]


class _End(NamedTuple):
    values: Array
    residual: Array
    slopes: Array
    cost: float
    status: str
    steps: int


def _descend(problem: _Problem, start: Array, size: float, held: int | None = None) -> _End:
    """Levenberg-Marquardt on the loss at a given scale of the residuals, one parameter held if asked."""
    kind = loss_kind(problem.loss)
    first = problem.residual(start)
    count = len(start)
    if first is None or not np.isfinite(first[1]).all():
        none = np.full(int(problem.used.sum()), np.nan)
        return _End(start, none, np.full((len(none), count), np.nan), np.nan, "not_finite", 0)
    (residual, slopes), values = first, start
    cost = float(kind.rho(residual / size).sum())
    norms, damping = np.zeros(count), 0.0
    rounding = float(np.sum((problem.measured[problem.used] / problem.sigma[problem.used]) ** 2))
    floor = residual.size * (4.0 * np.finfo(float).eps) ** 2 * rounding / size**2
    for steps in range(_MOST_STEPS):
        root = np.sqrt(kind.weight(residual / size))
        weighted, columns = root * residual, root[:, None] * slopes
        gradient = columns.T @ weighted
        free = ~(((values <= problem.low) & (gradient > 0.0)) | ((values >= problem.high) & (gradient < 0.0)))
        if held is not None:
            free[held] = False
        norms = np.maximum(norms, np.linalg.norm(columns, axis=0))
        patient = steps < _PATIENCE
        unit = np.where(norms > 0.0, norms, 1.0) if patient else np.ones(count)
        left, singular, right = np.linalg.svd((columns / unit)[:, free], full_matrices=False)
        seen = singular > _NUMERICAL_RANK * singular.max(initial=0.0)
        freedom = max(residual.size - count, 1)
        noise = 1.0 if problem.noise == "given" else float(np.linalg.norm(weighted)) / np.sqrt(freedom)
        shows = singular > noise * np.linalg.norm(right / unit[free], axis=1)  # a change as large as the scale
        seen &= shows | (patient & (singular > _HARDLY_SEEN * singular.max(initial=0.0)))
        along = left[:, seen].T @ weighted
        share = float(np.linalg.norm(along) / max(np.linalg.norm(weighted), np.finfo(float).tiny))
        if share <= _FLAT or cost <= floor:
            return _End(values, residual, slopes, cost, "converged", steps)
        while True:
            change = np.zeros(count)
            amount = singular[seen] / (singular[seen] ** 2 + damping) * along
            change[free] = -(right[seen].T @ amount) / unit[free]
            trial = np.clip(values + problem.scale * change, problem.low, problem.high)
            small = bool(np.all(np.abs(trial - values) <= _SMALL_STEP * problem.scale))
            found = None if small else problem.residual(trial)
            if found is not None and np.isfinite(found[1]).all():
                better = float(kind.rho(found[0] / size).sum())
                if better < cost:
                    values, (residual, slopes), cost = trial, found, better
                    damping = 0.1 * damping if damping > 1e-7 else 0.0
                    break
            if small:
                # As good as the rounding of the model allows, or stuck at the edge of where it has an answer.
                status = "converged" if share <= _NO_GAIN or damping == 0.0 else "no_progress"
                return _End(values, residual, slopes, cost, status, steps)
            damping = max(10.0 * damping, 1e-4)
    return _End(values, residual, slopes, cost, "max_iterations", _MOST_STEPS)


def _search(problem: _Problem, start: Array) -> tuple[_End, float]:
    """The end of the search, and the scale of the residuals that its loss was taken at."""
    count = len(start)
    if problem.loss == "square" or problem.noise == "given":
        return _descend(problem, start, 1.0), 1.0
    # Outliers: Huber's loss first, which has one minimum for a linear model; scale and parameters in turn.
    end, steps = _descend(replace(problem, loss="square"), start, 1.0), 0
    size = 1.0
    stages: tuple[Loss, ...] = ("huber",) if problem.loss == "huber" else ("huber", problem.loss)
    for loss in stages:
        for _ in range(_MOST_SCALES):
            if end.status == "not_finite":
                return end, size
            new = robust_scale(end.residual, count)
            if new <= 1e-12 * size or new == 0.0:  # more than half of the rows are met exactly
                return end, max(new, np.finfo(float).tiny)
            done = abs(new - size) <= 1e-6 * size
            size = new
            end = _descend(replace(problem, loss=loss), end.values, size)
            steps += end.steps
            if done:
                break
    return end._replace(steps=steps), size


def _variance(problem: _Problem, end: _End, size: float) -> float:
    """What multiplies (J^T J)^-1 of the whitened slopes."""
    if problem.loss == "square" and problem.noise == "given":
        return 1.0
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = variance_factor(loss_kind(problem.loss), end.residual / size, len(end.values))
    return size**2 * factor


def _largest_positive(vector: Array) -> Array:
    return vector if vector[np.argmax(np.abs(vector))] > 0.0 else -vector


def least_squares(
    model: Model,
    measured: ArrayLike,
    start: Mapping[str, float],
    *,
    sigma: ArrayLike = 1.0,
    noise: Noise = "estimated",
    loss: Loss = "square",
    bounds: Mapping[str, tuple[float, float]] | None = None,
    scale: Mapping[str, float] | None = None,
    hold_out: HoldOut = None,
    confidence: float = 0.95,
    blocks: Sequence[Block] = (),
) -> Identified:
    """Identify the parameters of any model with derivatives.

    Parameters
    ----------
    model : callable
        Parameters, shape (k,) -> predictions (n,) and their derivatives (n, k). NaN where there is no prediction: such
        parameters are not gone to.
    measured : array_like, shape (n,)
    start : mapping of str to float
        Names and first values, in the order of the model's parameters.
    sigma : array_like, shape () or (n,)
        Standard deviation of the noise of each number, in its unit; with noise "estimated" only their ratios count.
    noise : {"estimated", "given"}
        Whether the size of the noise comes from the residuals (Student's intervals) or is known (normal ones).
    loss : {"square", "huber", "cauchy"}
        What a large residual costs: its square, its size, or hardly more than a medium one. The scale, beyond which
        one is large, is that of the bulk of the residuals (median), or ``sigma`` where the noise is given.
    bounds : mapping of str to (float, float), optional
        By parameter; others are free.
    scale : mapping of str to float, optional
        Change that counts as large, by parameter; default: the size of the first value. Needed where that is zero. It
        decides what is called identifiable.
    hold_out : array of bool (n,), array of int, or slice, optional
        Numbers that the fit must not see; their residuals are in the answer.
    confidence : float
        Of intervals.
    blocks : sequence of Block
        What the rows are, for the answer.

    Returns
    -------
    Identified

    Raises
    ------
    ValueError
        Shapes do not fit, a number is not finite, fewer rows than parameters are left, a start is outside its bounds, a
        name is unknown, an option is unknown, or nothing or everything is held out.
    """
    y = finite_array("measured", measured)
    if y.ndim != 1 or not y.size:
        raise ValueError(f"measured must be a list of numbers, got shape {y.shape}")
    names, values = tuple(start), np.array([one_finite(f"start of {name}", start[name]) for name in start])
    if not names:
        raise ValueError("start must name at least one parameter")
    deviation = positive_array("sigma", sigma)
    if deviation.shape not in ((), y.shape):
        raise ValueError(f"sigma has shape {deviation.shape}: expected () or {y.shape}")
    one_of("noise", noise, ("estimated", "given"))
    one_of("loss", loss, LOSSES)
    level = one_finite("confidence", confidence)
    if not 0.0 < level < 1.0:
        raise ValueError(f"confidence must be within (0, 1), got {level}")
    low, high = _limits(names, values, bounds)
    used = ~_held_out(hold_out, y.size)
    if int(used.sum()) < len(names) + (noise == "estimated"):
        raise ValueError(
            f"{int(used.sum())} measured numbers are too few for {len(names)} parameters"
            + (" and an estimate of the noise" if noise == "estimated" else "")
        )
    each = np.broadcast_to(deviation, y.shape).copy()
    problem = _Problem(model, y, each, used, _scales(names, values, scale), low, high, noise, loss)
    end, size = _search(problem, values)
    return _answer(problem, end, size, names, level, tuple(blocks))


def _limits(
    names: tuple[str, ...], values: Array, bounds: Mapping[str, tuple[float, float]] | None
) -> tuple[Array, Array]:
    low, high = np.full(len(names), -np.inf), np.full(len(names), np.inf)
    for name, pair in (bounds or {}).items():
        if name not in names:
            raise ValueError(f"bounds name {shown(name)}, which is no parameter; there are {', '.join(names)}")
        try:
            least, most = (float(end) for end in pair)
        except (TypeError, ValueError):
            raise ValueError(f"bounds of {name} must be two numbers, got {shown(pair)}") from None
        k = names.index(name)
        if not least < most:
            raise ValueError(f"bounds of {name} must be ascending, got {pair}")
        if not least <= values[k] <= most:
            raise ValueError(f"start of {name} must be within its bounds {pair}, got {values[k]:.6g}")
        low[k], high[k] = least, most
    return low, high


def _scales(names: tuple[str, ...], values: Array, scale: Mapping[str, float] | None) -> Array:
    given = dict(scale or {})
    for name in given:
        if name not in names:
            raise ValueError(f"scale names {shown(name)}, which is no parameter; there are {', '.join(names)}")
    sizes = np.abs(values)
    for k, name in enumerate(names):
        if name in given:
            sizes[k] = one_finite(f"scale of {name}", given[name])
        if not sizes[k] > 0.0:
            rule = "a parameter that starts at zero needs one"
            raise ValueError(f"scale of {name} must be positive, got {sizes[k]:g}: {rule}")
    return sizes


def _held_out(hold_out: HoldOut, count: int) -> Mask:
    """Mask of the numbers to hold out."""
    mask = np.zeros(count, dtype=bool)
    if hold_out is None:
        return mask
    try:
        given = hold_out if isinstance(hold_out, slice) else np.asarray(hold_out)
        if not isinstance(given, slice):
            if given.dtype == np.bool_ and given.shape != (count,):
                raise IndexError
            if given.dtype != np.bool_ and given.dtype.kind not in "iu":
                raise IndexError
        mask[given] = True
    except (IndexError, ValueError):
        raise ValueError(
            f"hold_out must be {count} truth values, places below {count}, or a slice, got {shown(hold_out)}"
        ) from None
    if not mask.any():
        text = shown(hold_out)
        raise ValueError(f"hold_out selects none of the {count} rows (is it the wrong way round?), got {text}")
    if mask.all():
        raise ValueError("hold_out selects every row: nothing is left to fit")
    return mask


def _answer(
    problem: _Problem, end: _End, size: float, names: tuple[str, ...], confidence: float, blocks: tuple[Block, ...]
) -> Identified:
    count, used = len(names), problem.used
    rows = int(used.sum())
    weights = np.zeros(used.size)
    if end.status == "not_finite":
        nothing = np.full(count, np.nan)
        return Identified(
            names, nothing, np.full((count, count), np.nan), np.full(used.size, np.nan), weights, np.nan,
            rows - count, problem.scale, nothing, np.eye(count), (), confidence, (), used, blocks,
            ("the model has no answer at the first values",), end.status, 0, None, problem,
        )  # fmt: skip
    variance = _variance(problem, end, size)
    weights[used] = loss_kind(problem.loss).weight(end.residual / size)
    predicted, _ = problem.model(end.values)
    fixed = (end.values <= problem.low) | (end.values >= problem.high)
    deviation = float(np.sqrt(variance))
    _, singular, right = np.linalg.svd(end.slopes, full_matrices=rows < count)
    singular = np.concatenate([singular, np.zeros(count - len(singular))])
    seen = singular > _NUMERICAL_RANK * singular[0]
    # Noiseless data leave no deviation to compare with: then only what is lost to rounding cannot be seen.
    shown_by = singular / max(deviation, 1e-300)
    spread = problem.scale[:, None] * right[seen].T / singular[seen]
    covariance = variance * spread @ spread.T
    for direction in right[~seen]:
        # A parameter with a part in what cannot be seen at all has no finite error.
        lost = np.abs(direction) > 1e-6
        covariance[np.ix_(lost, lost)] = np.nan
        covariance[lost, lost] = np.inf
    blind = (shown_by < 1.0) | ~seen
    return Identified(
        names=names,
        estimates=end.values,
        covariance=covariance,
        residuals=problem.measured - predicted,
        weights=weights,
        noise=deviation if problem.noise == "estimated" else float(np.sqrt(np.mean(end.residual**2))),
        degrees_of_freedom=rows - count,
        scale=problem.scale,
        singular_values=shown_by,
        directions=right,
        unidentifiable=tuple(signed_parts(_largest_positive(row), names) for row in right[blind]),
        confidence=confidence,
        at_bound=tuple(name for name, at in zip(names, fixed, strict=True) if at),
        used=used,
        blocks=blocks,
        notes=_notes(problem, end, size, blocks),
        status=end.status,
        iterations=end.steps,
        _problem=problem,
    )


def _notes(problem: _Problem, end: _End, size: float, blocks: tuple[Block, ...]) -> tuple[str, ...]:
    notes = []
    x = end.residual / size
    n, k = x.size, len(end.values)
    if problem.noise == "given" and n > k:
        ratio = float(x @ x) / (n - k)
        # Chi-square over its n - k degrees of freedom has a standard deviation of sqrt(2/(n - k)).
        if ratio > 1.0 + 4.0 * np.sqrt(2.0 / (n - k)):
            times = f"{np.sqrt(ratio):.3g}"
            notes.append(f"the residuals are {times} times the noise that was given: intervals are too narrow")
    outliers = int(np.count_nonzero(loss_kind(problem.loss).weight(x) < 0.5))
    if outliers:
        notes.append(f"{outliers} of {n} numbers count less than half, as outliers")
    place = np.cumsum(problem.used) - 1
    for block in blocks or (Block("measured", "", 0, problem.used.size),):
        inside = [int(place[i]) for i in range(block.first, block.last) if problem.used[i]]
        z = end.residual[inside]
        if len(z) < 10 or not z.any():
            continue
        lag = float(z[1:] @ z[:-1] / (z @ z))
        # Of independent errors the lag-one correlation has a standard deviation of 1/sqrt(n).
        if lag > 3.0 / np.sqrt(len(z)):
            factor = np.sqrt((1.0 + lag) / max(1.0 - lag, 1e-3))
            notes.append(
                f"neighbouring residuals of {block.name} are correlated ({lag:.2f}): model error or history, not "
                f"noise, and intervals too narrow, about {factor:.1f} times where parameters act alike on neighbours"
            )
    return tuple(notes)


def _growth(found: Identified, problem: _Problem) -> tuple[float, float, float]:
    """Scale of the residuals, loss at the estimates, and the growth of the loss that counts as one variance.

    For least squares that is the noise's variance; for others the ratio of E psi^2 to E psi', by which a likelihood
    ratio of theirs is scaled (Huber 1981, section 7.10).
    """
    kind = loss_kind(problem.loss)
    full = problem.residual(found.estimates)
    assert full is not None  # the search ended there
    size = 1.0
    if problem.loss != "square" and problem.noise == "estimated":
        size = robust_scale(full[0], len(found.estimates))
    x = full[0] / size
    base = float(kind.rho(x).sum())
    if problem.noise == "given" and problem.loss == "square":
        return size, base, 1.0
    psi = kind.weight(x) * x
    unit = float(psi @ psi) / max(x.size - len(found.estimates), 1) / max(float(kind.slope(x).mean()), 1e-12)
    return size, base, unit


def _lengths(found: Identified, problem: _Problem) -> Callable[[Array], float]:
    """How far data are from those of the estimates, in standard deviations of the noise, by parameters."""
    kind = loss_kind(problem.loss)
    size, base, unit = _growth(found, problem)

    def length(values: Array) -> float:
        at = problem.residual(np.clip(values, problem.low, problem.high))
        if at is None or unit <= 0.0:
            return float("inf")
        return float(np.sqrt(max(float(kind.rho(at[0] / size).sum()) - base, 0.0) / unit))

    return length


def _profile(found: Identified, problem: _Problem, number: int, points: int) -> Profile:
    values = found.estimates
    size, base, unit = _growth(found, problem)
    error = float(np.sqrt(found.covariance[number, number]))
    step = error if np.isfinite(error) and error > 0.0 else float(problem.scale[number])
    quantile, name = found.quantile, found.names[number]
    grid: dict[float, float] = {float(values[number]): 0.0}
    ends = []
    for side in (-1.0, 1.0):
        limit = float(problem.low[number] if side < 0.0 else problem.high[number])
        reach = min(abs(limit - values[number]), _PROFILE_REACH * step)

        near = [(float(values[number]), values)]  # points of the profile so far, to start from

        def distance(offset: float, side: float = side, near: list[tuple[float, Array]] = near) -> float:
            at = float(values[number] + side * offset)
            first = min(near, key=lambda point: abs(point[0] - at))[1].copy()
            first[number] = at
            end = _descend(problem, first, size, held=number)
            if end.status == "not_finite":
                return float("inf")  # no model there: as far from the data as can be
            near.append((at, end.values))
            return float(np.sqrt(max(end.cost - base, 0.0) / unit)) if unit > 0.0 else float("inf")

        inner, outer, at_inner = 0.0, min(quantile * step, reach), 0.0
        at_outer = distance(outer)
        while at_outer < quantile and outer < reach:
            inner, at_inner = outer, at_outer
            outer = min(2.0 * outer, reach)
            at_outer = distance(outer)
        if at_outer < quantile:
            ends.append(side * np.inf)
            span = outer
        else:
            # Nearly straight: false position, guarded by bisection where the far end has no value.
            while outer - inner > 1e-4 * step:
                share = (quantile - at_inner) / (at_outer - at_inner) if np.isfinite(at_outer) else 0.5
                middle = inner + float(np.clip(share, 0.02, 0.98)) * (outer - inner)
                at_middle = distance(middle)
                if abs(at_middle - quantile) <= 1e-4 * quantile:
                    inner = outer = middle
                elif at_middle < quantile:
                    inner, at_inner = middle, at_middle
                else:
                    outer, at_outer = middle, at_middle
            ends.append(float(values[number] + side * 0.5 * (inner + outer)))
            span = min(1.3 * outer, reach)
        for share in np.arange(1, points + 1) / points:
            grid[float(values[number] + side * share * span)] = side * distance(float(share * span))
    places = sorted(grid)
    return Profile(
        name, np.array(places), np.array([grid[at] for at in places]), (ends[0], ends[1]), quantile,
        float(values[number]), error,
    )  # fmt: skip
