"""Other ways to the same postures, timed beside the package's own.

Each method gets sections, rest lengths and loads of the package's posture and starts from nothing. An answer is
compared with ours, which an independent integration has verified, before it is timed; one that is wrong, or that does
not come within the limit, is not timed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softlimb import presets
from softlimb.bench import checks, limbs
from softlimb.bench.clock import Clock, Samples, quartiles, seconds_of
from softlimb.bench.methods import collocation, elastica, least_squares, single_shooting
from softlimb.limb import Limb, Rod, Segment
from softlimb.paper import algorithm
from softlimb.paper.problem import Answer, Problem
from softlimb.posture import Posture
from softlimb.units import kPa, ms

__all__ = ["INSTALL", "SCENES", "Outcome", "Scene", "at_lengths", "by_paper", "compare"]

Array = NDArray[np.float64]

RIGHT_WITHIN = 1e-4
"""Distance between two tips, over the limb's length, of answers that agree."""
SIMULATED_WITHIN = 2e-3
"""The same for PyElastica; `methods.elastica` says why."""


@dataclass(frozen=True)
class Scene:
    """What all methods solve; ``options`` are arguments of `Limb.solve`."""

    name: str
    what: str
    limb: Callable[[], Limb]
    options: dict[str, Any]


SCENES = (
    Scene(
        "other-rod",
        "one hanging rod, force across",
        lambda: limbs.clamped(limbs.soft_rod()),
        {"gravity": limbs.HANGING, "tip_force": (0.03, 0.02, 0.0)},
    ),
    Scene(
        "other-segment",
        "one segment of 3 rods, 40/20/0 kPa",
        lambda: presets.reference_limb(["proximal"]),
        {"pressures": np.array([40.0, 20.0, 0.0]) * kPa, **limbs.loads()},
    ),
    Scene(
        "other-mild-limb",
        "limb of 9 rods, pressures nearly equal (24 to 30 kPa)",
        presets.reference_limb,
        {"pressures": np.array([30.0, 28.0, 26.0, 24.0, 26.0, 28.0, 30.0, 28.0, 29.0]) * kPa, **limbs.loads()},
    ),
    Scene(
        "other-limb",
        "limb of 9 rods, pressures apart (10 to 30 kPa)",
        presets.reference_limb,
        {"pressures": np.array([30.0, 20.0, 10.0, 20.0, 25.0, 15.0, 25.0, 20.0, 10.0]) * kPa, **limbs.loads()},
    ),
)


@dataclass(frozen=True)
class Method:
    """Another way: ``solve(posture, limit)`` finds an answer from what the posture was asked."""

    name: str
    solve: Callable[[Posture, float], Answer]
    within: float = RIGHT_WITHIN
    needs: str | None = None  # a module that may be missing
    finds_lengths: bool = False  # at the tip's pose, instead of the pose at lengths
    applies: Callable[[Posture], bool] = lambda _: True
    compiles: bool = False  # at its first call


def by_paper(posture: Posture, limit: float) -> Answer:
    """The paper's algorithm on a posture's sections, loads and tip pose."""
    # What is known before the lengths are: how long a segment is without pressure.
    rests = np.concatenate([[segment.length] * len(segment.members) for segment in posture.limb])
    return algorithm.solve(Problem.of(posture), posture.tip, rests, limit)


def _by_elastica(posture: Posture, limit: float) -> Answer:
    (rod,) = posture.limb.segments[0].rods
    return elastica.solve(rod, posture.loads["tip_force"], posture.loads["gravity"], limit)


def _is_one_rod(posture: Posture) -> bool:
    return [len(segment.rods) for segment in posture.limb] == [1]


METHODS = (
    Method("scipy solve_bvp", lambda p, limit: collocation.solve(Problem.of(p), limit), needs="scipy"),
    Method("scipy least_squares, shooting", lambda p, limit: least_squares.solve(Problem.of(p), limit), needs="scipy"),
    Method("Newton, shooting in numpy", lambda p, limit: single_shooting.solve(Problem.of(p), limit)),
    Method("the paper's algorithm", by_paper, finds_lengths=True),
    Method(
        "PyElastica, relaxed",
        _by_elastica,
        within=SIMULATED_WITHIN,
        needs="elastica",
        applies=_is_one_rod,
        compiles=True,
    ),
)


