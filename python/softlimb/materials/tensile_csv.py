"""Reading tensile tests: files of the Soft Robotics Materials Database, and plain tables with units in the header."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from difflib import get_close_matches
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

_STRESS_UNITS = {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "bar": 1e5, "psi": 6894.757293168361}
_STRAIN_UNITS = {"": 1.0, "-": 1.0, "1": 1.0, "m/m": 1.0, "mm/mm": 1.0, "%": 0.01, "percent": 0.01}

# Lines before the column names that are searched for them; the database has 17.
_LONGEST_HEADER = 60

# A stress of the wrong sign at the start is noise around zero if it is below this part of the largest stress; above it
# is data, or a mistake that must not vanish. The database's worst case has 0.0014.
_SLACK = 0.01


@dataclass(frozen=True, eq=False)
class TensileTest:
    """One uniaxial test.

    Attributes
    ----------
    stretch : ndarray, shape (n,)
        1 + nominal strain.
    nominal_stress : ndarray, shape (n,)
        Force over undeformed cross-section [Pa].
    name : str
        The material where the file names it, the file's name without ending otherwise.
    header : dict of str to str
        The file's header lines (specimen, standard, machine...), as they are.
    notes : tuple of str
        What was done to the data on reading, for example rows that were dropped.
    """

    stretch: NDArray[np.float64]
    nominal_stress: NDArray[np.float64]
    name: str = ""
    header: dict[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return (
            f"TensileTest({self.name!r}, {self.stretch.size} points, nominal strain "
            f"{self.stretch.min() - 1.0:.4g}..{self.stretch.max() - 1.0:.4g})"
        )


@dataclass(frozen=True)
class _Column:
    """A header cell that names a strain, a stretch or a stress."""

    index: int
    text: str
    quantity: str  # "strain", "stretch" or "stress"
    measure: str  # "nominal", "true" or "" where the cell does not say
    unit: str


def read_tensile_csv(path: str | PathLike[str]) -> TensileTest:
    """Read a tensile test from a text table.

    The line with the column names may follow any header of ``key;value`` lines, as in the files of the Soft Robotics
    Materials Database. Needed are one column of ``strain`` or ``stretch`` and one of ``stress``; each may be called
    nominal or engineering, and other columns are ignored. The unit follows in brackets or after an underscore:
    ``stretch,nominal_stress_MPa``, ``strain_%;stress_kPa``, ``Engineering Strain;Engineering Stress (MPa)``. Stress
    needs a unit; strain without one is dimensionless (0.5, not 50). Separator: semicolon, comma or tab; decimal dot.
    Lines that start with ``#`` and empty lines are skipped.

    Rows at the start whose stress has the sign opposite to the strain and is below 1 % of the largest (slack specimen,
    noise around zero) are dropped, and a note says so.

    Parameters
    ----------
    path : str or path
        The file; UTF-8 or Latin-1.

    Returns
    -------
    TensileTest
        In SI units, rows in the order of the file.

    Raises
    ------
    ValueError
        No such columns, an unknown unit, a cell that is not a finite number (with its line), or no rows.
    OSError
        The file cannot be read.
    """
    path = Path(path)
    lines = _text_of(path).splitlines()
    if not any(line.strip() for line in lines):
        raise ValueError(f"{path.name} is empty: expected a line of column names and rows of numbers")
    header_line, separator, columns = _find_columns(lines, path.name)
    strain = _choose(columns, ("strain", "stretch"), path.name)
    stress = _choose(columns, ("stress",), path.name)
    strain_factor = _factor(strain, _STRAIN_UNITS, path.name)
    stress_factor = _factor(stress, _STRESS_UNITS, path.name)

    rows = []
    for number, line in enumerate(lines[header_line + 1 :], start=header_line + 2):
        if not line.strip(separator + " \t") or line.startswith("#"):
            continue
        cells = line.split(separator)
        rows.append(
            [
                _number(cells, strain, strain_factor, separator, number, path.name),
                _number(cells, stress, stress_factor, separator, number, path.name),
            ]
        )
    if not rows:
        raise ValueError(f"{path.name} has column names (line {header_line + 1}) but no rows below them")

    table = np.array(rows)
    elongation = table[:, 0] - (1.0 if strain.quantity == "stretch" else 0.0)
    nominal_stress = table[:, 1]
    start = _first_loaded_row(elongation, nominal_stress)
    notes: tuple[str, ...] = ()
    if start:
        what = "1 row" if start == 1 else f"{start} rows"
        notes = (f"{what} dropped at the start: stress of the opposite sign to the strain",)
    header = _key_values(lines[:header_line], separator)
    return TensileTest(
        stretch=1.0 + elongation[start:],
        nominal_stress=nominal_stress[start:],
        name=header.get("Material", path.stem),
        header=header,
        notes=notes,
    )


def _text_of(path: Path) -> str:
    data = path.read_bytes()
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def _find_columns(lines: list[str], name: str) -> tuple[int, str, list[_Column]]:
    """Index of the line with the column names, its separator, and the columns we know."""
    closest: list[_Column] = []
    for index, line in enumerate(lines[:_LONGEST_HEADER]):
        separator = max(";,\t", key=line.count)
        columns = [
            column for i, cell in enumerate(line.split(separator)) if (column := _column_of(i, cell)) is not None
        ]
        kinds = {column.quantity for column in columns}
        if "stress" in kinds and kinds & {"strain", "stretch"}:
            return index, separator, columns
        if len(line.split(separator)) > 1 and len(columns) > len(closest):
            closest = columns
    found = ", ".join(f"`{column.text}`" for column in closest) or "none of them"
    raise ValueError(
        f"{name} has no line that names a strain (or stretch) column and a stress column, such as "
        f"`stretch,nominal_stress_MPa`; found {found}"
    )


def _column_of(index: int, cell: str) -> _Column | None:
    """Read a cell such as ``Engineering Stress (MPa)`` or ``nominal_stress_kPa``; None for other quantities."""
    text = cell.strip().strip('"')
    match = re.fullmatch(
        r"(?P<words>(?:[A-Za-z]+[ _])*?)(?P<quantity>strain|stretch|stress)"
        r"(?:[ _]*[(\[](?P<in>[^)\]]*)[)\]]|[ _](?P<after>\S+))?",
        text,
        flags=re.IGNORECASE,
    )
    if match is None or (match["after"] or "").lower().startswith("rate"):
        return None
    words = match["words"].lower()
    measure = (
        "nominal" if re.search("nominal|engineering", words) else "true" if re.search("true|cauchy", words) else ""
    )
    return _Column(index, text, match["quantity"].lower(), measure, (match["in"] or match["after"] or "").strip())


def _choose(columns: list[_Column], quantities: tuple[str, ...], name: str) -> _Column:
    """The nominal column where several are there; never a true one."""
    ours = [column for column in columns if column.quantity in quantities]
    usable = [column for column in ours if column.measure != "true"]
    if not usable:
        raise ValueError(
            f"{name} has only `{ours[0].text}`: the nominal (engineering) {quantities[0]} is needed, "
            "force over undeformed area against elongation over undeformed length"
        )
    return next((column for column in usable if column.measure == "nominal"), usable[0])


def _factor(column: _Column, units: dict[str, float], name: str) -> float:
    if column.unit in units:
        return units[column.unit]
    known = ", ".join(unit for unit in units if unit)
    if not column.unit:
        raise ValueError(f"{name}: column `{column.text}` states no unit; expected one of {known}, as in `stress_MPa`")
    near = get_close_matches(column.unit.lower(), [unit.lower() for unit in units if unit], n=1)
    hint = "".join(f": did you mean {unit}?" for unit in units if near and unit.lower() == near[0])
    raise ValueError(f"{name}: column `{column.text}` has the unknown unit {column.unit!r} (known: {known}){hint}")


def _number(cells: list[str], column: _Column, factor: float, separator: str, line: int, name: str) -> float:
    """The cell in SI units."""
    where = f"{name}, line {line}, column `{column.text}`"
    if column.index >= len(cells) or not cells[column.index].strip():
        raise ValueError(f"{where}: the cell is missing")
    text = cells[column.index].strip().strip('"')
    try:
        value = float(text)
    except ValueError:
        hint = " (decimal comma? write a dot)" if "," in text and separator != "," else ""
        raise ValueError(f"{where}: {text!r} is not a number{hint}") from None
    if not math.isfinite(value):
        raise ValueError(f"{where}: {text!r} is not finite")
    if not math.isfinite(value * factor):
        raise ValueError(f"{where}: {text!r} {column.unit} is too large")
    return value * factor


def _first_loaded_row(elongation: NDArray[np.float64], stress: NDArray[np.float64]) -> int:
    slack = (np.sign(elongation) * np.sign(stress) < 0.0) & (np.abs(stress) < _SLACK * np.abs(stress).max())
    return int(np.argmin(slack))


def _key_values(lines: list[str], separator: str) -> dict[str, str]:
    pairs = (line.split(separator) for line in lines if not line.startswith("#"))
    return {cells[0].strip(): cells[1].strip() for cells in pairs if len(cells) > 1 and cells[0].strip()}
