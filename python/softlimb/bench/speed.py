"""The package's own times against what is asked of them.

Each question is asked of the package as a user asks it ("Python"), and once more by the calls into the compiled core
that this makes ("C++"): see `core_calls`. Answers are checked before they are timed.
"""

from __future__ import annotations

import functools
import itertools
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softlimb import presets
from softlimb.bench import checks, limbs
from softlimb.bench.clock import Clock, Samples, quartiles, seconds_of, stopwatch
from softlimb.bench.core_calls import CoreCalls
from softlimb.posture import Posture
from softlimb.units import mm, ms, us

__all__ = ["ENTRIES", "Effort", "Entry", "Goal", "Row"]

Array = NDArray[np.float64]

_SEED = 20261122
_WRONG = "wrong: "
# As long as a reading of the yardstick: on a busy machine a shorter sample would meet other interruptions than that.
_SHORTEST_SAMPLE = 13 * ms


@dataclass(frozen=True)
class Effort:
    """How much work a run puts in.

    Parameters
    ----------
    steps : int
        Solves of a walk that is timed as one.
    cold : int
        Random scenes solved from nothing.
    sweep_rows : int
        Rows of a sweep in one call, about as many of a grid: a long one surveys some of its rows first.
    limit : float
        Time for one solve of another method [s].
    """

    steps: int = 40
    cold: int = 100
    sweep_rows: int = 100_000
    limit: float = 20.0


@dataclass(frozen=True)
class Goal:
    """What is asked of a figure, and what would be good; in ``unit``: "Y" (yardsticks), "us", "solve", "times"."""

    asked: float
    aim: float
    unit: str = "Y"

    @property
    def at_least(self) -> bool:
        """True where more is better."""
        return self.unit == "times"

    def met(self, value: float) -> str:
        """ "aim", "yes" or "no"."""
        reached = [value >= goal if self.at_least else value <= goal for goal in (self.aim, self.asked)]
        return "aim" if reached[0] else "yes" if reached[1] else "no"


@dataclass(frozen=True)
class Row:
    """One line of the table: figures, or in ``remark`` why there are none."""

    name: str
    what: str
    way: str
    goal: Goal
    samples: Samples | None = None
    values: Array | None = None  # in the goal's unit, where that is no ratio to the yardstick
    remark: str = ""
    parts: dict[str, tuple[float, float]] = field(default_factory=dict)  # of the core: calls, seconds; of one solve

    @property
    def wrong(self) -> bool:
        """True where a check refused the answer."""
        return self.remark.startswith(_WRONG)

    @property
    def figures(self) -> Array:
        """Samples in the goal's unit."""
        assert self.samples is not None
        return self.samples.ratios if self.values is None else self.values

    @property
    def value(self) -> float:
        """Their median."""
        return quartiles(self.figures)[1]

    def to_dict(self) -> dict[str, Any]:
        """Everything, raw samples included, for a JSON file."""
        known: dict[str, Any] = {
            "name": self.name,
            "what": self.what,
            "way": self.way,
            "unit": self.goal.unit,
            "asked": self.goal.asked,
            "aim": self.goal.aim,
        }
        if self.samples is None:
            return known | {"remark": self.remark}
        low, middle, high = quartiles(self.samples.seconds)
        return known | {
            "value": self.value,
            "met": self.goal.met(self.value),
            "median_us": middle / us,
            "quartiles_us": [low / us, high / us],
            "ratio_to_yardstick": quartiles(self.samples.ratios)[1],
            "seconds": self.samples.seconds.tolist(),
            "yardstick_seconds": self.samples.yardsticks.tolist(),
            **({} if self.values is None else {"values": self.values.tolist()}),
            **({} if not self.parts else {"calls_and_us": {k: [n, t / us] for k, (n, t) in self.parts.items()}}),
        }


