"""Tables of the command line: for the terminal, and for files."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

from softlimb.text_tables import aligned, number, vector

__all__ = ["aligned", "number", "vector", "write_csv"]


def write_csv(path: Path, header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Write a table to a file, and say so."""
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([header, *rows])
    print(f"table: {path}")
