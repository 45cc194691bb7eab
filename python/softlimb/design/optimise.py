"""Optimisation of designs by NLopt: algorithms by name, scaled variables, failures recorded, runs that resume."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb.arguments import finite_of_shape, one_of, one_positive, one_whole, shown
from softlimb.design.history import History
from softlimb.design.optimum import Optimum, optimum_of
from softlimb.design.problem import Evaluation, Problem

__all__ = ["ALGORITHMS", "optimise"]

Array = NDArray[np.float64]


class _Algorithm(NamedTuple):
    nlopt: str
    gradients: bool
    constraints: bool
    everywhere: bool  # searches the whole box, not near the start
    fewest_parameters: int = 1


ALGORITHMS: dict[str, _Algorithm] = {
    "slsqp": _Algorithm("LD_SLSQP", True, True, False),
    "mma": _Algorithm("LD_MMA", True, True, False),
    "cobyla": _Algorithm("LN_COBYLA", False, True, False),
    "bobyqa": _Algorithm("LN_BOBYQA", False, False, False, 2),
    "direct": _Algorithm("GN_ORIG_DIRECT", False, True, True),
    "crs": _Algorithm("GN_CRS2_LM", False, False, True),
    "mlsl": _Algorithm("G_MLSL_LDS", True, False, True),
}
"""Names, to what they need and take."""

_ENDS = {
    1: "the algorithm says that it succeeded",
    2: "the value that was asked for is reached",
    3: "the objective no longer changes",
    4: "the parameters no longer change",
    5: "the number of evaluations that was allowed is used up",
    6: "the time that was allowed is used up",
    -4: "rounding leaves nothing to gain",
}
_FEASIBLE = 1e-6  # of a constraint's limit: what counts as kept


def optimise(
    problem: Problem,
    algorithm: str = "slsqp",
    *,
    start: ArrayLike | None = None,
    max_evaluations: int = 200,
    tolerance: float = 1e-5,
    seed: int = 0,
    history: str | os.PathLike[str] | None = None,
    progress: Callable[[Evaluation, int], None] | None = None,
) -> Optimum:
    """Find the best design within the bounds and constraints.

    Parameters
    ----------
    problem : Problem
    algorithm : {"slsqp", "mma", "cobyla", "bobyqa", "direct", "crs", "mlsl"}
        "slsqp" and "mma" use gradients, exact where the core has them; "cobyla" and "bobyqa" none. "direct", "crs" and
        "mlsl" (with SLSQP from many starts) look everywhere within the bounds. "bobyqa", "crs" and "mlsl" take no
        constraints, "bobyqa" two parameters at least.
    start : array_like, shape (parameters,), optional
        Default: the problem's limb.
    max_evaluations : int
        Designs that are looked at, at most.
    tolerance : float
        A search ends where the parameters move by less than this share of their ranges.
    seed : int
        Of the algorithms that draw numbers.
    history : str or path, optional
        Where each evaluation is written when it is made. A run that was killed goes on when it is called again with
        the same arguments: what the file has is not computed again.
    progress : callable, optional
        Called with each evaluation and the number of those before.

    Returns
    -------
    Optimum
        The best design that keeps its constraints. Designs that fail are recorded and count as worse than any other;
        Ctrl-C ends the search with what it has, ``success`` false.

    Raises
    ------
    ModuleNotFoundError
        NLopt is not installed.
    ValueError
        An unknown algorithm, or one that does not take the problem; a start of a wrong shape or outside the bounds;
        a file of another problem.
    """
    if not isinstance(problem, Problem):
        raise TypeError(f"problem must be a Problem, got {type(problem).__name__}")
    one_of("algorithm", algorithm, tuple(ALGORITHMS))
    chosen, count = ALGORITHMS[algorithm], len(problem.parameters)
    if problem.constraints and not chosen.constraints:
        able = ", ".join(name for name, each in ALGORITHMS.items() if each.constraints)
        raise ValueError(f"{algorithm} takes no constraints; these do: {able}")
    if count < chosen.fewest_parameters:
        raise ValueError(f"{algorithm} needs {chosen.fewest_parameters} parameters or more, the problem has {count}")
    first = problem.start if start is None else finite_of_shape("start", start, (count,))
    if (first < problem.lower).any() or (first > problem.upper).any():
        raise ValueError(f"start must be within the bounds, got {first.tolist()}")
    if not isinstance(max_evaluations, (int, np.integer)) or isinstance(max_evaluations, bool) or max_evaluations < 1:
        raise ValueError(f"max_evaluations must be a whole number of at least 1, got {shown(max_evaluations)}")
    tolerance, seed = one_positive("tolerance", tolerance), one_whole("seed", seed, 0)
    nlopt = _nlopt()
    search = _Search(problem, History(problem, history), progress, int(max_evaluations))
    nlopt.srand(seed)
    opt = nlopt.opt(getattr(nlopt, chosen.nlopt), count)
    if chosen.nlopt.startswith("G_"):
        local = nlopt.opt(nlopt.LD_SLSQP, count)
        local.set_xtol_abs(tolerance)
        opt.set_local_optimizer(local)
    opt.set_lower_bounds(np.zeros(count))
    opt.set_upper_bounds(np.ones(count))
    opt.set_min_objective(search.objective)
    for number in range(len(problem.constraints)):
        opt.add_inequality_constraint(search.constraint(number), _FEASIBLE)
    opt.set_xtol_abs(tolerance)
    if not chosen.gradients and not chosen.everywhere:
        opt.set_initial_step(0.1)  # of the ranges: a start near a bound has room on one side
    # An exception from a callback ends NLopt; a cap on its own count ends searches that ask for one design twice.
    opt.set_maxeval(20 * int(max_evaluations))
    ended, message = False, "interrupted"
    try:
        opt.optimize((first - problem.lower) / (problem.upper - problem.lower))
        code = int(opt.last_optimize_result())
        ended, message = code in (1, 2, 3, 4), _ENDS.get(code, f"NLopt ended with code {code}")
    except _Enough:
        # Searches of the whole box end in no other way.
        ended, message = chosen.everywhere, _ENDS[5]
    except KeyboardInterrupt:
        pass
    except nlopt.RoundoffLimited:
        ended, message = True, _ENDS[-4]
    except (RuntimeError, ValueError, MemoryError) as error:
        message = f"NLopt ended: {error or type(error).__name__}"
    return optimum_of(problem, search.history, algorithm, ended, message, search.evaluate)


def _nlopt() -> Any:
    try:
        import nlopt  # type: ignore[import-untyped, import-not-found, unused-ignore]
    except ModuleNotFoundError:
        raise ModuleNotFoundError("design needs NLopt: pip install 'softlimb[design]'") from None
    return nlopt


class _Enough(Exception):
    """As many designs as allowed have been looked at."""


class _Search:
    """What NLopt calls: values and gradients over variables from 0 to 1, all to be small."""

    def __init__(
        self,
        problem: Problem,
        history: History,
        progress: Callable[[Evaluation, int], None] | None,
        most: int,
    ) -> None:
        self.problem, self.history = problem, history
        self._progress, self._most = progress, most
        self._asked: dict[tuple[float, ...], None] = {}
        self._sign = -1.0 if problem.sense == "maximise" else 1.0
        self._scale: float | None = None
        self._worst = 0.0

    def evaluate(self, values: Array, gradients: bool) -> Evaluation:
        """The recorded evaluation, or a new one that is recorded."""
        key = tuple(values.tolist())
        found = self.history.find(key, gradients)
        if found is None:
            found = self.problem.evaluate(values, gradients=gradients)
            self.history.add(found)
        return found

    def _at(self, z: Array, gradients: bool) -> Evaluation:
        x = self.problem.lower + z * (self.problem.upper - self.problem.lower)
        key = tuple(x.tolist())
        fresh = key not in self._asked
        if fresh and len(self._asked) >= self._most:
            raise _Enough
        found = self.evaluate(x, gradients)
        self._asked[key] = None
        if fresh and self._progress is not None:
            self._progress(found, len(self._asked) - 1)
        return found

    def objective(self, z: Array, slope: Array) -> float:
        found = self._at(z, slope.size > 0)
        if not found.success:
            # Worse than all so far, so that every algorithm turns back; flat, since there is no slope.
            slope[:] = 0.0
            return self._worst + 1.0
        if self._scale is None:
            self._scale = abs(found.objective) or 1.0
        factor = self._sign / self._scale
        if slope.size:
            assert found.gradients is not None
            slope[:] = factor * np.array(found.gradients[0]) * (self.problem.upper - self.problem.lower)
        value = factor * found.objective
        self._worst = max(self._worst, value)
        return value

    def constraint(self, number: int) -> Callable[[Array, Array], float]:
        limit = self.problem.constraints[number]
        scale = abs(limit.limit) or 1.0

        def excess(z: Array, slope: Array) -> float:
            found = self._at(z, slope.size > 0)
            if not found.success:
                slope[:] = 0.0
                return 1.0
            if slope.size:
                assert found.gradients is not None
                rows = np.array(found.gradients[1 + number]) * (self.problem.upper - self.problem.lower)
                slope[:] = limit.sign * rows / scale
            return limit.sign * (found.constraints[number] - limit.limit) / scale

        return excess
