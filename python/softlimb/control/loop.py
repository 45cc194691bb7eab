"""The inner loop: sensors, controllers, guards and valves, a thousand times a second against the plant."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb import _core
from softlimb.arguments import finite_array, of_type, one_finite, one_positive, one_whole
from softlimb.control.controllers import PID, NeuralPID
from softlimb.control.pneumatics import Pneumatics
from softlimb.units import kPa

__all__ = ["Fault", "Guard", "PressureLoop", "Trace"]

Array = NDArray[np.float64]
Controller = PID | NeuralPID

_MOST_STEPS = 2**31 - 1  # what the guard counts with

_SAID = {
    "sensor_not_finite": "the pressure sensor gives no number",
    "sensor_stuck": "the pressure sensor repeats one reading while its valve is told to move air",
    "over_pressure": "the pressure is above what is allowed",
    "no_response": "the pressure does not follow the valve: a stuck valve, or a large leak",
    "wrong_way": "the command leads away from the target: gains of the wrong sign, or a sum of errors from long ago",
    "supply_lost": "the supply is below the pressure that is needed",
    "pose_not_finite": "the measured pose holds no numbers",
    "pose_stuck": "the measured pose repeats itself",
    "out_of_reach": "the target is out of reach",
    "correction_limit": "the correction stays at its bound, and the tip away from the target",
    "task_not_finite": "the task gives what is no number",
    "posture_lost": "no posture of the limb was found at these pressures",
}


@dataclass(frozen=True)
class Fault:
    """What ended control: every line is vented from then on.

    Parameters
    ----------
    time : float
        Since the start [s].
    kind : str
        ``sensor_not_finite``, ``sensor_stuck``, ``over_pressure``, ``no_response``, ``wrong_way``,
        ``supply_lost``; of the posture loop ``pose_not_finite``, ``pose_stuck``, ``out_of_reach``,
        ``correction_limit``, ``task_not_finite``, ``posture_lost``.
    channel : int, optional
        Which actuator, from 0 in flat order; none for the whole limb.
    detail : str
        More about it.
    """

    time: float
    kind: str
    channel: int | None = None
    detail: str = ""

    @property
    def message(self) -> str:
        """In words."""
        where = "" if self.channel is None else f"actuator {self.channel}: "
        more = f" ({self.detail})" if self.detail else ""
        return f"at {self.time:.3f} s {where}{_SAID[self.kind]}{more}; vented"


@dataclass(frozen=True)
class Guard:
    """When an actuator counts as broken; steps are those of the loop.

    Air counts in steps of full flow: |command| beyond the idle one, times the pressure difference that drives it over
    ``full_drop``, one at most.

    Parameters
    ----------
    not_finite_steps : int
        Readings in a row that are no number.
    highest : float
        Pressure allowed [Pa], over ``over_pressure_steps`` readings in a row.
    idle_command : float
        Opens nothing: the valve's dead band and half its play.
    full_drop : float
        Pressure difference of full flow [Pa].
    stuck_effort, coarse_code, stuck_steps
        Air during which a reading repeats itself; what moves a reading by a code must be less. Once the valve was open
        for ``stuck_steps`` of it, the share will do that a code, the least change of readings so far, has of
        ``coarse_code`` [Pa], a tenth at least.
    response_error, response, response_effort
        Air towards the target, with an error above ``response_error`` [Pa], that brings it no nearer by ``response``
        [Pa]; it may be sent in pieces.
    response_command, response_steps
        Command away from the target, in a row, as a share of the controller's limit (at most 1), with an error above
        ``response_error``.
    lowest_supply : float, optional
        Reading of the supply's sensor [Pa], over ``supply_steps`` in a row; below the pressure of the supply. Default:
        half of that.

    Raises
    ------
    ValueError
        A number is out of range.

    Notes
    -----
    MECHANICS, "Control".
    """

    not_finite_steps: int = 5
    highest: float = 150 * kPa
    over_pressure_steps: int = 5
    idle_command: float = 0.04
    full_drop: float = 160 * kPa
    stuck_effort: float = 60.0
    coarse_code: float = 1 * kPa
    stuck_steps: int = 250
    response_error: float = 2 * kPa
    response: float = 1 * kPa
    response_effort: float = 120.0
    response_command: float = 0.9
    response_steps: int = 400
    lowest_supply: float | None = None
    supply_steps: int = 20

    def __post_init__(self) -> None:
        for field in fields(self):
            name, value = f"{field.name} of a Guard", getattr(self, field.name)
            if field.name.endswith("_steps"):
                object.__setattr__(self, field.name, one_whole(name, value, 1, _MOST_STEPS))
            elif field.name != "lowest_supply":
                object.__setattr__(self, field.name, one_positive(name, value))
            elif value is not None:
                object.__setattr__(self, field.name, one_finite(name, value))
        if self.response_command > 1.0:
            raise ValueError(
                f"response_command of a Guard must be a share of the limit, at most 1, got {self.response_command!r}"
            )

    def of(self, supply: float) -> Guard:
        """The guard of a plant with a supply of this gauge pressure [Pa].

        Raises
        ------
        ValueError
            ``lowest_supply`` is not below it: control would end at once.
        """
        if self.lowest_supply is None:
            return replace(self, lowest_supply=0.5 * supply)
        if self.lowest_supply >= supply:
            raise ValueError(
                f"lowest_supply of a Guard must be below the supply's {supply:g} Pa, got {self.lowest_supply:g}"
            )
        return self


@dataclass(frozen=True, eq=False)
class Trace:
    """What a run of the loop was, a row a step and a column an actuator.

    Parameters
    ----------
    time : array, shape (N,)
        At the start of each step [s].
    targets, readings, pressures : array, shape (N, A)
        Wanted, seen at the start of the step, and true at its end, gauge [Pa].
    commands, openings : array, shape (N, A)
        Of the valves, -1 to 1.
    weights : array, shape (N, A, 3)
    supply : array, shape (N,)
        Gauge pressure of the reservoir [Pa].
    air : float
        Drawn from the reservoir during the run [kg].
    faults : tuple of Fault
    solved : bool
        Every implicit step of the plant converged, and no chamber left its volume table.
    seconds : array, shape (N,), optional
        That controllers and guards took.
    """

    time: Array
    targets: Array
    readings: Array
    pressures: Array
    commands: Array
    openings: Array
    weights: Array
    supply: Array
    air: float
    faults: tuple[Fault, ...]
    solved: bool
    seconds: Array | None = None

    @cached_property
    def errors(self) -> Array:
        """Target minus true pressure [Pa], shape (N, A)."""
        return self.targets - self.pressures

    @classmethod
    def joined(cls, parts: Sequence[Trace]) -> Trace:
        """Runs one after the other as one."""
        if not parts:
            raise ValueError("traces to join must be at least one, got none")
        rows = ("time", "targets", "readings", "pressures", "commands", "openings", "weights", "supply")
        stacked = {name: np.concatenate([getattr(part, name) for part in parts]) for name in rows}
        taken = [part.seconds for part in parts if part.seconds is not None]
        return cls(
            **stacked,
            air=sum(part.air for part in parts),
            faults=parts[-1].faults,
            solved=all(part.solved for part in parts),
            seconds=np.concatenate(taken) if len(taken) == len(parts) else None,
        )


class PressureLoop:
    """Controllers and guards against a plant.

    Parameters
    ----------
    pneumatics : Pneumatics
    controllers : PID or NeuralPID, or a sequence with one a chamber
        Copied: what they learn here stays here.
    guard : Guard, optional
        None: nobody watches.

    Raises
    ------
    TypeError
        No plant, or no guard.
    ValueError
        Not one controller a chamber, a controller with another period than the plant's, or a guard that asks for more
        than the supply gives.
    """

    def __init__(
        self, pneumatics: Pneumatics, controllers: Controller | Sequence[Controller], *, guard: Guard | None = None
    ) -> None:
        of_type("pneumatics", pneumatics, Pneumatics)
        if guard is not None:
            of_type("guard", guard, Guard)
        many = tuple(controllers) if isinstance(controllers, Sequence) else ()
        given = (controllers,) * len(pneumatics) if isinstance(controllers, PID | NeuralPID) else many
        if len(given) != len(pneumatics) or not all(isinstance(one, PID | NeuralPID) for one in given):
            raise ValueError(f"controllers must be one PID or NeuralPID, or one a chamber ({len(pneumatics)})")
        for one in given:
            if one.options["period"] != pneumatics.period:
                raise ValueError(
                    f"period of a controller must be the plant's {pneumatics.period:g} s, got {one.options['period']:g}"
                )
        self.pneumatics = pneumatics
        fresh = [one.replaced() for one in given]
        self._core = _core.PressureLoop(
            pneumatics.plant(),
            [one._core for one in fresh],
            None if guard is None else astuple(guard.of(pneumatics.supply.pressure)),
        )

    @property
    def plant(self) -> _core.Plant:
        """The plant, to disturb: leaks, loads, stuck valves, sensors, the supply."""
        return self._core.plant

    @property
    def time(self) -> float:
        """Since the start [s]."""
        return self._core.steps * self.pneumatics.period

    @property
    def vented(self) -> bool:
        """Control has ended."""
        return self._core.vented

    @property
    def faults(self) -> tuple[Fault, ...]:
        """What ended control, if it did."""
        return tuple(Fault(step * self.pneumatics.period, kind, channel) for channel, kind, step in self._core.faults)

    def vent(self) -> None:
        """End control: exhaust commands, supply cut off, every line open to the atmosphere."""
        self._core.vent()

    def run(self, targets: ArrayLike, *, timed: bool = False) -> Trace:
        """Follow targets, one row a step.

        Parameters
        ----------
        targets : array_like, shape (N, A)
            Gauge pressures [Pa].
        timed : bool
            Take the time of controllers and guards in each step.

        Returns
        -------
        Trace

        Raises
        ------
        ValueError
            Targets of a wrong shape or not finite.
        """
        rows = finite_array("targets", targets)
        if rows.ndim != 2 or rows.shape[1] != len(self.pneumatics):
            raise ValueError(f"targets has shape {rows.shape}: expected (steps, {len(self.pneumatics)})")
        began, drawn = self._core.steps, self.plant.ledger["drawn"]
        found = self._core.run(rows, timed=timed)
        solved = bool(found.pop("solved")) and not any(self.plant.beyond_table)
        return Trace(
            time=np.arange(began, began + len(rows), dtype=np.float64) * self.pneumatics.period,
            targets=rows,
            air=self.plant.ledger["drawn"] - drawn,
            faults=self.faults,
            solved=solved,
            **found,
        )
