"""Single shooting as one would write it with scipy: base wrenches unknown, finite differences, no derivative by hand.

The residuals are those of the paper's algorithm at known lengths and a free tip; `scipy.optimize.least_squares` does
the rest, with unknowns and residuals scaled to one and everything else at its defaults.
"""

from __future__ import annotations

import time

import numpy as np

from softlimb.bench.methods import single_shooting
from softlimb.paper import algorithm
from softlimb.paper.problem import Answer, Array, Problem
from softlimb.paper.rods import STEPS

__all__ = ["GaveUp", "solve"]


class GaveUp(Exception):
    """The time allowed is over."""


def solve(problem: Problem, limit: float = 20.0, steps: int = STEPS) -> Answer:
    """From the start of `single_shooting.solve`, and from its second one where that leads nowhere.

    Parameters
    ----------
    limit : float
        Time after which it gives up [s].

    Raises
    ------
    ModuleNotFoundError
        scipy is missing.
    """
    from scipy.optimize import least_squares  # type: ignore[import-untyped, unused-ignore]

    deadline = time.perf_counter() + limit
    unit, sizes = problem.unit_wrenches.ravel(), algorithm.residual_sizes(problem, False)

    def all_unknowns(x: Array) -> Array:
        return np.concatenate([problem.lengths, unit * x])

    def scaled(x: Array) -> Array:
        if time.perf_counter() > deadline:
            raise GaveUp
        rows: Array = algorithm.residual(problem, None, all_unknowns(x), steps)[0] / sizes
        return np.nan_to_num(rows, nan=1e150, posinf=1e150, neginf=-1e150)  # what overflows is far from zero

    answer = Answer(False, "no convergence", lengths=problem.lengths)
    with np.errstate(all="ignore"):
        for _, wrenches in single_shooting.starts(problem):
            try:
                found = least_squares(scaled, wrenches.ravel() / unit)
            except GaveUp:
                answer.outcome = "gave up"
                return answer
            answer.iterations += int(found.nfev)
            answer.residual = float(np.abs(found.fun).max())
            answer.wrenches = (unit * found.x).reshape(-1, 6)
            answer.plates = np.tile(np.eye(4), (problem.plates, 1, 1))
            for j, (origin, axes) in enumerate(algorithm.residual(problem, None, all_unknowns(found.x), steps)[1]):
                answer.plates[j, :3, 3], answer.plates[j, :3, :3] = origin, axes
            # A minimum of the squares need not be a root.
            if found.success and answer.residual <= 1e-5:
                answer.converged, answer.outcome = True, "converged"
                break
    return answer
