"""Measured curves and postures: reading them, and how far a prediction is from them.

A measured file is a table of comma-, semicolon- or tab-separated columns below one line of names; lines that start with
``#`` are remarks (source, uncertainty). The names carry the units, and say what the file holds:

==================  ==========================================================================================
elongation curve    ``pressure_kPa``, ``elongation_mm``: gain of the tip along the base's axis over its place at
                    zero pressure in the same scene
bending curve       ``pressure_kPa``, ``bending_deg``: angle between the tip's and the base's axis
centreline          ``x_mm``, ``y_mm``, ``z_mm``: points in the base frame from base to tip; the last is the tip
tips                ``pressure_1_1_kPa`` ... (segment and actuator from 1), ``tip_x_mm``, ``tip_y_mm``, ``tip_z_mm``
==================  ==========================================================================================

Every unit of the right dimension will do (``pressure_psi``, ``elongation_m``). Other columns are left alone.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb.quantities import ANGLE, DIMENSIONS, LENGTH, PRESSURE, Dimension

if TYPE_CHECKING:
    from softlimb.limb import Posture
    from softlimb.scenes import Scene

Array: TypeAlias = NDArray[np.float64]

_LARGEST = 1e100  # of any number in any unit: distances are squared, and sums of squares must stay finite

KINDS: dict[str, Dimension] = {"elongation": LENGTH, "bending": ANGLE}
"""What a curve can hold, and its dimension."""


@dataclass(frozen=True, eq=False)
class Curve:
    """Something measured over one pressure.

    Parameters
    ----------
    kind : "elongation" or "bending"
    pressures : array of float, shape (n,)
        [Pa].
    values : array of float, shape (n,)
        [m] or [rad].
    skipped : int
        Rows left out because a cell was empty.
    """

    kind: str
    pressures: Array
    values: Array
    skipped: int = 0


@dataclass(frozen=True, eq=False)
class Centreline:
    """Points along a limb in the base frame [m], shape (n, 3), from base to tip; the last is the tip."""

    points: Array
    skipped: int = 0


@dataclass(frozen=True, eq=False)
class Tips:
    """Tip positions [m], shape (n, 3), with the pressures [Pa] that made them, shape (n, A)."""

    pressures: Array
    positions: Array
    skipped: int = 0


Measured: TypeAlias = "Curve | Centreline | Tips"


@dataclass(frozen=True, eq=False)
class CurveComparison:
    """A predicted curve beside a measured one.

    Parameters
    ----------
    measured : Curve
    predicted : array of float, shape (n,)
        Prediction at the measured pressures, NaN where the solve failed [m] or [rad].
    pressures : array of float, shape (n,)
        Pressures at which the prediction takes the measured values [Pa]; NaN where it never does.
    curve_pressures, curve_values : array of float, shape (m,)
        The predicted curve, for a picture.
    pressure_mae : float
        Mean of ``|pressures - measured.pressures|`` over the points reached [Pa]; NaN when there are none.
    r_squared : float
        ``1 - sum (measured - predicted)^2 / sum (measured - mean)^2`` at the measured pressures.
    value_mae : float
        Mean of ``|predicted - measured.values|`` [m] or [rad].
    unreached, failed : int
        Measured values that the prediction does not reach; points where the solve failed.
    """

    measured: Curve
    predicted: Array
    pressures: Array
    curve_pressures: Array
    curve_values: Array
    pressure_mae: float
    r_squared: float
    value_mae: float
    unreached: int
    failed: int


@dataclass(frozen=True, eq=False)
class PositionComparison:
    """Predicted positions beside measured ones.

    Parameters
    ----------
    measured : Centreline or Tips
    predicted : array of float, shape (n, 3)
        For a centreline the nearest point of the predicted one; for tips the predicted tips [m]. NaN where the solve
        failed.
    errors : array of float, shape (n,)
        Distances [m]; NaN where the solve failed.
    tip_error : float
        Distance of the tips: of the one posture, or the mean over all [m].
    reference_length : float
        What the per cent are of [m].
    r_squared : float
        ``1 - sum |measured - predicted|^2 / sum |measured - mean|^2``.
    failed : int
        Postures whose solve failed.
    posture : Posture or None
        The prediction beside a centreline.
    """

    measured: Centreline | Tips
    predicted: Array
    errors: Array
    tip_error: float
    reference_length: float
    r_squared: float
    failed: int
    posture: Posture | None = None

    @property
    def tip_error_percent(self) -> float:
        """Tip error in per cent of the reference length."""
        return 100.0 * self.tip_error / self.reference_length


def r_squared(measured: ArrayLike, predicted: ArrayLike) -> float:
    """Coefficient of determination: 1 is perfect, 0 is as good as the mean of what was measured.

    Parameters
    ----------
    measured, predicted : array_like, shape (n,) or (n, d)
        Points with NaN in either are left out.

    Returns
    -------
    float
        NaN when fewer than two points remain or the measured ones are all equal.
    """
    y, f = np.atleast_1d(np.asarray(measured, float)), np.atleast_1d(np.asarray(predicted, float))
    y, f = y.reshape(len(y), -1), f.reshape(len(f), -1)
    good = np.isfinite(y).all(axis=1) & np.isfinite(f).all(axis=1)
    y, f = y[good], f[good]
    if len(y) < 2:
        return math.nan
    total = float(np.sum((y - y.mean(axis=0)) ** 2))
    return 1.0 - float(np.sum((y - f) ** 2)) / total if total > 0.0 else math.nan


def mean_absolute_error(measured: ArrayLike, predicted: ArrayLike) -> float:
    """Mean of ``|predicted - measured|`` over the points that are finite in both; NaN when there are none."""
    difference = np.abs(np.asarray(predicted, float) - np.asarray(measured, float))
    difference = difference[np.isfinite(difference)]
    return float(difference.mean()) if difference.size else math.nan


def compare_curve(
    measured: Curve, response: Callable[[float], float], grid: ArrayLike, *, largest_pressure: float | None = None
) -> CurveComparison:
    """Hold a predicted curve against a measured one.

    Parameters
    ----------
    measured : Curve
    response : callable
        Pressure [Pa] to predicted value; NaN where there is none.
    grid : array_like, shape (m,)
        Pressures at which the predicted curve is laid out [Pa], increasing; between them `response` is asked again, so
        the grid only has to be fine enough to tell the branches apart.
    largest_pressure : float, optional
        How far beyond the grid a measured value is looked for [Pa]. Default: twice the grid's end, because leaving
        out the points that the prediction misses most would flatter it.

    Returns
    -------
    CurveComparison

    Notes
    -----
    A measured value below the prediction's first point counts as reached at the first pressure: an actuator that has
    not moved yet has no smaller pressure.
    """
    pressures = np.asarray(grid, dtype=float)
    if pressures.ndim != 1 or len(pressures) < 2 or np.any(np.diff(pressures) <= 0.0):
        raise ValueError("grid must be at least two increasing pressures")
    values = np.array([response(p) for p in pressures])
    predicted = np.array([response(p) for p in measured.pressures])
    limit = 2.0 * pressures[-1] if largest_pressure is None else largest_pressure
    longer, longer_values = _extended(pressures, values, response, float(np.max(measured.values)), limit)
    reached = np.array([pressure_at(value, response, longer, longer_values) for value in measured.values])
    return CurveComparison(
        measured=measured,
        predicted=predicted,
        pressures=reached,
        curve_pressures=pressures,
        curve_values=values,
        pressure_mae=mean_absolute_error(measured.pressures, reached),
        r_squared=r_squared(measured.values, predicted),
        value_mae=mean_absolute_error(measured.values, predicted),
        unreached=int(np.isnan(reached).sum()),
        failed=int(np.isnan(predicted).sum()),
    )


def _extended(
    pressures: Array, values: Array, response: Callable[[float], float], wanted: float, limit: float
) -> tuple[Array, Array]:
    """The curve continued in the grid's last step until it holds the largest measured value, fails or ends."""
    longer, longer_values = list(pressures), list(values)
    step = pressures[-1] - pressures[-2]
    # An increasing curve only: past a maximum more pressure does not help.
    while longer_values[-1] < wanted and longer[-1] + step <= limit and longer_values[-1] > longer_values[-2]:
        longer.append(longer[-1] + step)
        longer_values.append(response(longer[-1]))
    return np.array(longer), np.array(longer_values)