@dataclass(frozen=True)
class Outcome:
    """A method on a scene: ``outcome`` in a few words, ``detail`` in more, times where the answer is right."""

    scene: str
    method: str
    outcome: str
    detail: str = ""
    off: float | None = None  # distance of the tips over the limb's length
    samples: Samples | None = None
    ours: float | None = None  # median time of our own solve [s]

    @property
    def times_ours(self) -> float | None:
        """How many of our own solves fit into one of these."""
        if self.samples is None or self.ours is None:
            return None
        return quartiles(self.samples.seconds)[1] / self.ours

    def to_dict(self) -> dict[str, Any]:
        """Everything, raw samples included, for a JSON file."""
        known: dict[str, Any] = {"scene": self.scene, "method": self.method, "outcome": self.outcome}
        known |= {} if not self.detail else {"detail": self.detail}
        known |= {} if self.off is None or not np.isfinite(self.off) else {"tip_off": self.off}
        if self.samples is None:
            return known
        low, middle, high = quartiles(self.samples.seconds)
        return known | {
            "median_ms": middle / ms,
            "quartiles_ms": [low / ms, high / ms],
            "ratio_to_yardstick": quartiles(self.samples.ratios)[1],
            "times_ours": self.times_ours,
            "seconds": self.samples.seconds.tolist(),
            "yardstick_seconds": self.samples.yardsticks.tolist(),
        }


def compare(scene: Scene, clock: Clock, limit: float, compiled: bool = True) -> Iterator[Outcome]:
    """Our own outcome on a scene, then those of the other methods.

    Parameters
    ----------
    limit : float
        Time for one solve of another method [s].
    compiled : bool
        False leaves methods out that compile themselves first, which takes them longer than all else here.
    """
    limb = scene.limb()
    posture = limb.solve(**scene.options)
    fault = checks.posture_fault(posture, limb.solve(**scene.options, tolerance=1e-9))
    if fault is not None:
        yield Outcome(scene.name, "softlimb", "wrong", fault)
        return
    samples = clock.in_turn({"ours": lambda: seconds_of(lambda: limb.solve(**scene.options))})["ours"]
    ours = quartiles(samples.seconds)[1]
    yield Outcome(scene.name, "softlimb", "right, verified", samples=samples, ours=ours)
    for method in METHODS:
        if not method.applies(posture):
            continue
        if method.needs is not None and find_spec(method.needs) is None:
            yield Outcome(scene.name, method.name, "left out", f"{method.needs} is missing: {INSTALL}")
        elif method.compiles and not compiled:
            yield Outcome(scene.name, method.name, "left out by --quick")
        else:
            yield _outcome(scene, method, posture, clock, limit, ours)


INSTALL = "pip install 'softlimb[bench]'"
"""What brings the modules that other methods need."""


def _outcome(scene: Scene, method: Method, posture: Posture, clock: Clock, limit: float, ours: float) -> Outcome:
    if method.compiles:
        method.solve(posture, 1e-3)
    first, answer = clock.once(lambda: method.solve(posture, limit))
    if not answer.converged:
        text = f"gave up after {limit:.3g} s" if answer.outcome == "gave up" else answer.outcome
        detail = f"after {answer.iterations} iterations" if answer.iterations else ""
        return Outcome(scene.name, method.name, text, detail)
    fault, off, remark = answer_fault(method, answer, posture)
    if fault is not None:
        return Outcome(scene.name, method.name, "wrong", fault, off)
    if first.seconds[0] < clock.budget:
        again = {method.name: lambda: seconds_of(lambda: method.solve(posture, limit))}
        first = clock.in_turn(again, (3, 50), warm_up=False)[method.name]
    return Outcome(scene.name, method.name, "right" + remark, off=off, samples=first, ours=ours)


def answer_fault(method: Method, answer: Answer, posture: Posture) -> tuple[str | None, float, str]:
    """What is wrong with the answer of another method, its distance from ours over the limb's length, and a remark.

    Where a method finds lengths at a given tip, what counts is where a limb of these lengths has its tip: several sets
    of lengths may lead there.
    """
    length, remark = posture.limb.length, ""
    tip = answer.plates[-1]
    if method.finds_lengths:
        there = at_lengths(posture, answer)
        if not (there.success and there.verify().success):
            return f"no equilibrium at its lengths: {there.message}", float("nan"), ""
        tip = there.tip
        if np.abs(answer.lengths - posture.rest_lengths).max() > method.within * length:
            remark = ", other lengths"
    off = float(np.linalg.norm(tip[:3, 3] - posture.tip[:3, 3])) / length
    fault = checks.distance_fault(tip[:3, 3], posture.tip[:3, 3], method.within * length)
    return fault, off, remark


def at_lengths(posture: Posture, answer: Answer) -> Posture:
    """The equilibrium near an answer: its lengths, the posture's sections and loads."""
    lengths, segments = iter(answer.lengths), []
    for segment, row in zip(posture.limb, posture.rods, strict=True):
        rods = [Rod(rod.section, abs(float(next(lengths)))) for rod in row]
        base, end = segment.base_frames, segment.end_frames
        segments.append(Segment(rods=rods, base_frames=base, end_frames=end, plate=segment.plate))
    loads = {name: posture.loads[name] for name in ("gravity", "tip_force", "tip_moment")}
    return Limb(segments).solve(start=answer.plates, prefer_stable=False, **loads)
