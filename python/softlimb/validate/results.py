"""What a validation found: tables, what it says in words, what stays unexplained, and curves for a picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from softlimb.measured import _CsvTable

Array = NDArray[np.float64]
Kind = Literal["measured", "measured, other branch", "predicted", "model at points", "held out", "off by"]


@dataclass(frozen=True)
class Table:
    """Cells ready for print; units in the headings."""

    title: str
    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True, eq=False)
class Series:
    """Points or a line of a picture, in the units of its panel's labels."""

    kind: Kind
    x: Array
    y: Array


@dataclass(frozen=True, eq=False)
class Panel:
    """One pair of axes."""

    title: str
    x_label: str
    y_label: str
    series: tuple[Series, ...]
    equal: bool = False


@dataclass(frozen=True, eq=False)
class Validation:
    """A model against measurements.

    Parameters
    ----------
    name : str
        Of the data set.
    what : str
        What was measured and what was fitted, in a sentence or two.
    tables : tuple of Table
    findings : tuple of str
        What the numbers say; every error with what its per cent are of.
    unexplained : tuple of str
        What the model leaves, and what is known of why.
    panels : tuple of Panel
    success : bool
        Every prediction exists and every search converged.
    """

    name: str
    what: str
    tables: tuple[Table, ...]
    findings: tuple[str, ...]
    unexplained: tuple[str, ...]
    panels: tuple[Panel, ...]
    success: bool


def rms(values: Array) -> float:
    """Root mean square; NaN of nothing."""
    return float(np.sqrt(np.mean(np.square(values)))) if np.size(values) else float("nan")


@dataclass(frozen=True, eq=False)
class Columns:
    """Columns of a file by name, of one length; numbers as they stand there, NaN where a cell may be empty."""

    texts: Mapping[str, list[str]]
    numbers: Mapping[str, Array]


def read_columns(
    path: Path, texts: Sequence[str], numbers: Sequence[str], *, may_be_empty: Sequence[str] = (), least: int = 1
) -> Columns:
    """Columns of a delimited file.

    Raises
    ------
    FileNotFoundError
        There is no such file.
    ValueError
        A column is missing, a cell holds no finite number, or there are fewer rows than ``least``.
    """
    table = _CsvTable(path, {})
    missing = [name for name in (*texts, *numbers) if name not in table.header]
    if missing:
        raise ValueError(f"{path}: missing column `{missing[0]}`; the columns are {', '.join(table.header)}")
    if len(table.rows) < least:
        raise ValueError(f"{path}: {len(table.rows)} rows are too few: expected at least {least}")
    place = {name: table.header.index(name) for name in (*texts, *numbers)}

    def cell(row: list[str], name: str) -> str:
        return row[place[name]].strip() if place[name] < len(row) else ""

    found: dict[str, Array] = {}
    for name in numbers:
        column = []
        for line, row in table.rows:
            text = cell(row, name)
            blank = not text and name in may_be_empty
            column.append(np.nan if blank else table._number(text, line, place[name]))
        found[name] = np.array(column)
    return Columns({name: [cell(row, name) for _, row in table.rows] for name in texts}, found)
