"""The outer loop: where the tip is wanted -> pressures -> plant -> posture -> where the tip is seen -> correction.

The paper names such a loop (its Algorithm 2) and does not print it; this one is ours.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb.arguments import (
    finite_of_shape,
    function,
    of_type,
    one_finite,
    one_not_negative,
    one_of,
    one_positive,
    one_whole,
    real_array,
    truth,
)
from softlimb.control.controllers import PID, NeuralPID
from softlimb.control.loop import Fault, Guard, PressureLoop, Trace
from softlimb.control.pneumatics import Pneumatics
from softlimb.control.tasks import Task
from softlimb.control.true_limb import Perturbation, TrueLimb
from softlimb.control.tuning import learning_from, simc
from softlimb.limb import Limb
from softlimb.posture import Posture
from softlimb.reach import STARTS, Reach
from softlimb.sweep import rotation_matrix
from softlimb.units import deg, kPa, mm, ms

__all__ = ["Incident", "PoseSensor", "PostureControl", "PostureRun", "TipErrors", "run_task"]

Array = NDArray[np.float64]

_POSE_FAULTS = ("none", "not_finite", "stuck")


@dataclass
class PoseSensor:
    """Sees the tip's pose.

    Parameters
    ----------
    position_noise : float
        Standard deviation of each coordinate [m]. Assumption: 0.5 mm, of optical tracking at an arm's length.
    rotation_noise : float
        Of each component of the rotation vector [rad]. Assumption: 0.2 degrees.
    seed : int
    fault : {"none", "not_finite", "stuck"}
        As a test sets it on its way.

    Raises
    ------
    ValueError
        Noise that is negative or not finite, a seed that is no whole number, an unknown fault.
    """

    position_noise: float = 0.5 * mm
    rotation_noise: float = 0.2 * deg
    seed: int = 0
    fault: str = "none"

    def __post_init__(self) -> None:
        self.position_noise = one_not_negative("position_noise", self.position_noise)
        self.rotation_noise = one_not_negative("rotation_noise", self.rotation_noise)
        self.seed = one_whole("seed of a PoseSensor", self.seed, 0)
        one_of("fault of a PoseSensor", self.fault, _POSE_FAULTS)
        self._rng = np.random.default_rng(self.seed)
        self._last = np.eye(4)

    def read(self, pose: Array) -> Array:
        """A reading of a pose, shape (4, 4); that of a limb which is lost holds NaN.

        Raises
        ------
        ValueError
            The pose has another shape, or ``fault`` was set to something unknown.
        """
        one_of("fault of a PoseSensor", self.fault, _POSE_FAULTS)
        pose = real_array("pose", pose)
        if pose.shape != (4, 4):
            raise ValueError(f"pose has shape {pose.shape}: expected (4, 4)")
        noise = self._rng.standard_normal(6)
        if self.fault == "not_finite":
            return np.full((4, 4), np.nan)
        if self.fault != "stuck":
            seen = pose
            seen[:3, 3] += self.position_noise * noise[:3]
            seen[:3, :3] = rotation_matrix(self.rotation_noise * noise[3:]) @ seen[:3, :3]
            self._last = seen
        return self._last


@dataclass(frozen=True)
class PostureControl:
    """How the outer loop turns a wanted place into pressures.

    Parameters
    ----------
    closed : bool
        Correct by what is seen; else the model alone leads.
    gain : float
        Share of the error that the correction takes up in a second [1/s].
    largest : float
        Correction [m]: what the model may be wrong by.
    lag : float
        How much later than wanted the tip is expected [s]: a step of the loop, which pressures take at least; what is
        late by that is no error to correct.
    period : float
        Of a step [s]; a whole number of the inner loop's.
    max_pressure, prefer : float
        Of the search for pressures [Pa]: the bound, and what they are kept near to.
    patience : float
        How long the target may be out of reach, the tip unseen, or the correction at its bound
        while the tip comes no nearer by a tenth, until control ends [s].

    Raises
    ------
    ValueError
        A number is out of range.
    """

    closed: bool = True
    gain: float = 5.0
    largest: float = 80 * mm
    lag: float = 20 * ms
    period: float = 20 * ms
    max_pressure: float = 95 * kPa
    prefer: float = 30 * kPa
    patience: float = 0.3

    def __post_init__(self) -> None:
        object.__setattr__(self, "closed", truth("closed", self.closed))
        for name in ("gain", "lag", "prefer"):
            object.__setattr__(self, name, one_not_negative(name, getattr(self, name)))
        for name in ("largest", "period", "max_pressure", "patience"):
            object.__setattr__(self, name, one_positive(name, getattr(self, name)))


@dataclass(frozen=True)
class Incident:
    """Something that happens during a task.

    Parameters
    ----------
    time : float
        [s], since the task began; negative while it settles.
    happens : callable
        Takes the pressure loop and the pose sensor, and changes them.

    Raises
    ------
    TypeError
        ``happens`` is no function.
    ValueError
        The time is not finite.
    """

    time: float
    happens: Callable[[PressureLoop, PoseSensor], None]

    def __post_init__(self) -> None:
        object.__setattr__(self, "time", one_finite("time of an Incident", self.time))
        function("happens of an Incident", self.happens)


@dataclass(frozen=True)
class TipErrors:
    """Distance of the tip from where it is wanted, over a task [m]; ``length`` is what shares refer to [m]."""

    mean: float
    percentile_95: float
    largest: float
    length: float

    def shares(self) -> tuple[float, float, float]:
        """The three over ``length``."""
        return self.mean / self.length, self.percentile_95 / self.length, self.largest / self.length


@dataclass(frozen=True, eq=False)
class PostureRun:
    """A task as it went, one row an outer step. Times before zero are for settling at the start.

    Parameters
    ----------
    task : Task
    time : array, shape (K,)
        At the end of each step [s].
    wanted, tip, seen : array, shape (K, 3), (K, 4, 4), (K, 4, 4)
        Place of the tip wanted [m], its true pose, and its reading at the start of the step, in the controller's frame.
    commanded, pressures : array, shape (K, A)
        Gauge pressures [Pa]: asked of the inner loop, and true.
    load : array, shape (K, 3)
        Force on the tip [N].
    seconds, cpu_seconds : array, shape (K,)
        That the outer step took, from reading to pressures, by the clock and of the processor.
    reached : array of bool, shape (K,)
        The search for pressures reached its target.
    postures : tuple of Posture
        Every ``kept``-th one, for pictures.
    trace : Trace
        Of the inner loop.
    faults : tuple of Fault
        What ended control; times count from the task's start.
    base : array, shape (3, 3)
        Axes of the true base in the controller's frame: postures stand in it.
    length : float
        Reference length of the limb [m].
    """

    task: Task
    time: Array
    wanted: Array
    tip: Array
    seen: Array
    commanded: Array
    pressures: Array
    load: Array
    seconds: Array
    cpu_seconds: Array
    reached: NDArray[np.bool_]
    postures: tuple[Posture, ...]
    kept: int
    trace: Trace
    faults: tuple[Fault, ...]
    base: Array
    length: float

    @property
    def success(self) -> bool:
        """The task was done: no fault, and the plant was solved."""
        return not self.faults and self.trace.solved

    @property
    def message(self) -> str:
        """Outcome in words."""
        if self.faults:
            return "; ".join(fault.message for fault in self.faults)
        return "done" if self.trace.solved else "the plant's implicit steps did not converge, or left a volume table"

    @property
    def distances(self) -> Array:
        """Of the tip from where it is wanted [m], shape (K,)."""
        return np.asarray(np.linalg.norm(self.tip[:, :3, 3] - self.wanted, axis=1))

    @property
    def errors(self) -> TipErrors:
        """Over the task, settling left out."""
        rows = self.distances[self.time > 0.0]
        return TipErrors(float(rows.mean()), float(np.percentile(rows, 95.0)), float(rows.max()), self.length)


class _Corrector:
    """The model's inverse on the way in, an integral of what is seen on the way back."""

    def __init__(self, limb: Limb, control: PostureControl, gravity: Array, first: Array) -> None:
        self.limb, self.control, self.gravity = limb, control, gravity
        self.prefer = np.full(len(limb._tubes), control.prefer)
        self.correction = np.zeros(3)
        self.pressures = np.zeros(len(limb._tubes))
        # Where to begin is looked for everywhere, which may take a second: before the clock starts. A step must end in
        # time: what the answer before does not lead to is not looked for anywhere else.
        self.answer = self._search(first, None, STARTS)
        self.missed = self._miss_of(self.answer)
        self.reached = self.answer.reached
        self.unreached = self.unseen = self.unchanged = self.bounded = 0
        self.nearest = np.inf  # distance of the tip from its target while the correction is at its bound [m]
        self.last: Array | None = None

    def _count_bounded(self, bounded: bool, away: float) -> None:
        """Steps at the bound since the tip last came nearer by a tenth: a slow plant on its way is no fault."""
        if not bounded:
            self.bounded, self.nearest = 0, np.inf
        elif away < 0.9 * self.nearest:
            self.bounded, self.nearest = 1, away
        else:
            self.bounded += 1

    @staticmethod
    def _miss_of(found: Reach) -> Reach | None:
        return found if found.status in ("no_progress", "singular_jacobian") else None

    def _next(self, position: Array) -> Reach:
        """Search from the answer before, unless the last search says how this one ends.

        The distance of a place from all that is in reach changes by no more than the place moves: what was out of reach
        by ten times as much as it moved still is. A search that fails takes longer than a step may.
        """
        missed = self.missed
        if missed is not None and np.linalg.norm(position - missed.target[:3, 3]) < 0.1 * missed.error.position:
            return missed
        found = self._search(position, self.answer, 0)
        self.missed = self._miss_of(found)
        return found

    def _search(self, position: Array, start: Reach | None, starts: int) -> Reach:
        return self.limb.reach(
            position=position,
            max_pressure=self.control.max_pressure,
            prefer=self.prefer,
            tolerance=1e-5,  # of the length: a hundredth of a millimetre
            start=start,
            starts=starts,
            gravity=self.gravity,
        )

    def step(self, wanted: Array, expected: Array, seen: Array) -> tuple[str, str] | None:
        """Pressures for a place; the name and detail of a fault that lasted too long, else None."""
        control = self.control
        patience = max(1, round(control.patience / control.period))
        finite = bool(np.isfinite(seen).all())
        same = finite and self.last is not None and bool((seen == self.last).all())
        self.last = seen
        self.unseen = 0 if finite else self.unseen + 1
        self.unchanged = self.unchanged + 1 if same else 0
        before = self.correction
        if control.closed and finite and not same:
            self.correction = before + control.gain * control.period * (expected - seen[:3, 3])
            size = float(np.linalg.norm(self.correction))
            self._count_bounded(size > control.largest, float(np.linalg.norm(expected - seen[:3, 3])))
            if size > control.largest:
                self.correction = self.correction * (control.largest / size)
        found = self._next(wanted + self.correction)
        self.reached = found.reached
        if found.reached:
            self.answer, self.pressures, self.unreached = found, found.pressures, 0
        else:
            # The pressures stay, and so does the correction: more of it would lead further out.
            self.correction = before
            self.unreached += 1
        if self.unreached >= patience:
            return "out_of_reach", found.message
        if self.bounded >= patience:
            away = float(np.linalg.norm(expected - seen[:3, 3]))
            return "correction_limit", f"{away / mm:.0f} mm off at a correction of {control.largest / mm:.0f} mm"
        if control.closed and self.unseen >= patience:
            return "pose_not_finite", ""
        if control.closed and self.unchanged >= patience:
            return "pose_stuck", ""
        return None