def pressure_at(value: float, response: Callable[[float], float], pressures: Array, values: Array) -> float:
    """Lowest pressure at which an increasing response takes a value.

    Parameters
    ----------
    value : float
    response : callable
        Pressure [Pa] to value.
    pressures, values : array of float, shape (m,)
        The response on a grid.

    Returns
    -------
    float
        Pressure [Pa], the first of the grid when the value is below the curve, NaN when it is nowhere on the grid.
    """
    if value <= values[0]:
        return float(pressures[0])
    crossing = np.flatnonzero((values[:-1] < value) & (values[1:] >= value))
    if crossing.size == 0:
        return math.nan
    i = int(crossing[0])
    return _root(
        lambda p: response(p) - value, (pressures[i], values[i] - value), (pressures[i + 1], values[i + 1] - value)
    )


def _root(function: Callable[[float], float], low: tuple[float, float], high: tuple[float, float]) -> float:
    """Illinois variant of the rule of false position between two points (x, f) of opposite sign.

    Source: M. Dowell and P. Jarratt, A modified regula falsi method, BIT 11 (1971) 168-174.
    """
    (a, fa), (b, fb) = low, high
    span = b - a
    # Each third step squares the error roughly; 30 steps end far below the last digit for any smooth curve.
    for _ in range(30):
        x = b - fb * (b - a) / (fb - fa)
        fx = function(x)
        if math.isnan(fx):
            return math.nan
        if fx * fb < 0.0:
            a, fa = b, fb
        else:
            fa *= 0.5
        moved, b, fb = abs(x - b), x, fx
        # A thousandth of a pascal in a range of kilopascals: a million times finer than any gauge.
        if fb == 0.0 or moved <= 1e-8 * span:
            break
    return float(b)


