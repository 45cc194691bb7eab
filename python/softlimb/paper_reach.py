"""The paper's Algorithm 1 as a way to reach a pose: lengths of the rods first, pressures from them."""

from __future__ import annotations

import dataclasses
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb.limb import Limb
from softlimb.paper import algorithm
from softlimb.paper.problem import Problem, condition
from softlimb.posture import Posture
from softlimb.reach import Reach, bounds_of, reach, target_of
from softlimb.sweep import rotation_vector
from softlimb.units import kPa

__all__ = ["PaperReach", "reach_by_paper"]

Array = NDArray[np.float64]

_MOST_ITERATIONS = 30  # from near enough it takes one to ten
_STEPS = 64  # of RK4 a rod, whose end then errs by some 5e-8
_SHARPER = 1e-2  # residuals of 1e-6 leave up to 1e-5 rad: a tip is soft against twist
_SHORTEST_PRESSURE = 1.0 * kPa  # of its start: a tube can be lengthened, and near its own length not shortened


class PaperReach(Reach):
    """What Algorithm 1 found. As a `Reach`, with the lengths that came before the pressures.

    ``status`` is converged, no_progress or max_iterations, of the algorithm; ``iterations`` are its own. ``reached``
    asks for more: that the posture of the lengths succeeds, is stable, ends at the target, and needs no pressure
    outside the bounds. Where the algorithm fails, ``posture`` and ``pressures`` are the nearest of the search it
    started from, if there was one; ``lengths``, ``wrenches`` and ``residual`` stay the algorithm's.
    """

    lengths: Array
    """Rest lengths of the rods [m], shape (R,)."""
    wrenches: Array
    """Internal force and moment at the rods' bases [N], [N m], shape (R, 6)."""
    residual: float
    """Norm of the residuals in SI units; 1e-6 is asked for."""
    unknowns: int
    residuals: int
    rank: int
    """Of the derivatives of the residuals, without units: 60 of 63 for three segments of three."""
    condition: float
    """Largest over smallest of the singular values that count for the rank."""

    def __init__(self, values: dict[str, Any]) -> None:
        # Everything is known already: what a Reach would read out of the core.
        self.__dict__.update(values, _found=None)

    @property
    def _outcome(self) -> str:
        return "reached"

    @cached_property
    def message(self) -> str:
        """Outcome in words; where the algorithm failed, that comes first."""
        if self.status != "converged":
            return "; ".join([*self.remarks, f"the posture misses by {self._miss}"])
        family = f"rank {self.rank} of {self.unknowns} unknowns"
        if self.rank < self.unknowns:
            family += f": one of a family of answers with {self.unknowns - self.rank} parameters"
        return f"{super().message}; {family}"


