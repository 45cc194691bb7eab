"""The files of a report, written as its scenes finish: what a run leaves behind when it is interrupted is whole."""

from __future__ import annotations

import csv
import io
import os
from pathlib import Path

from softlimb.bench.clock import quartiles
from softlimb.report.measure import Measured
from softlimb.report.page import Page, as_html, as_markdown
from softlimb.report.picture import draw
from softlimb.units import ms

__all__ = ["COLUMNS", "write_page", "write_scene"]

COLUMNS = (
    "scene",
    "method",
    "setting",
    "outcome",
    "error",
    "median_ms",
    "lower_quartile_ms",
    "upper_quartile_ms",
    "ratio_to_yardstick",
    "samples",
    "remark",
)
"""Of a scene's CSV table; cells without a number are empty."""


def write_scene(measured: Measured, folder: Path, yardstick: float) -> None:
    """Table (CSV) and, where there is something to draw, picture (PNG) of a scene.

    Parameters
    ----------
    yardstick : float
        Its median during the run [s].
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for row in measured.rows:
        error = "" if row.error is None else repr(row.error)
        times = ["", "", "", "", ""]
        if row.samples is not None:
            low, middle, high = (repr(value / ms) for value in quartiles(row.samples.seconds))
            times = [middle, low, high, repr(row.ratio), str(row.samples.seconds.size)]
        writer.writerow([measured.name, row.method, row.setting, row.outcome, error, *times, row.remark])
    _replace(folder / f"{measured.name}.csv", text.getvalue().encode())
    if measured.rows:
        picture = io.BytesIO()
        draw(measured, yardstick).savefig(picture, format="png")
        _replace(folder / f"{measured.name}.png", picture.getvalue())


def write_page(page: Page, folder: Path) -> None:
    """``report.md`` and ``report.html``."""
    _replace(folder / "report.md", as_markdown(page).encode())
    _replace(folder / "report.html", as_html(page).encode())


def _replace(path: Path, content: bytes) -> None:
    """The old file or the new one, never half of it."""
    beside = path.with_name(path.name + ".part")
    beside.write_bytes(content)
    os.replace(beside, path)