@dataclass(frozen=True)
class Question:
    """Solves that are asked for again and again.

    Parameters
    ----------
    walks : sequence of callables
        Each asks for ``solves`` solves and returns the answers; its time is one sample.
    fault : callable
        What is wrong with the answers of all walks, or None.
    """

    walks: Sequence[Callable[[], Sequence[Any]]]
    fault: Callable[[Sequence[Sequence[Any]]], str | None]
    solves: int

    def timed(self, walks: Sequence[Callable[[], Any]], shortest: float = 0.0) -> Array:
        """Seconds of a solve in each walk, repeated until it takes the shortest time of a sample [s]."""
        seconds = np.empty(len(walks))
        for number, run in enumerate(walks):
            seconds[number] = seconds_of(run, shortest) / self.solves
        return seconds


@dataclass(frozen=True)
class Entry:
    """A row of the table before it is measured."""

    name: str
    what: str
    goal: Goal
    measure: Callable[[Entry, Clock, Effort], Iterator[Row]] = field(repr=False)

    def row(self, way: str, samples: Samples, values: Array | None = None, **more: Any) -> Row:
        """With figures."""
        return Row(self.name, self.what, way, self.goal, samples, values, **more)

    def without(self, way: str, remark: str) -> Row:
        """Without figures, and why."""
        return Row(self.name, self.what, way, self.goal, remark=remark)


def both_ways(question: Callable[[Effort], Question]) -> Callable[[Entry, Clock, Effort], Iterator[Row]]:
    """Rows of a question with and without the Python call."""

    def measure(entry: Entry, clock: Clock, effort: Effort) -> Iterator[Row]:
        asked = question(effort)
        fault, calls = _prepared(asked)
        if fault is not None:
            yield entry.without("C++", fault)
            return
        samples = clock.in_turn(_ways(asked, calls))
        fault = checks.first(call.fault() for call in calls)
        if fault is None:
            yield entry.row("C++", samples["C++"], parts=_parts(asked, calls))
        else:
            yield entry.without("C++", fault)
        yield entry.row("Python", samples["Python"])

    return measure


def _prepared(question: Question) -> tuple[str | None, list[CoreCalls]]:
    """The answers checked, and the calls of the core behind them."""
    fault = question.fault([walk() for walk in question.walks])
    return (_WRONG + fault, []) if fault is not None else (None, [CoreCalls.of(walk) for walk in question.walks])


def _ways(question: Question, calls: Sequence[CoreCalls]) -> dict[str, Callable[[], Array]]:
    # Single solves stay as they are: a scene solved again at once would find all that it needs in the caches.
    shortest = _SHORTEST_SAMPLE if question.solves > 1 else 0.0
    return {
        "C++": lambda: question.timed([call.again for call in calls], shortest),
        "Python": lambda: question.timed(question.walks, shortest),
    }


def _parts(question: Question, calls: Sequence[CoreCalls]) -> dict[str, tuple[float, float]]:
    """Calls of each function of the core and their seconds, of one solve."""
    names = sorted({name for call in calls for name in call.counts()})
    solves = question.solves * len(calls)
    parts = {}
    for name in names:
        alike = [call.only(name) for call in calls]
        seconds = [float(question.timed([part.again for part in alike]).mean()) for _ in range(3)]
        parts[name] = sum(len(part.calls) for part in alike) / solves, min(seconds)
    return parts


# --- the questions -------------------------------------------------------------------------------------------------


