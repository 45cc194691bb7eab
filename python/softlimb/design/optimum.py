"""The outcome of an optimisation: the best design, what holds it back, and what it would gain by more room."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from softlimb.design.history import History
from softlimb.design.problem import Evaluation, Problem
from softlimb.limb import Limb

__all__ = ["Active", "Optimum", "optimum_of"]

Array = NDArray[np.float64]

_KEPT = 1e-5  # of a limit or a range: what counts as kept; NLopt's algorithms keep theirs to about 1e-6
_AT_LIMIT = 1e-4  # of a limit or a range: what counts as active; ten times what a search leaves


@dataclass(frozen=True)
class Active:
    """A constraint or bound that the optimum touches.

    Parameters
    ----------
    what : str
        In words.
    multiplier : float or None
        What the objective would change by if the limit rose by one unit [objective's unit over the limit's]; None where
        it is not known. From the gradients at the optimum, by least squares.
    """

    what: str
    multiplier: float | None


@dataclass(frozen=True)
class Optimum:
    """The best design that a search found.

    Parameters
    ----------
    problem : Problem
    best : Evaluation or None
        With gradients where they are known; None where no design had values.
    feasible : bool
        The best design keeps its constraints (to 1e-5 of their limits).
    active : tuple of Active
        Constraints and bounds that it touches (to 1e-4 of limits and ranges).
    stationarity : float or None
        What the multipliers leave of the objective's gradient, variables scaled by their ranges: relative to it, or to
        the objective where nothing is active. Small at an optimum. None where the gradient is not known.
    history : History
        Every design that was looked at.
    algorithm : str
    success : bool
        The search ended at a feasible design, by itself; for "direct", "crs" and "mlsl", which look everywhere and
        hardly ever end by themselves, also when the evaluations allowed were used up (`message` says which): no sign
        then that a better design does not exist.
    message : str
        The end in words.
    """

    problem: Problem
    best: Evaluation | None
    feasible: bool
    active: tuple[Active, ...]
    stationarity: float | None
    history: History
    algorithm: str
    success: bool
    message: str

    @property
    def values(self) -> dict[str, float]:
        """Best values of the parameters by name; empty where there are none."""
        if self.best is None:
            return {}
        return {p.name: value for p, value in zip(self.problem.parameters, self.best.values, strict=True)}

    @property
    def objective(self) -> float:
        """At the best design; NaN where there is none."""
        return np.nan if self.best is None else self.best.objective

    @property
    def constraints(self) -> dict[str, float]:
        """Values of the constraints' criteria at the best design, by the constraints in words."""
        if self.best is None:
            return {}
        return {str(c): value for c, value in zip(self.problem.constraints, self.best.constraints, strict=True)}

    @property
    def sensitivities(self) -> dict[str, dict[str, float]]:
        """Criterion, to parameter, to the derivative at the best design; empty where not known."""
        if self.best is None or self.best.gradients is None:
            return {}
        names = [parameter.name for parameter in self.problem.parameters]
        rows = zip(self.problem.criteria, self.best.gradients, strict=True)
        return {criterion.name: dict(zip(names, row, strict=True)) for criterion, row in rows}

    @cached_property
    def limb(self) -> Limb:
        """The best design.

        Raises
        ------
        RuntimeError
            No design had values.
        """
        if self.best is None:
            raise RuntimeError(f"there is no best design: {self.message}")
        return self.problem.limb(self.best.values)

    def __repr__(self) -> str:
        values = ", ".join(f"{name}={value:.6g}" for name, value in self.values.items())
        return f"Optimum({values}: {self.problem.objective.name} {self.objective:.6g}, {self.message})"


