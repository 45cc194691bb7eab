"""Text of answers: tables with columns aligned and units in the headings, numbers, vectors, directions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any


def aligned(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Columns as wide as they need, two spaces between them.

    Parameters
    ----------
    headings : sequence of str
        With units: "x [mm]".
    rows : sequence of sequences of str
        Cells, ready for print.

    Returns
    -------
    str
        Lines without a line break at the end.
    """
    widths = [max(len(cell) for cell in column) for column in zip(headings, *rows, strict=True)]
    lines = [headings, ["-" * width for width in widths], *rows]
    return "\n".join("  ".join(c.rjust(w) for c, w in zip(line, widths, strict=True)).rstrip() for line in lines)


def number(value: float, decimals: int) -> str:
    """A number with fixed decimals; a dash where there is none, and no minus before a zero."""
    if not math.isfinite(value):
        return "-"
    text = f"{value:.{decimals}f}"
    return text.lstrip("-") if float(text) == 0.0 else text


def vector(values: Any, decimals: int) -> str:
    """Numbers in brackets: "(0, 0, 9.81)"."""
    return "(" + ", ".join(f"{round(float(value), decimals) + 0.0:g}" for value in values) + ")"


def signed_parts(parts: Any, names: Sequence[str]) -> str:
    """A unit vector by the names of its axes: "+0.80 fx -0.60 my"; parts of 0.05 and below do not count."""
    terms = [f"{part:+.2f} {name}" for part, name in zip(parts, names, strict=True) if abs(part) > 0.05]
    return " ".join(terms)