def run_task(
    limb: Limb,
    task: Task,
    *,
    control: PostureControl | None = None,
    perturbation: Perturbation | None = None,
    pneumatics: Pneumatics | None = None,
    controllers: Sequence[PID | NeuralPID] | None = None,
    guard: Guard | None = None,
    sensor: PoseSensor | None = None,
    gravity: ArrayLike = (0.0, 0.0, 9.81),
    incidents: Sequence[Incident] = (),
    settling: float = 2.5,
    after: float = 1.0,
    keep: int = 5,
) -> PostureRun:
    """Let a limb do a task.

    Parameters
    ----------
    limb : Limb
        The model that the controller knows.
    task : Task
    control : PostureControl, optional
    perturbation : Perturbation, optional
        What the true limb differs by. Default: nothing.
    pneumatics : Pneumatics, optional
        Default: that of the limb; the perturbation's offsets are added to its sensors.
    controllers : sequence of PID or NeuralPID, optional
        One an actuator. Default: neural ones, normalised with rates of 0.1, from the weights of the SIMC rule.
    guard : Guard, optional
        Default: `Guard` as it is; somebody always watches.
    sensor : PoseSensor, optional
    gravity : array_like, shape (3,)
        [m/s^2]; the default hangs.
    incidents : sequence of Incident
        At times within the run, settling and ``after`` included.
    settling : float
        Before the task, at its start [s]; does not count.
    after : float
        How much longer than the task to look on, once control has ended [s].
    keep : int
        Every how many-th posture to keep.

    Returns
    -------
    PostureRun
        A task that ends early says so in ``faults``; then all lines are vented, and the run shows it.

    Raises
    ------
    TypeError
        An argument is something else.
    ValueError
        The outer period is no multiple of the inner one, or longer than the task; a sequence has a wrong length; an
        incident is not within the run; the task begins nowhere; a number is out of range.

    Notes
    -----
    The limb is quasi-static: each outer step solves the posture at the true pressures, from the one before. MECHANICS,
    "Control".
    """
    of_type("limb", limb, Limb)
    of_type("task", task, Task)
    of_type("incidents", incidents, Sequence)
    optional: tuple[tuple[str, object, type], ...] = (
        ("control", control, PostureControl),
        ("perturbation", perturbation, Perturbation),
        ("pneumatics", pneumatics, Pneumatics),
        ("controllers", controllers, Sequence),
        ("guard", guard, Guard),
        ("sensor", sensor, PoseSensor),
    )
    for argument, given, kind in optional:
        if given is not None:
            of_type(argument, given, kind)
    control = PostureControl() if control is None else control
    perturbation = Perturbation.none(limb) if perturbation is None else perturbation
    sensor = PoseSensor() if sensor is None else sensor
    pull = finite_of_shape("gravity", gravity, (3,))
    keep = one_whole("keep", keep, 1)
    true = TrueLimb(limb, perturbation, pull)
    plant = Pneumatics(limb) if pneumatics is None else pneumatics
    if len(plant) != len(limb._tubes):
        raise ValueError(f"pneumatics has {len(plant)} chambers, the limb {len(limb._tubes)} actuators")
    ticks = round(control.period / plant.period)
    if ticks < 1 or abs(ticks * plant.period - control.period) > 1e-9 * control.period:
        raise ValueError(
            f"period of a PostureControl must be a multiple of the plant's {plant.period:g} s, got {control.period:g}"
        )
    known = learning_from(simc(plant), 0.1, learning="normalised") if controllers is None else list(controllers)
    offsets = zip(plant.sensors, perturbation.pressure_offset, strict=True)
    real = plant.replaced(sensor=[replace(one, offset=one.offset + float(off)) for one, off in offsets])
    loop = PressureLoop(real, known, guard=Guard() if guard is None else guard)

    begin = -round(one_not_negative("settling", settling) / control.period)
    end = round((task.seconds + one_not_negative("after", after)) / control.period)
    last_step = round(task.seconds / control.period)
    if last_step < 1:
        raise ValueError(
            f"seconds of a Task must be at least a period of the outer loop, {control.period:g} s, got {task.seconds:g}"
        )
    for number, incident in enumerate(incidents):
        of_type(f"incidents[{number}]", incident, Incident)
        if not begin * control.period <= incident.time < end * control.period:
            raise ValueError(
                f"time of incidents[{number}] must be within the run, {begin * control.period:g} to "
                f"{end * control.period:g} s, got {incident.time:g}"
            )
    # What the task asks for at its start is looked at here; what it asks for later is a fault if it is no place.
    place = finite_of_shape("place at the start of the task", task.place(0.0), (3,))
    load = finite_of_shape("load at the start of the task", task.force(0.0), (3,))
    corrector = _Corrector(limb, control, pull, place)
    waiting = sorted(incidents, key=lambda one: one.time)
    rows: dict[str, list[Any]] = {
        name: []
        for name in (
            *("time", "wanted", "tip", "seen", "commanded", "pressures", "load"),
            *("seconds", "cpu_seconds", "reached"),
        )
    }
    faults: list[Fault] = []
    postures: list[Posture] = []
    traces: list[Trace] = []
    posture = true.solve(np.zeros(len(plant)), np.zeros(3))
    if not posture.success:
        raise ValueError(f"the limb has no posture to start from: {posture.message}")
    tip = true.tip_of(posture)
    for k in range(begin, end):
        if k >= last_step and not loop.vented:
            break
        now = k * control.period
        while waiting and waiting[0].time <= now:
            waiting.pop(0).happens(loop, sensor)
        seen = sensor.read(tip)
        began, cpu_began = clock.perf_counter(), clock.thread_time()
        wanted, expected = task.place(now), task.place(now - control.lag)
        if not loop.vented:
            is_place = np.isfinite([wanted, expected]).all()
            found = corrector.step(wanted, expected, seen) if is_place else ("task_not_finite", "offset")
            if found is not None:
                faults.append(Fault(now, found[0], None, found[1]))
                loop.vent()
        taken = clock.perf_counter() - began, clock.thread_time() - cpu_began
        traces.append(loop.run(np.tile(corrector.pressures, (ticks, 1))))
        then = now + control.period
        force, ahead = task.force(then), task.place(then)
        if not np.isfinite(force).all() and not loop.vented:
            faults.append(Fault(then, "task_not_finite", None, "load"))
            loop.vent()
        # What is no number is left out of the record: the last that was one stands there.
        load = force if np.isfinite(force).all() else load
        place = ahead if np.isfinite(ahead).all() else place
        if posture.success:
            moved = true.solve(np.maximum(loop.plant.pressures, 0.0), load, posture)
            if not (moved.success and moved.stable) and not loop.vented:
                faults.append(Fault(then, "posture_lost", None, moved.message))
                loop.vent()
            posture = moved
            tip = true.tip_of(posture) if posture.success else np.full((4, 4), np.nan)
        values = (then, place, tip, seen, corrector.pressures, loop.plant.pressures, load)
        for name, value in zip(rows, (*values, *taken, corrector.reached), strict=True):
            rows[name].append(value)
        if (k - begin) % keep == 0:
            postures.append(posture)
    late = begin * control.period  # the inner loop counts from the start of settling
    inner = [replace(fault, time=fault.time + late) for fault in loop.faults]
    return PostureRun(
        task=task,
        **{name: np.array(values) for name, values in rows.items()},
        postures=tuple(postures),
        kept=keep,
        trace=Trace.joined(traces),
        faults=tuple(sorted([*faults, *inner], key=lambda fault: fault.time)),
        base=true.base,
        length=limb.length,
    )
