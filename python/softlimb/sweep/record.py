"""What a sweep is a sweep of, as plain data: limb, options, number of rows; two of them differ by name."""

from __future__ import annotations

import inspect
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from softlimb.arguments import joined, shown
from softlimb.scenes import limb_from_dict, limb_to_dict

if TYPE_CHECKING:
    from softlimb.limb import Limb

_PER_ROD = ("rod_forces", "rod_moments")


@dataclass(frozen=True)
class SweepRecord:
    """Everything on which the rows of a sweep depend except their pressures.

    Parameters
    ----------
    count : int
        Number of rows.
    actuators, plates : int
        Of the limb.
    ordered : bool
    limb : dict
        As `softlimb.scenes.limb_to_dict` gives it.
    options : dict
        Arguments of `Limb.solve` that are not its defaults, as JSON holds them.
    """

    count: int
    actuators: int
    plates: int
    ordered: bool
    limb: dict[str, Any]
    options: dict[str, Any]

    @classmethod
    def of(cls, limb: Limb, options: Mapping[str, Any], ordered: bool, count: int) -> SweepRecord:
        """Describe a sweep.

        Raises
        ------
        ValueError
            An option has no form in a file: a posture as `start`, or no numbers, texts or truth values at all.
        TypeError
            `Limb.solve` has no such option.
        """
        defaults = _defaults()
        for name in options:
            if name not in defaults:
                raise TypeError(f"a sweep has no argument {name!r}: expected one of {', '.join(defaults)}")
        plain = {name: _plain(name, value) for name, value in options.items()}
        return cls(
            count=count,
            actuators=sum(len(segment.actuators) for segment in limb.segments),
            plates=len(limb.segments),
            ordered=ordered,
            limb=json.loads(json.dumps(limb_to_dict(limb))),
            options={name: value for name, value in plain.items() if value != _plain(name, defaults[name])},
        )

    def to_dict(self) -> dict[str, Any]:
        """As JSON holds it."""
        return dict(vars(self))

    @classmethod
    def from_dict(cls, content: Mapping[str, Any]) -> SweepRecord:
        """Read what `to_dict` gave.

        Raises
        ------
        ValueError, KeyError, TypeError
            It is something else.
        """
        record = cls(**{name: content[name] for name in cls.__dataclass_fields__})
        numbers = (record.count, record.actuators, record.plates)
        if not all(type(number) is int and number >= 0 for number in numbers) or type(record.ordered) is not bool:
            raise ValueError("the numbers of rows, actuators and plates are not whole")
        if not isinstance(record.limb, dict) or not isinstance(record.options, dict):
            raise ValueError("limb and options are not tables")
        return record

    def make_limb(self) -> Limb:
        """The limb, equal to the one that was described.

        Raises
        ------
        ValueError
            It is no limb, or not one of so many actuators and plates.
        """
        limb = limb_from_dict(self.limb)
        if (len(limb.segments), sum(len(s.actuators) for s in limb.segments)) != (self.plates, self.actuators):
            raise ValueError("the numbers of actuators and plates are not those of the limb")
        return limb

    def make_options(self, limb: Limb) -> dict[str, Any]:
        """The options, ready for `Limb.solve`."""
        return {name: _ready(limb, name, value) for name, value in self.options.items()}

    def require(self, path: Path, asked: SweepRecord) -> None:
        """Refuse to go on with a sweep that is not the one in a file.

        Raises
        ------
        ValueError
            The message names the file and what differs.
        """
        if self.limb != asked.limb:
            raise ValueError(f"file {path} holds the sweep of another limb: give another file")
        defaults = _defaults()
        for name in sorted({*self.options, *asked.options}):
            mine, theirs = (record.options.get(name, _plain(name, defaults.get(name))) for record in (self, asked))
            if mine != theirs:
                raise ValueError(f"file {path} holds a sweep with {name} {shown(mine)}, not {shown(theirs)}")
        if self.ordered != asked.ordered:
            raise ValueError(f"file {path} holds a sweep with ordered {self.ordered}, not {asked.ordered}")
        if self.count != asked.count:
            raise ValueError(f"file {path} holds other pressures: {self.count} rows, not {asked.count}")


def normal_options(limb: Limb, options: Mapping[str, Any]) -> dict[str, Any]:
    """Options of a sweep in one form, whatever lists they came as; errors as for `SweepRecord.of`."""
    return {name: _ready(limb, name, _plain(name, value)) for name, value in options.items()}


def _ready(limb: Limb, name: str, value: Any) -> Any:
    if name in _PER_ROD and value is not None:
        ends = np.cumsum([len(segment.members) for segment in limb.segments])[:-1]
        return tuple(np.split(np.array(value, dtype=float), ends))
    if name == "tip_held" and value is not None:
        return tuple(value)
    return np.array(value) if isinstance(value, list) else value


def _defaults() -> dict[str, Any]:
    """Arguments of `Limb.solve` that all rows share, with their defaults."""
    from softlimb.limb import Limb

    parameters = inspect.signature(Limb.solve).parameters
    return {name: p.default for name, p in parameters.items() if name not in ("self", "pressures", "rest_lengths")}


def _plain(name: str, value: Any) -> Any:
    """An option as JSON holds it, so that equal options are equal there: (0, 0, 1) is [0.0, 0.0, 1.0]."""
    from softlimb.posture import Posture

    if value is None or isinstance(value, str):
        return value
    if isinstance(value, Posture):
        raise ValueError(f"{name} is a posture, which has no form in a file of a sweep: give its plates in its place")
    try:
        truths = np.asarray(value)
    except ValueError:  # lists of different lengths
        truths = np.empty(0)
    if truths.dtype == np.bool_:
        return truths.tolist()
    numbers = joined(name, value)
    if not np.isfinite(numbers).all():
        raise ValueError(f"{name} must be finite, got {shown(value)}")
    return (numbers.reshape(-1, 3) if name in _PER_ROD and numbers.size % 3 == 0 else numbers).tolist()