def compare_centreline(
    measured: Centreline, posture: Posture, *, reference_length: float | None = None
) -> PositionComparison:
    """Hold a predicted posture against measured points along the limb.

    Parameters
    ----------
    measured : Centreline
    posture : Posture
    reference_length : float, optional
        What the per cent are of [m]; default `limb.length`.
    """
    # A thousandth of the limb's length a step: the chord misses an arc of half that length's radius by 3e-7 of it.
    nearest, tip = np.full(measured.points.shape, np.nan), np.full(3, np.nan)
    if posture.success:  # the best point of a failed solve is no prediction
        nearest = nearest_on_polyline(measured.points, posture.centreline(1001))
        tip = np.asarray(posture.tip)[:3, 3]
    return PositionComparison(
        measured=measured,
        predicted=nearest,
        errors=np.linalg.norm(measured.points - nearest, axis=1),
        tip_error=float(np.linalg.norm(measured.points[-1] - tip)),
        reference_length=float(posture.limb.length if reference_length is None else reference_length),
        r_squared=r_squared(measured.points, nearest),
        failed=0 if posture.success else 1,
        posture=posture,
    )


def compare_tips(measured: Tips, predicted: ArrayLike, *, reference_length: float) -> PositionComparison:
    """Hold predicted tips against measured ones.

    Parameters
    ----------
    measured : Tips
    predicted : array_like, shape (n, 3)
        Tip positions [m]; NaN where a solve failed.
    reference_length : float
        What the per cent are of [m].
    """
    tips = np.asarray(predicted, dtype=float)
    errors = np.linalg.norm(measured.positions - tips, axis=1)
    return PositionComparison(
        measured=measured,
        predicted=tips,
        errors=errors,
        tip_error=mean_absolute_error(np.zeros(len(errors)), errors),
        reference_length=reference_length,
        r_squared=r_squared(measured.positions, tips),
        failed=int(np.isnan(errors).sum()),
    )


def nearest_on_polyline(points: Array, line: Array) -> Array:
    """The point of a polyline nearest to each of some points.

    Parameters
    ----------
    points : array of float, shape (n, 3)
    line : array of float, shape (m, 3)

    Returns
    -------
    array of float, shape (n, 3)
    """
    start, step = line[:-1], np.diff(line, axis=0)
    squared = np.maximum(np.sum(step**2, axis=1), np.finfo(float).tiny)  # a step of length zero is its start
    along = np.einsum("nmk,mk->nm", points[:, None] - start, step) / squared
    feet = start + np.clip(along, 0.0, 1.0)[..., None] * step
    best = np.argmin(np.sum((points[:, None] - feet) ** 2, axis=-1), axis=1)
    nearest: Array = feet[np.arange(len(points)), best]
    return nearest


