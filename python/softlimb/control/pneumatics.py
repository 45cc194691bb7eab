"""The air that pressure control moves: pump, reservoir, valves, lines, and chambers whose volumes tubes tell.

Numbers without a source are assumptions, of the class of small parts that such limbs are driven with; what they decide
is in the benchmark and in the tests, and every one of them can be changed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from softlimb import _core
from softlimb.arguments import finite_array, of_type, one_finite, one_not_negative, one_positive, one_whole, shown
from softlimb.limb import Limb
from softlimb.tube import Tube
from softlimb.units import kPa, m, mm, ms

__all__ = ["Chamber", "Gas", "Line", "Pneumatics", "Sensor", "Supply", "Valve"]

Array = NDArray[np.float64]
Part = TypeVar("Part")

_REFERENCE_DENSITY = 1.185  # [kg/m^3], air at 100 kPa, 20 C, 65 % humidity, ISO 8778
LITRE_PER_MINUTE = _REFERENCE_DENSITY * 1e-3 / 60.0
"""One litre a minute of air at the reference atmosphere [kg/s]."""
_MOST_SUBSTEPS = 1000  # the error halves with the step, and is below a pascal long before: more costs time alone


def _checked(
    part: Any, positive: Sequence[str] = (), not_negative: Sequence[str] = (), finite: Sequence[str] = ()
) -> None:
    for names, rule in ((positive, one_positive), (not_negative, one_not_negative), (finite, one_finite)):
        for name in names:
            object.__setattr__(part, name, rule(f"{name} of a {type(part).__name__}", getattr(part, name)))


def _within(part: Any, name: str, low: float, high: float) -> None:
    value = getattr(part, name)
    if not low <= value <= high:
        raise ValueError(f"{name} of a {type(part).__name__} must be within [{low:g}, {high:g}], got {value!r}")


@dataclass(frozen=True)
class Gas:
    """Air, p = p_a (rho / rho_a)^exponent.

    Parameters
    ----------
    exponent : float
        1 isothermal, 1.4 adiabatic. Assumption: 1.2, fills of a second exchange part of their heat.
    atmosphere : float
        [Pa], the standard atmosphere.
    temperature : float
        Of the room [K], that of ISO 8778.
    constant : float
        Of dry air [J/(kg K)].
    viscosity : float
        Of air at 20 C [Pa s].

    Raises
    ------
    ValueError
        The exponent is not within 1 and 1.4, or another number is not positive.
    """

    exponent: float = 1.2
    atmosphere: float = 101325.0
    temperature: float = 293.15
    constant: float = 287.05
    viscosity: float = 1.82e-5

    def __post_init__(self) -> None:
        _checked(self, [field.name for field in fields(self)])
        _within(self, "exponent", 1.0, 1.4)


@dataclass(frozen=True)
class Valve:
    """Proportional three-way valve for 0 to 500 kPa: command -1..1, positive feeds, negative exhausts.

    Parameters
    ----------
    conductance, exhaust_conductance : float
        Sonic conductance C of ISO 6358, fully open [m^3/(s Pa)]. Assumption: 1e-9, 21 l/min from a supply of 250 kPa.
    critical_ratio : float
        b of ISO 6358. Assumption: 0.3, between the 0.5 of a nozzle and what small valves have.
    time_constant, dead_time : float
        Of the spool [s]. Assumption: 10 ms and 3 ms; the dead time counts in whole sub-steps.
    dead_band : float
        Overlap to each side, as a share of the stroke. Assumption: 3 %.
    hysteresis : float
        Width of the play between command and spool, in strokes of one side. Assumption: 2 %.

    Raises
    ------
    ValueError
        A number is out of range.
    """

    conductance: float = 1e-9
    exhaust_conductance: float = 1e-9
    critical_ratio: float = 0.3
    time_constant: float = 10 * ms
    dead_time: float = 3 * ms
    dead_band: float = 0.03
    hysteresis: float = 0.02

    def __post_init__(self) -> None:
        _checked(
            self,
            ("conductance", "exhaust_conductance"),
            ("critical_ratio", "time_constant", "dead_time", "dead_band", "hysteresis"),
        )
        for name, high in (("critical_ratio", 0.99), ("dead_time", 1.0), ("dead_band", 0.9), ("hysteresis", 1.0)):
            _within(self, name, 0.0, high)


@dataclass(frozen=True)
class Line:
    """Round line between valve and chamber, laminar; assumption: 1 m of 2.5 mm bore.

    Parameters
    ----------
    length, diameter : float
        [m].

    Raises
    ------
    ValueError
        Not positive.
    """

    length: float = 1 * m
    diameter: float = 2.5 * mm

    def __post_init__(self) -> None:
        _checked(self, ("length", "diameter"))


@dataclass(frozen=True)
class Supply:
    """Pump and reservoir.

    Parameters
    ----------
    pressure : float
        Gauge pressure at which the pump stops [Pa]. Assumption: 250 kPa.
    volume : float
        Of the reservoir [m^3]. Assumption: 5 l.
    flow : float
        Most that the pump gives [kg/s]. Assumption: 30 l/min of air at the reference atmosphere.
    band : float
        How far below its stop the pump gives all it can [Pa]. Assumption: 20 kPa.

    Raises
    ------
    ValueError
        A number is not positive (a flow of zero is no pump).
    """

    pressure: float = 250 * kPa
    volume: float = 5e-3
    flow: float = 30 * LITRE_PER_MINUTE
    band: float = 20 * kPa

    def __post_init__(self) -> None:
        _checked(self, ("pressure", "volume", "band"), ("flow",))


@dataclass(frozen=True)
class Sensor:
    """Pressure sensor in each chamber, with its converter.

    Parameters
    ----------
    low, high : float
        What the converter spans, gauge [Pa]. Assumption: -5 to 200 kPa, 0.2 kPa a code; below zero, so that an offset
        does not hide where zero is.
    noise : float
        Standard deviation of a reading [Pa]. Assumption: 100 Pa.
    offset : float
        [Pa].
    bits : int
        Of the converter; zero: none, and no ends of its span.

    Raises
    ------
    ValueError
        A number is out of range.
    """

    low: float = -5 * kPa
    high: float = 200 * kPa
    noise: float = 100.0
    offset: float = 0.0
    bits: int = 10

    def __post_init__(self) -> None:
        _checked(self, (), ("noise",), ("low", "high", "offset"))
        if not self.high > self.low:
            raise ValueError(f"high of a Sensor must be above low, got {self.high!r} and {self.low!r}")
        if not isinstance(self.bits, int) or isinstance(self.bits, bool) or not 0 <= self.bits <= 24:
            raise ValueError(f"bits of a Sensor must be a whole number within [0, 24], got {shown(self.bits)}")


@dataclass(frozen=True, eq=False)
class Chamber:
    """Volume of a chamber over its gauge pressure.

    Parameters
    ----------
    pressures : array, shape (n,)
        Rising [Pa].
    volumes : array, shape (n,)
        Positive, not falling [m^3].

    Raises
    ------
    ValueError
        Fewer than two points, or numbers that do not rise.
    """

    pressures: Array
    volumes: Array

    def __post_init__(self) -> None:
        for name in ("pressures", "volumes"):
            object.__setattr__(self, name, finite_array(f"{name} of a Chamber", getattr(self, name)))
        if self.pressures.ndim != 1 or self.pressures.shape != self.volumes.shape or len(self.pressures) < 2:
            raise ValueError(
                f"pressures and volumes of a Chamber must be two rows of the same length, at least 2, got shapes "
                f"{self.pressures.shape} and {self.volumes.shape}"
            )
        if not (np.diff(self.pressures) > 0.0).all():
            raise ValueError("pressures of a Chamber must rise")
        if not ((self.volumes > 0.0).all() and (np.diff(self.volumes) >= 0.0).all()):
            raise ValueError("volumes of a Chamber must be positive and must not fall")

    @classmethod
    def of(cls, tube: Tube, highest: float = 250 * kPa, points: int = 126) -> Chamber:
        """pi v L of a tube at its own pressures, 0 to ``highest`` or as far as it is stable.

        The tube is free: what a load on it adds to its volume is a disturbance here, see `Pneumatics.set_volume_scale`.
        """
        limit = tube.limit_pressure
        pressures = np.linspace(0.0, highest if limit is None else min(highest, 0.98 * limit), points)
        state = tube.inflate(pressures)
        bad = np.flatnonzero(~np.asarray(state.success))
        if bad.size:
            pressures, state = pressures[: bad[0]], tube.inflate(pressures[: bad[0]])
        if len(pressures) < 2:
            raise ValueError(f"a tube without a stable state below {highest / kPa:g} kPa is no chamber: {tube!r}")
        return cls(pressures, np.asarray(state.volume))


class Pneumatics:
    """A plant of pressure control: one valve, line, chamber and sensor for each actuator, one supply.

    Parameters
    ----------
    chambers : Limb, or sequence of Tube or Chamber
    valve, line, sensor : one for all, or a sequence with one each
    gas, supply
    period : float
        Of a step of the controllers [s].
    substeps : int
        Implicit steps within it. Four of 0.25 ms follow a step of pressure to a few tens of pascals, a fifth of a code
        of the converter (``tests/benchmarks/bench_control.py``). At most 1000: the error is far below a pascal there.
    dump_conductance : float
        Of the normally open valve at each line that vents it when control gives up [m^3/(s Pa)]. Assumption: 2e-9.
    seed : int
        Of the sensors' noise.

    Raises
    ------
    TypeError
        Chambers, gas or supply are something else.
    ValueError
        A number is out of range, a sequence has not one entry a chamber, or the reservoir is too small for the step.

    Notes
    -----
    All chambers start at the atmosphere, the reservoir full. MECHANICS, "Control".
    """

    def __init__(
        self,
        chambers: Limb | Sequence[Tube | Chamber],
        *,
        valve: Valve | Sequence[Valve] | None = None,
        line: Line | Sequence[Line] | None = None,
        sensor: Sensor | Sequence[Sensor] | None = None,
        gas: Gas | None = None,
        supply: Supply | None = None,
        period: float = 1 * ms,
        substeps: int = 4,
        dump_conductance: float = 2e-9,
        seed: int = 0,
    ) -> None:
        of_type("chambers", chambers, Limb, Sequence)
        parts = chambers._tubes if isinstance(chambers, Limb) else tuple(chambers)
        made: dict[Tube, Chamber] = {}
        for part in parts:
            if isinstance(part, Tube) and part not in made:
                made[part] = Chamber.of(part)
            elif not isinstance(part, Tube | Chamber):
                raise TypeError(f"chambers must each be a Tube or a Chamber, got {type(part).__name__}")
        self.chambers = tuple(part if isinstance(part, Chamber) else made[part] for part in parts)
        if not self.chambers:
            raise ValueError("chambers must be at least one, got none")
        count = len(self.chambers)
        self.valves = _each("valve", Valve, valve, count)
        self.lines = _each("line", Line, line, count)
        self.sensors = _each("sensor", Sensor, sensor, count)
        if gas is not None:
            of_type("gas", gas, Gas)
        if supply is not None:
            of_type("supply", supply, Supply)
        self.gas = Gas() if gas is None else gas
        self.supply = Supply() if supply is None else supply
        self.period = one_positive("period", period)
        self.substeps = one_whole("substeps", substeps, 1, _MOST_SUBSTEPS)
        self.dump_conductance = one_not_negative("dump_conductance", dump_conductance)
        self.seed = one_whole("seed", seed, 0, 2**63 - 1)

    def __len__(self) -> int:
        return len(self.chambers)

    def plant(self) -> _core.Plant:
        """A fresh plant, to step with commands alone."""
        supply = self.supply
        parts = zip(self.valves, self.lines, self.chambers, self.sensors, strict=True)
        return _core.Plant(
            gas=astuple(self.gas),
            supply=(supply.volume, supply.pressure, supply.flow, supply.band),
            channels=[
                (
                    astuple(valve),
                    astuple(line),
                    self.dump_conductance,
                    chamber.pressures.tolist(),
                    chamber.volumes.tolist(),
                    (sensor.low, sensor.high, sensor.noise, sensor.offset, sensor.bits),
                )
                for valve, line, chamber, sensor in parts
            ],
            period=self.period,
            substeps=self.substeps,
            seed=self.seed,
        )

    def replaced(self, **changes: Any) -> Pneumatics:
        """The same with some arguments changed."""
        given = {
            "chambers": self.chambers,
            "valve": self.valves,
            "line": self.lines,
            "sensor": self.sensors,
            **{
                name: getattr(self, name)
                for name in ("gas", "supply", "period", "substeps", "dump_conductance", "seed")
            },
        }
        return Pneumatics(**{**given, **changes})

    def __repr__(self) -> str:
        return f"Pneumatics({len(self)} chambers, {self.supply!r}, period={self.period:g}, substeps={self.substeps})"


def _each(name: str, kind: type[Part], given: Part | Sequence[Part] | None, count: int) -> tuple[Part, ...]:
    if given is None:
        return (kind(),) * count
    if isinstance(given, kind):
        return (given,) * count
    parts = tuple(given) if isinstance(given, Sequence) else ()
    if len(parts) != count or not all(isinstance(part, kind) for part in parts):
        raise ValueError(f"{name} must be a {kind.__name__}, or one for each of {count} chambers, got {shown(given)}")
    return parts