def reach_by_paper(
    limb: Limb,
    *,
    pose: ArrayLike,
    max_pressure: Any,
    min_pressure: Any = 0.0,
    tolerance: float = 1e-6,
    start: Posture | Reach | None = None,
    **scene: Any,
) -> PaperReach:
    """See `Limb.reach` with ``method="paper"``."""
    target, weights = target_of(None, pose, None)
    lower, upper, limited = bounds_of(limb, min_pressure, max_pressure)
    counts = {len(segment.actuators) for segment in limb.segments}
    if len(counts) != 1 or 0 in counts or any(segment.rods for segment in limb.segments):
        raise ValueError("Algorithm 1 needs as many actuators in each segment, got segments of " + str(limb._counts))
    if scene.setdefault("section", "paper") != "paper":
        raise ValueError(f'Algorithm 1 has constant sections: section must be "paper", got {scene["section"]!r}')
    unloaded = limb.solve(np.zeros(len(limb._tubes)), tolerance=tolerance, **scene)
    searched = start is None
    if start is None:
        # From afar the algorithm seldom converges (MECHANICS): it starts where the search ends.
        start = reach(
            limb,
            pose=target,
            max_pressure=upper,
            min_pressure=np.clip(_SHORTEST_PRESSURE, lower, upper),
            tolerance=max(tolerance, 1e-4),
            **scene,
        )
    first = start.posture if isinstance(start, Reach) else start
    limb._start(first)
    problem = _problem(unloaded)
    answer = algorithm.solve(
        problem,
        target,
        first.rest_lengths,
        start_wrenches=_wrenches(first),
        limit=np.inf,
        most_iterations=_MOST_ITERATIONS,
        steps=_STEPS,
        tolerance=_SHARPER * tolerance,
    )
    posture = _posture_of(limb, answer.lengths, first, tolerance, scene)
    pressures = posture._solved_pressures
    nowhere = not (answer.converged and posture.success and posture.stable)
    if pressures is None or posture.status == "limit_point":
        pressures = np.full(len(limb._tubes), np.nan)
    # Rounding of a pressure that belongs to a length.
    allowed = 1e-6 * np.maximum(np.abs(lower), np.abs(upper))
    outside = ~((pressures >= lower - allowed) & (pressures <= upper + allowed))
    if nowhere and searched and first.success and first.stable and first._solved_pressures is not None:
        posture, pressures = first, first._solved_pressures
    gap = _gap_between(posture.tip, target)
    near = np.linalg.norm(gap[:3]) <= tolerance * limb.length and np.linalg.norm(gap[3:]) <= tolerance
    unknown = np.concatenate([answer.lengths, answer.wrenches.ravel()])
    with np.errstate(all="ignore"):
        jacobian = algorithm.scaled_jacobian(problem, target, unknown)
    _, rank = condition(jacobian)
    values = np.linalg.svd(jacobian, compute_uv=False) if rank else np.full(1, np.inf)
    ended = "ended" if answer.converged else "did not converge, and ended"
    remarks = [f"Algorithm 1 {ended} with a residual of {answer.residual:.1e}: {answer.outcome}"]
    if outside.any():
        numbers = ", ".join(str(number) for number in np.flatnonzero(outside))
        remarks.append(f"its lengths need pressures outside the bounds, or that no tube has, in actuators {numbers}")
    if posture is first:
        remarks.append("posture and pressures are the nearest of the search before it")
    statuses = {"converged": "converged", "no convergence": "max_iterations", "gave up": "max_iterations"}
    return PaperReach(
        {
            "_limb": limb,
            "_limited": limited,
            "posture": posture,
            "pressures": pressures,
            "reached": bool(not nowhere and near and not outside.any()),
            "target": target,
            "weights": weights,
            "gap": gap,
            "min_pressures": lower,
            "max_pressures": upper,
            "least": False,
            "status": statuses.get(answer.outcome, "no_progress"),
            "iterations": answer.iterations,
            "starts": 0,
            "remarks": tuple(remarks),
            "lengths": answer.lengths,
            "wrenches": answer.wrenches,
            "residual": answer.residual,
            "unknowns": jacobian.shape[1],
            "residuals": jacobian.shape[0],
            "rank": rank,
            "condition": float(values[0] / values[rank - 1]),
        }
    )


def _problem(unloaded: Posture) -> Problem:
    """Constant sections and loads; weights of the rods stay while their lengths change."""
    rods = [rod for row in unloaded.rods for rod in row]
    masses = np.array([rod.section.mass_per_length * rod.length for rod in rods])
    return dataclasses.replace(
        Problem.of(unloaded),
        line_force=unloaded.loads["rod_forces"].reshape(-1, 3),
        spread_force=masses[:, None] * unloaded.loads["gravity"],
    )


def _wrenches(posture: Posture) -> Array:
    return np.array([rod.base_wrench for row in posture.rods for rod in row])


def _posture_of(limb: Limb, lengths: Array, start: Posture, tolerance: float, scene: dict[str, Any]) -> Posture:
    """The posture of the lengths found; where they are no lengths, that of the start."""
    if not (np.isfinite(lengths).all() and (lengths > 0.0).all()):
        return start
    return limb.solve(rest_lengths=lengths, start=start, tolerance=max(0.1 * tolerance, 1e-12), **scene)


def _gap_between(pose: Array, target: Array) -> Array:
    """Position of a pose minus that of the target [m], and the rotation vector from the target [rad], shape (6,)."""
    turn = np.eye(4)
    turn[:3, :3] = pose[:3, :3] @ target[:3, :3].T
    return np.concatenate([pose[:3, 3] - target[:3, 3], rotation_vector(turn)])