def response_of(scene: Scene, kind: str) -> Callable[[float], float]:
    """What a scene predicts as a function of the pressure of its one sweep axis.

    Parameters
    ----------
    scene : Scene
        With exactly one ``[[scene.sweep]]`` of pressures.
    kind : "elongation" or "bending"

    Returns
    -------
    callable
        Pressure [Pa] to elongation [m] or bending [rad]; NaN where the solve does not succeed.

    Raises
    ------
    ValueError
        The scene has no or several axes, or one of factors: it is not clear which pressure the file means.
    """
    from softlimb.scenes.ranges import Axis, grid
    from softlimb.sweep import bending_angle

    if len(scene.sweep_axes) != 1 or scene.sweep_axes[0].scales:
        raise ValueError(
            f"to compare with a curve over one pressure the scene needs exactly one [[scene.sweep]] of pressures, "
            f"it has {len(scene.sweep_axes)}"
        )
    actuators, known = scene.sweep_axes[0].actuators, dict[float, float]()
    own = np.zeros(sum(scene.counts)) if scene.pressures is None else scene.pressures

    def measure(pressure: float) -> float:
        if pressure not in known:
            row = grid(own, [Axis((pressure,), actuators)], scene.counts)[0]
            posture = scene.solve(row)
            pose = np.asarray(posture.tip)
            value = bending_angle(pose) if kind == "bending" else pose[2, 3]
            known[pressure] = float(value) if posture.success else math.nan
        return known[pressure]

    return (lambda pressure: measure(pressure) - measure(0.0)) if kind == "elongation" else measure


def read_measured(path: str | Path, columns: Mapping[str, str] | None = None) -> Measured:
    """Read a measured file; its columns say what it holds.

    Parameters
    ----------
    path : str or Path
    columns : mapping of str to str, optional
        Names that this module knows to names in the file, where they differ: ``{"pressure_kPa": "P_kPa"}``.

    Returns
    -------
    Curve, Centreline or Tips

    Raises
    ------
    FileNotFoundError
        There is no such file.
    ValueError
        No rows, a missing column, a column without unit or with the unit of something else, a cell that is no number;
        the message names file, line and column.
    """
    table = _CsvTable(Path(path), columns or {})
    actuators = table.actuator_columns()
    if actuators:
        wanted = {name: PRESSURE for name in actuators} | dict.fromkeys(("tip_x", "tip_y", "tip_z"), LENGTH)
        numbers, skipped = table.numbers(wanted)
        return Tips(numbers[:, :-3], numbers[:, -3:], skipped)
    for kind, dimension in KINDS.items():
        if table.mentions(kind):
            numbers, skipped = table.numbers({"pressure": PRESSURE, kind: dimension})
            return Curve(kind, numbers[:, 0], numbers[:, 1], skipped)
    if table.mentions("x"):
        numbers, skipped = table.numbers(dict.fromkeys("xyz", LENGTH))
        return Centreline(numbers, skipped)
    raise ValueError(
        f"{path}: the columns {', '.join(f'`{name}`' for name in table.header)} do not say what was measured; expected "
        "`pressure_kPa` with `elongation_mm` or `bending_deg`; or `x_mm`, `y_mm`, `z_mm`; or `pressure_1_1_kPa` ... "
        "with `tip_x_mm`, `tip_y_mm`, `tip_z_mm`"
    )


