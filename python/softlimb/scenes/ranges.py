"""The pressures of a sweep: one axis a range, a grid of all combinations."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softlimb.quantities import PRESSURE, named_quantity
from softlimb.scenes.table import Table

MOST_ROWS = 1_000_000
"""Most postures of one sweep: their table takes a gigabyte."""


@dataclass(frozen=True)
class Axis:
    """One axis of a sweep: values that some actuators take together.

    Parameters
    ----------
    values : tuple of float
        Gauge pressures [Pa]; or factors on the scene's own pressures when `actuators` is empty.
    actuators : tuple of tuple of int
        (segment, actuator), both counted from 1; empty: every pressure of the scene is multiplied by the value.
    """

    values: tuple[float, ...]
    actuators: tuple[tuple[int, int], ...] = ()

    @property
    def scales(self) -> bool:
        """True when the values multiply the scene's pressures."""
        return not self.actuators

    @property
    def label(self) -> str:
        """What the axis varies, in a few words."""
        if self.scales:
            return "all, as a part of the scene's pressures"
        return "actuators " + ", ".join(f"{segment}.{actuator}" for segment, actuator in self.actuators)


def axis_from_dict(content: Mapping[str, Any], where: str, counts: Sequence[int]) -> Axis:
    """Read one ``[[scene.sweep]]`` table.

    Parameters
    ----------
    content : mapping
        ``actuators`` ([[1, 1], [1, 2]]: segment and actuator from 1) or ``segment``; ``values_kPa`` or ``from_kPa``,
        ``to_kPa`` and ``points``; or ``factors`` (or ``from_factor``, ``to_factor`` and ``points``) on the scene's
        pressures.
    where : str
        Path of the table, for messages.
    counts : sequence of int
        Number of actuators of each segment.

    Raises
    ------
    ValueError
        Keys are unknown, missing or contradict each other; an actuator does not exist; there are no values.
    """
    others = ("actuators", "segment", "points", "factors", "from_factor", "to_factor")
    quantities = dict.fromkeys(("values", "from", "to"), PRESSURE)
    table = Table(content, where, quantities=quantities, others=others)
    if any(key in table for key in ("factors", "from_factor", "to_factor")):
        if any(key in table for key in ("actuators", "segment", "values", "from", "to")):
            raise table.error("an axis of factors scales all pressures: it takes neither actuators nor pressures")
        if "factors" in table:
            values = table.array("factors", (-1,))
        else:
            values = np.linspace(table.number("from_factor"), table.number("to_factor"), _points(table))
        return Axis(_not_empty(values, table))
    if "values" in table:
        if "from" in table or "to" in table or "points" in table:
            raise table.error("give either `values_kPa` or `from_kPa`, `to_kPa` and `points`: got both")
        values = table.array("values", (-1,))
    else:
        values = np.linspace(table.quantity("from"), table.quantity("to"), _points(table))
    return Axis(_not_empty(values, table), _actuators(table, counts))


def _points(table: Table) -> int:
    points = table.integer("points")
    # One point would leave `to` out without a word.
    if not 2 <= points <= MOST_ROWS:
        raise table.error(f"`points` must be within [2, {MOST_ROWS}], got {points},")
    return points


def _not_empty(values: NDArray[np.float64], table: Table) -> tuple[float, ...]:
    if values.size == 0:
        raise table.error("an axis of a sweep needs at least one value: none")
    return tuple(float(value) for value in values)


def _actuators(table: Table, counts: Sequence[int]) -> tuple[tuple[int, int], ...]:
    if ("actuators" in table) == ("segment" in table):
        raise table.error("an axis of pressures names `actuators` or a `segment`: give one of the two")
    if "segment" in table:
        segment = table.integer("segment")
        if not 1 <= segment <= len(counts):
            raise table.error(f"`segment` must be within [1, {len(counts)}], got {segment},")
        return tuple((segment, actuator) for actuator in range(1, counts[segment - 1] + 1))
    pairs = table.array("actuators", (-1, 2))
    for segment, actuator in pairs:
        if not (1 <= segment <= len(counts) and 1 <= actuator <= counts[int(segment) - 1]):
            raise table.error(
                f"`actuators` lists [{segment:g}, {actuator:g}], but the limb has segments of "
                f"{', '.join(map(str, counts))} actuators (counted from 1),"
            )
        if segment != int(segment) or actuator != int(actuator):
            raise table.error(f"`actuators` must be whole numbers, got [{segment:g}, {actuator:g}],")
    return tuple((int(segment), int(actuator)) for segment, actuator in pairs)


def axis_to_dict(axis: Axis) -> dict[str, Any]:
    """Describe an axis by its values."""
    if axis.scales:
        return {"factors": list(axis.values)}
    key, values = named_quantity("values", list(axis.values), PRESSURE)
    return {"actuators": [list(pair) for pair in axis.actuators], key: values}


def require_distinct(axes: Sequence[Axis]) -> None:
    """Refuse axes that claim an actuator twice: the later would silently undo the earlier.

    Raises
    ------
    ValueError
        The message names the actuator.
    """
    claimed: dict[tuple[int, int], int] = {}
    for number, axis in enumerate(axes, start=1):
        for segment, actuator in axis.actuators:
            if (segment, actuator) in claimed:
                other = claimed[segment, actuator]
                where = f"twice in range {number}" if other == number else f"in ranges {other} and {number}"
                raise ValueError(f"actuator [{segment}, {actuator}] is {where} of the sweep: it can follow only one")
            claimed[segment, actuator] = number


def require_few(axes: Sequence[Axis]) -> None:
    """Refuse a sweep whose table would not fit into memory.

    Raises
    ------
    ValueError
        The message has the number of rows.
    """
    lengths = [len(axis.values) for axis in axes]
    if math.prod(lengths) > MOST_ROWS:
        product = " x ".join(map(str, lengths))
        raise ValueError(f"the ranges of the sweep make {product} = {math.prod(lengths)} rows: at most {MOST_ROWS}")


def grid(pressures: NDArray[np.float64], axes: Sequence[Axis], counts: Sequence[int]) -> NDArray[np.float64]:
    """All combinations of the axes' values, the last axis running fastest.

    Parameters
    ----------
    pressures : array of float, shape (A,)
        The scene's own pressures, which hold wherever no axis says otherwise [Pa].
    axes : sequence of Axis
        Pressures overrule what factors before them made.
    counts : sequence of int
        Number of actuators of each segment.

    Returns
    -------
    array of float, shape (N, A)
        Gauge pressures [Pa], flat order.

    Raises
    ------
    ValueError
        An actuator is in two axes, the combinations are more than `MOST_ROWS`, or a factor makes a pressure infinite.
    """
    require_distinct(axes)
    require_few(axes)
    first = np.concatenate([[0], np.cumsum(counts)])
    rows = pressures[np.newaxis].copy()
    for axis in axes:
        blocks = np.repeat(rows, len(axis.values), axis=0)
        values = np.tile(axis.values, len(rows))
        if axis.scales:
            with np.errstate(over="ignore"):
                blocks *= values[:, np.newaxis]
            if not np.isfinite(blocks).all():
                raise ValueError(f"factors of a sweep must leave pressures finite, got {max(axis.values, key=abs):g}")
        for segment, actuator in axis.actuators:
            blocks[:, first[segment - 1] + actuator - 1] = values
        rows = blocks
    return rows