def optimum_of(
    problem: Problem,
    history: History,
    algorithm: str,
    ended: bool,
    message: str,
    evaluate: Callable[[Array, bool], Evaluation],
) -> Optimum:
    """Choose the best of all designs that were looked at, and read from its gradients what holds it."""
    found = [each for each in history if each.success]
    if not found:
        message += f"; all {len(history)} designs failed"
        return Optimum(problem, None, False, (), None, history, algorithm, False, message)
    kept = [each for each in found if _excess(problem, each) <= _KEPT]
    if kept:
        sign = -1.0 if problem.sense == "maximise" else 1.0
        best = min(kept, key=lambda each: sign * each.objective)
    else:
        best = min(found, key=lambda each: _excess(problem, each))
        message += "; no design that was looked at keeps the constraints"
    with_slopes = evaluate(np.array(best.values), True)
    best = with_slopes if with_slopes.success else best
    if history.failures:
        message += f"; {len(history.failures)} of {len(history)} designs failed"
    active, stationarity = _multipliers(problem, best)
    success = ended and bool(kept)
    return Optimum(problem, best, bool(kept), active, stationarity, history, algorithm, success, message)


def _excess(problem: Problem, evaluation: Evaluation) -> float:
    """The largest violation, relative to its limit; zero where all constraints are kept."""
    pairs = zip(problem.constraints, evaluation.constraints, strict=True)
    return max([0.0, *(c.sign * (value - c.limit) / (abs(c.limit) or 1.0) for c, value in pairs)])


def _multipliers(problem: Problem, best: Evaluation) -> tuple[tuple[Active, ...], float | None]:
    """What is active, and the multipliers that balance the objective's gradient best.

    At an optimum grad f = sum of m_i grad g_i over what is active, and m_i is what f gains when limit i rises by one.
    """
    span = problem.upper - problem.lower
    wanted = 1.0 if problem.sense == "maximise" else -1.0
    texts: list[str] = []
    rows: list[Array | None] = []
    scales: list[float] = []
    signs: list[float] = []  # of a multiplier that holds the design back
    for k, constraint in enumerate(problem.constraints):
        scale = abs(constraint.limit) or 1.0
        if abs(best.constraints[k] - constraint.limit) <= _AT_LIMIT * scale:
            texts.append(str(constraint))
            rows.append(None if best.gradients is None else np.array(best.gradients[1 + k]) * span / scale)
            scales.append(scale)
            signs.append(wanted * constraint.sign)
    for k, parameter in enumerate(problem.parameters):
        for bound, relation, side in ((parameter.lower, ">=", -1.0), (parameter.upper, "<=", 1.0)):
            if abs(best.values[k] - bound) <= _AT_LIMIT * span[k]:
                texts.append(f"{parameter.name} {relation} {bound:g}")
                rows.append(np.eye(len(span))[k])
                scales.append(float(span[k]))
                signs.append(wanted * side)
    if best.gradients is None:
        return tuple(Active(text, None) for text in texts), None
    gradient = np.array(best.gradients[0]) * span
    size = float(np.linalg.norm(gradient))
    if not rows:
        # Nothing holds the design: how far the gradient is from zero is told against the objective itself.
        return (), size / (abs(best.objective) or 1.0)
    matrix = np.array(rows, dtype=float).T
    found, holding = np.zeros(len(texts)), list(range(len(texts)))
    while holding:
        found[:] = 0.0
        found[holding] = np.linalg.lstsq(matrix[:, holding], gradient, rcond=None)[0]
        against = [k for k in holding if found[k] * signs[k] < 0.0]
        if not against:
            break
        # The objective would gain by moving away from this limit: it is touched, but holds nothing back.
        holding.remove(min(against, key=lambda k: found[k] * signs[k]))
    else:
        found[:] = 0.0
    # More limits than freedoms, or limits alike: which of them holds the design cannot be told.
    told = np.linalg.matrix_rank(matrix) == len(texts)
    left = float(np.linalg.norm(matrix @ found - gradient)) / (size or 1.0)
    active = [
        Active(text, float(m / s) if told else None) for text, m, s in zip(texts, found, scales, strict=True)
    ]
    return tuple(active), left