class _CsvTable:
    """A delimited text file with one line of column names."""

    def __init__(self, path: Path, columns: Mapping[str, str]) -> None:
        self.path = path
        try:
            lines = path.read_text(encoding="utf-8-sig").splitlines()
        except FileNotFoundError:
            raise FileNotFoundError(f"there is no file {path}") from None
        except IsADirectoryError:
            raise ValueError(f"{path} is a folder, not a CSV file") from None
        except UnicodeDecodeError:
            raise ValueError(f"{path} is not a text file in UTF-8") from None
        kept = [
            (i, line) for i, line in enumerate(lines, start=1) if line.strip() and not line.lstrip().startswith("#")
        ]
        if not kept:
            raise ValueError(f"{path} is empty: expected a line of column names and rows of numbers")
        if len(kept) == 1:
            raise ValueError(f"{path} has a line of column names but no rows of numbers")
        delimiter = max(",;\t", key=kept[0][1].count)
        try:
            rows = list(csv.reader((line for _, line in kept), delimiter=delimiter))
        except csv.Error as error:
            raise ValueError(f"{path} is not a table: {error}") from None
        if len(rows) != len(kept):
            raise ValueError(f"{path}: a quotation mark opens and does not close in the same line")
        renamed = {theirs: ours for ours, theirs in columns.items()}
        for theirs in renamed:
            if theirs not in [name.strip() for name in rows[0]]:
                raise ValueError(
                    f"{path} has no column `{theirs}`; it has {', '.join(f'`{n.strip()}`' for n in rows[0])}"
                )
        self.header = [renamed.get(name.strip(), name.strip()) for name in rows[0]]
        twice = next((name for name in self.header if name and self.header.count(name) > 1), None)
        if twice is not None:
            raise ValueError(f"{path}: column `{twice}` is there {self.header.count(twice)} times: keep one")
        self.rows = [(number, row) for (number, _), row in zip(kept[1:], rows[1:], strict=True)]

    def mentions(self, quantity: str) -> bool:
        """Is there a column for this quantity, with any unit, or none?"""
        units = {unit for dimension in DIMENSIONS for unit in dimension.factors}
        return any(name == quantity or name in {f"{quantity}_{unit}" for unit in units} for name in self.header)

    def actuator_columns(self) -> list[str]:
        """Columns such as pressure_2_1_kPa, without unit, in flat order."""
        found = set()
        for name in self.header:
            parts = name.split("_")
            if len(parts) >= 3 and parts[0] == "pressure" and parts[1].isdigit() and parts[2].isdigit():
                found.add((int(parts[1]), int(parts[2])))
        return [f"pressure_{segment}_{actuator}" for segment, actuator in sorted(found)]

    def numbers(self, wanted: Mapping[str, Dimension]) -> tuple[Array, int]:
        """The wanted columns in SI, and how many rows were left out for an empty cell."""
        found = [self._column(quantity, dimension) for quantity, dimension in wanted.items()]
        kept: list[list[float]] = []
        for line, row in self.rows:
            cells = [row[index].strip() if index < len(row) else "" for index, _ in found]
            if all(cells):
                kept.append([self._number(cell, line, i) * f for cell, (i, f) in zip(cells, found, strict=True)])
        if not kept:
            names = ", ".join(f"`{self.header[index]}`" for index, _ in found)
            raise ValueError(f"{self.path}: no row has numbers in all of {names}")
        return np.array(kept), len(self.rows) - len(kept)

    def _column(self, quantity: str, dimension: Dimension) -> tuple[int, float]:
        found = [
            (index, factor)
            for index, name in enumerate(self.header)
            for unit, factor in dimension.factors.items()
            if name == f"{quantity}_{unit}"
        ]
        if len(found) > 1:
            names = " and ".join(f"`{self.header[index]}`" for index, _ in found)
            raise ValueError(f"{self.path}: columns {names} give the same thing: keep one")
        if found:
            return found[0]
        listed = dimension.listed(quantity)
        for name in self.header:
            if name == quantity:
                raise ValueError(f"{self.path}: column `{name}` needs its unit in the name: {listed}")
            if self.mentions(quantity) and name.startswith(f"{quantity}_"):
                unit = name[len(quantity) + 1 :]
                raise ValueError(
                    f"{self.path}: column `{name}`: `{unit}` is not a unit of {dimension.name}; use {listed}"
                )
        columns = ", ".join(f"`{name}`" for name in self.header)
        raise ValueError(
            f"{self.path}: missing column `{quantity}_{next(iter(dimension.factors))}`; the columns are {columns}"
        )

    def _number(self, cell: str, line: int, index: int) -> float:
        try:
            number = float(cell)
        except ValueError:
            number = math.nan
        if not math.isfinite(number):
            raise ValueError(
                f"{self.path}, line {line}: column `{self.header[index]}` holds {cell!r}, not a finite number"
            )
        if abs(number) > _LARGEST:
            raise ValueError(f"{self.path}, line {line}: column `{self.header[index]}` holds {cell!r}: too large")
        return number