def warm(
    segments: Sequence[str] = presets.REFERENCE_SEGMENTS, asked: Callable[[Posture], Any] = lambda _: None
) -> Callable[[Effort], Question]:
    """A walk of pressures on the reference limb or part of it, each solve from the posture before it.

    ``asked`` is what each posture is asked for before the next solve.
    """

    def question(effort: Effort) -> Question:
        limb = presets.reference_limb(segments)
        rows = limbs.walk(effort.steps, 3 * len(limb), _SEED)
        loads = limbs.loads()
        before = limb.solve(rows[0], **loads)

        def ask() -> list[Posture]:
            found, posture = [], before
            for row in rows[1:]:
                posture = limb.solve(row, start=posture, **loads)
                asked(posture)
                found.append(posture)
            return found

        def fault(answers: Sequence[Sequence[Posture]]) -> str | None:
            sample = {0: 0, len(answers[0]) // 2: 0, len(answers[0]) - 1: 0}
            cold = ((answers[0][k], limb.solve(rows[1 + k], tolerance=1e-9, **loads)) for k in sample)
            return checks.first(itertools.chain((_failed(p) for p in answers[0]), (_pair(pair) for pair in cold)))

        return Question([ask], fault, effort.steps)

    return question


def _failed(posture: Posture) -> str | None:
    return None if posture.success and posture.stable else posture.message


def _pair(pair: tuple[Posture, Posture]) -> str | None:
    return checks.posture_fault(*pair)


def cold(effort: Effort) -> Question:
    """Random pressures from nothing, each scene a sample of its own."""
    limb, loads = presets.reference_limb(), limbs.loads()
    rows = limbs.random_pressures(effort.cold, 9, _SEED)

    def fault(answers: Sequence[Sequence[Posture]]) -> str | None:
        return checks.first(checks.posture_fault(posture) for (posture,) in answers)

    return Question([lambda row=row: [limb.solve(row, **loads)] for row in rows], fault, 1)  # type: ignore[misc]


_LIFT, _LIFT_ERROR = 1.4 * mm, 1e-7


def six_legs(effort: Effort) -> Question:
    """New lengths of six legs, each of which lifts the platform by 1.4 mm, from the posture before."""
    limb = limbs.six_legs([limbs.LEG] * 6, limbs.HEAVY_STEEL)
    options: dict[str, Any] = {"gravity": limbs.HANGING, "tip_force": (3.0, -2.0, -20.0)}

    def solved(length: float, tolerance: float, start: Posture | None = None) -> Posture:
        return limb.solve(rest_lengths=np.full(6, length), tolerance=tolerance, start=start, **options)

    steps = min(effort.steps, 10)  # to 14 mm
    before = solved(limbs.LEG, 1e-11)
    lengths: list[float] = []
    truths = [before]
    for _ in range(steps):
        # By secants: the height grows by about 1.03 of the lengths.
        goal = truths[-1].tip[2, 3] + _LIFT
        length, posture = (lengths or [limbs.LEG])[-1] + _LIFT, truths[-1]
        for _ in range(8):
            posture = solved(length, 1e-11, posture)
            length += goal - posture.tip[2, 3]
        lengths.append(length)
        truths.append(solved(length, 1e-11, posture))

    tolerance = _LIFT_ERROR / limb.length

    def ask() -> list[Posture]:
        found, posture = [], before
        for length in lengths:
            posture = solved(length, tolerance, posture)
            found.append(posture)
        return found

    def fault(answers: Sequence[Sequence[Posture]]) -> str | None:
        def one(posture: Posture, truth: Posture, below: Posture) -> str | None:
            if abs(truth.tip[2, 3] - below.tip[2, 3] - _LIFT) > 0.1 * _LIFT_ERROR:
                return "the lengths do not lift the platform by 1.4 mm"
            near = checks.distance_fault(posture.tip[:3, 3], truth.tip[:3, 3], _LIFT_ERROR, "the platform")
            return checks.posture_fault(posture) or near

        return checks.first(itertools.starmap(one, zip(answers[0], truths[1:], truths[:-1], strict=True)))

    return Question([ask], fault, steps)


def cantilever(effort: Effort) -> Question:
    """A rod of silicone under its weight and a tip force that changes, to 1e-8 of its length, from nothing."""
    from softlimb.bench.methods import single_shooting
    from softlimb.paper.problem import Problem

    rod = limbs.soft_rod()
    forces = [0.04 * np.array([np.cos(a), np.sin(a), 0.5]) for a in np.linspace(0.0, 1.0, effort.steps)]

    def ask() -> list[Any]:
        return [rod.cantilever(tip_force=force, gravity=limbs.HANGING, tolerance=1e-8) for force in forces]

    def fault(answers: Sequence[Sequence[Any]]) -> str | None:
        posture = answers[0][0].posture
        # Shooting in numpy by RK4: 200 steps of a rod that bends by less than a radian err by 1e-12 of its length.
        shot = single_shooting.refine(Problem.of(posture), single_shooting.solve(Problem.of(posture)))
        return (
            checks.first(checks.posture_fault(found.posture) for found in answers[0])
            or (None if shot.converged else "shooting does not confirm it")
            or checks.distance_fault(posture.tip[:3, 3], shot.plates[0, :3, 3], 1e-7 * rod.length)
        )

    return Question([ask], fault, effort.steps)


def tube_states(effort: Effort) -> Question:
    """States at pressures 1 % apart, all in one call over an array: the call itself is divided away."""
    tube = presets.reference_limb().segments[0].actuators[0]
    pressures = limbs.zigzag(50 * effort.steps)

    def fault(answers: Sequence[Sequence[Any]]) -> str | None:
        return checks.state_fault(tube, answers[0][0])

    return Question([lambda: [tube.inflate(pressures)]], fault, len(pressures))


def tube_sections(effort: Effort) -> Question:
    """What a rod of the limb needs of its tube: section and rest length at the next pressure."""
    tube = presets.reference_limb().segments[0].actuators[0]
    pressures = limbs.zigzag(effort.steps).tolist()

    def fault(answers: Sequence[Sequence[Any]]) -> str | None:
        pairs = [(pressures[k], answers[0][k]) for k in (0, effort.steps - 1)]
        return checks.first(checks.section_fault(tube, pressure, section) for pressure, section in pairs)

    return Question([lambda: [tube.section(p) for p in pressures]], fault, len(pressures))


# --- rows that are no plain question -------------------------------------------------------------------------------


def python_call(entry: Entry, clock: Clock, effort: Effort) -> Iterator[Row]:
    """A warm solve of nine rods less its calls of the core."""
    question = warm()(effort)
    fault, calls = _prepared(question)
    fault = fault or checks.first(call.fault() for call in calls)
    if fault is not None:
        yield entry.without("", fault)
        return
    samples = clock.in_turn(_ways(question, calls))
    rest = samples["Python"].less(samples["C++"])
    yield entry.row("", rest, rest.seconds / us)


def jacobian(entry: Entry, clock: Clock, effort: Effort) -> Iterator[Row]:
    """What a walk takes longer that asks each posture for its Jacobian, over what it takes without."""
    questions = warm()(effort), warm(asked=lambda posture: posture.jacobian)(effort)
    prepared = [_prepared(question) for question in questions]
    fault = checks.first(found for found, _ in prepared) or _jacobian_fault(questions[1])
    if fault is not None:
        yield entry.without("C++", fault)
        return
    ways: dict[str, list[Callable[[], Any]]] = {
        "C++": [calls[0].again for _, calls in prepared],
        "Python": [question.walks[0] for question in questions],
    }
    samples = clock.in_turn({way: functools.partial(_alternately, walks, effort.steps) for way, walks in ways.items()})
    for way, found in samples.items():
        fault = checks.first(call.fault() for _, calls in prepared for call in calls) if way == "C++" else None
        solve, both = found.seconds[0::2], found.seconds[1::2]
        rest = Samples(both - solve, found.yardsticks[0::2])
        yield entry.row(way, rest, rest.seconds / solve) if fault is None else entry.without(way, fault)


def _alternately(walks: Sequence[Callable[[], Any]], solves: int) -> Array:
    """Seconds of a solve in each walk. In turn, walk by walk: their difference is smaller than a machine's whims."""
    seconds, rounds = np.zeros(len(walks)), 0
    while seconds.sum() < len(walks) * _SHORTEST_SAMPLE:
        seconds += [seconds_of(walk) for walk in walks]
        rounds += 1
    return seconds / (rounds * solves)


def _jacobian_fault(question: Question) -> str | None:
    (walk,) = question.walks
    fault = checks.jacobian_fault(walk()[-1])
    return None if fault is None else _WRONG + fault


class _Sweeps:
    """One sweep, called again and again."""

    def __init__(self, pressures: Array, options: dict[str, Any]) -> None:
        self.limb, self.loads = presets.reference_limb(), limbs.loads()
        self.pressures, self.options = pressures, options
        self.failed = 0

    def run(self, **options: Any) -> Any:
        return self.limb.sweep(self.pressures, progress=False, **{**self.loads, **self.options, **options})

    def fault(self) -> str | None:
        return checks.batch_fault(self.limb, self.run(), self.loads)

    def timed(self, **options: Any) -> Callable[[], float]:
        def run() -> float:
            with stopwatch() as elapsed:
                batch = self.run(**options)
                seconds = elapsed() / len(self.pressures)
            self.failed += int((~batch.success).sum())
            return seconds

        return run

    def finished(self) -> str | None:
        return f"{_WRONG}{self.failed} rows failed while they were timed" if self.failed else None


_SWEEP_ROUNDS = (1, 3)
"""How often a sweep is timed: once, again where time allows; its check has warmed up."""


def _random_rows(options: dict[str, Any], effort: Effort) -> _Sweeps:
    return _Sweeps(limbs.random_pressures(effort.sweep_rows, 9, _SEED), options)


def random_sweep(entry: Entry, clock: Clock, effort: Effort) -> Iterator[Row]:
    """Random pressures on one thread, each row on its own."""
    yield _swept(entry, _random_rows({"threads": 1}, effort), clock)


def grid_sweep(entry: Entry, clock: Clock, effort: Effort) -> Iterator[Row]:
    """A fine grid on one thread, where a row may start from its neighbour."""
    sweeps = _Sweeps(limbs.fine_grid(effort.sweep_rows, 3), {"threads": 1, "ordered": True})
    yield _swept(entry, sweeps, clock)


def _swept(entry: Entry, sweeps: _Sweeps, clock: Clock) -> Row:
    fault = sweeps.fault()
    if fault is not None:
        return entry.without("Python", _WRONG + fault)
    samples = clock.in_turn({"sweep": sweeps.timed()}, _SWEEP_ROUNDS, warm_up=False)["sweep"]
    late = sweeps.finished()
    return entry.row("Python", samples) if late is None else entry.without("Python", late)


def two_threads(entry: Entry, clock: Clock, effort: Effort) -> Iterator[Row]:
    """The same sweep on one thread and on two: the same bits, in how much less time."""
    if (os.cpu_count() or 1) < 2:
        yield entry.without("Python", "skipped: this machine has one core")
        return
    sweeps = _random_rows({}, effort)
    one, two = (sweeps.run(threads=threads) for threads in (1, 2))
    fault = checks.same_bits_fault(one, two) or checks.batch_fault(sweeps.limb, two, sweeps.loads)
    if fault is not None:
        yield entry.without("Python", _WRONG + fault)
        return
    ways = {"1": sweeps.timed(threads=1), "2": sweeps.timed(threads=2)}
    samples = clock.in_turn(ways, _SWEEP_ROUNDS, warm_up=False)
    late = sweeps.finished()
    values = samples["1"].seconds / samples["2"].seconds
    yield entry.row("Python", samples["2"], values) if late is None else entry.without("Python", late)


ENTRIES = (
    Entry("warm", "limb of 9 rods, warm, with sections", Goal(15.0, 8.0), both_ways(warm())),
    Entry("cold", "limb of 9 rods, cold", Goal(80.0, 40.0), both_ways(cold)),
    Entry("segment", "segment of 3, warm, with sections", Goal(5.0, 3.0), both_ways(warm(["proximal"]))),
    Entry("six-legs", "six steel legs, lifted by 1.4 mm", Goal(10.0, 6.0), both_ways(six_legs)),
    Entry("cantilever", "one cantilever to 1e-8", Goal(2.0, 1.0), both_ways(cantilever)),
    Entry("tube", "tube, state at the next pressure", Goal(2.0, 0.5), both_ways(tube_states)),
    Entry("section", "tube, section at the next pressure", Goal(2.0, 0.5), both_ways(tube_sections)),
    Entry("sweep", "sweep of random rows, a row, 1 thread", Goal(20.0, 8.0), random_sweep),
    Entry("grid", "ordered sweep of a fine grid, a row", Goal(8.0, 4.0), grid_sweep),
    Entry("jacobian", "Jacobian to pressures, over its solve", Goal(0.2, 0.1, "solve"), jacobian),
    Entry("python", "Python call on top of a warm solve", Goal(5.0, 2.0, "us"), python_call),
    Entry("threads", "sweep on 2 threads against 1", Goal(1.9, 1.9, "times"), two_threads),
)
"""The table's rows in their order."""
