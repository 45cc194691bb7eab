"""The picture of a scene: error over time, both logarithmic, and above it what ended without an answer."""

from __future__ import annotations

import textwrap
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from softlimb.bench.clock import quartiles
from softlimb.plot import style
from softlimb.report.measure import Measured, Row
from softlimb.report.methods import (
    CONSTANT_CURVATURE,
    LEAST_SQUARES,
    OURS,
    PAPER,
    PAPER_CONSTANTS,
    SHOOTING,
    SOLVE_BVP,
)
from softlimb.units import ms

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.transforms import Bbox

__all__ = ["draw", "troubles"]

# Marker, line and lightness all differ, so that any one of them may be lost on paper.
_LOOKS: dict[str, dict[str, Any]] = {
    OURS: {"marker": "o", "linestyle": "-", "color": "#12355b", "linewidth": 2.0, "markersize": 6.5},
    SHOOTING: {"marker": "s", "linestyle": "--", "color": "#c1440e"},
    SOLVE_BVP: {"marker": "^", "linestyle": "-.", "color": "#3f8f5f"},
    LEAST_SQUARES: {"marker": "v", "linestyle": ":", "color": "#7d5ba6"},
    PAPER: {"marker": "D", "linestyle": "none", "color": "#a8802a"},
    PAPER_CONSTANTS: {"marker": "P", "linestyle": "none", "color": "#c9a227", "markersize": 8.0},
    CONSTANT_CURVATURE: {"marker": "X", "linestyle": "none", "color": "#6f6f6f", "markersize": 8.0},
}
_EDGE = {"markeredgecolor": "0.15", "markeredgewidth": 0.6, "linewidth": 1.4, "markersize": 6.5}
_LEAST = 1e-16
"""Errors below rounding are drawn here."""
_SMALL = style.FONT_SIZE - 1.5
_LEFT, _RIGHT, _BOTTOM, _TOP = 0.105, 0.625, 0.115, 0.80  # of the axes, in parts of the figure
_ROW = 0.031  # of a line of text
_KEY = "labels: tolerance, or RK4 steps; bars: quartiles of the time; hollow: no answer to this scene"


def draw(measured: Measured, yardstick: float) -> Figure:
    """Error over time of all methods on a scene.

    Parameters
    ----------
    measured : Measured
        With a reference.
    yardstick : float
        Its median during the run [s], for the axis above.

    Returns
    -------
    Figure
        Bars are quartiles of the times. Hollow markers are answers that are not the scene's; what has no answer stands
        in a strip above, at the time after which it ended, or beside its name where it did not begin.
    """
    assert measured.reference is not None
    figure = style.new_figure(200.0, 116.0, constrained=False)
    lost = [name for name in measured.methods if any(_is_lost(row) for row in measured.of(name))]
    strip = 0.03 * len(lost)
    gap = 0.012 if lost else 0.0
    main = figure.add_axes((_LEFT, _BOTTOM, _RIGHT - _LEFT, _TOP - _BOTTOM - strip - gap))
    for name in measured.methods:
        _draw_method(main, name, measured.of(name))
    _limits(main, measured)
    _floor(main, measured.reference.agreement)
    _label(main, measured)
    style.finish(main, "time of one solve [ms]", _error_label(measured))
    main.spines[["top", "right"]].set_visible(True)
    upper = main
    if lost:
        upper = figure.add_axes((_LEFT, _TOP - strip, _RIGHT - _LEFT, strip), sharex=main)
        _draw_strip(upper, measured, lost)
    ratio = upper.secondary_xaxis(
        "top", functions=(lambda x: np.asarray(x) * ms / yardstick, lambda y: np.asarray(y) * yardstick / ms)
    )
    ratio.set_xlabel("the same in yardsticks Y [1]", fontsize=style.FONT_SIZE)
    ratio.tick_params(labelsize=style.FONT_SIZE - 1.0)
    _legend(figure, measured)
    figure.text(_LEFT, 0.955, f"{measured.name}: {measured.what}", fontsize=style.FONT_SIZE + 1.0, weight="bold")
    figure.text(_LEFT, 0.917, _KEY, fontsize=_SMALL, color="0.3")
    return figure


def _error_label(measured: Measured) -> str:
    what = "the tube's length" if measured.name.startswith("tube") else "the tip"
    return f"error of {what},\nover the length [1]"


def _is_lost(row: Row) -> bool:
    """No answer, after some time."""
    return row.error is None and row.samples is not None


def _look(name: str) -> dict[str, Any]:
    return {**_EDGE, **_LOOKS[name]}


def _point(row: Row) -> tuple[float, float]:
    """Time [ms] and error of a row with an answer."""
    assert row.seconds is not None and row.error is not None
    return row.seconds / ms, max(row.error, _LEAST)


def _draw_method(axes: Axes, name: str, rows: list[Row]) -> None:
    found = [row for row in rows if row.error is not None]
    look = _look(name)
    line = {key: look[key] for key in ("linestyle", "color", "linewidth")}
    if found:
        axes.plot(*zip(*map(_point, found), strict=True), **line, zorder=2)
    for row in found:
        assert row.samples is not None
        time, error = _point(row)
        low, _, high = quartiles(row.samples.seconds)
        axes.plot([low / ms, high / ms], [error] * 2, color=look["color"], linewidth=0.9, marker="|", markersize=4.0)
        point = {**look, "linestyle": "none"}
        if row.outcome == "elsewhere":
            point |= {"markerfacecolor": "white", "markeredgecolor": look["color"]}
        axes.plot([time], [error], **point, zorder=3)


def _limits(axes: Axes, measured: Measured) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    assert measured.reference is not None
    errors = [max(row.error, _LEAST) for row in measured.rows if row.error is not None]
    times = [row.seconds / ms for row in measured.rows if row.seconds is not None]
    low = min([*errors, max(measured.reference.agreement, _LEAST)])
    axes.set_ylim(10.0 ** (np.floor(np.log10(low)) - 1.0), 10.0 ** max(0.5, np.ceil(np.log10(max(errors))) + 0.5))
    axes.set_xlim(min(times) / 4.0, max(times) * 3.0)


def _floor(axes: Axes, agreement: float) -> None:
    low, _ = axes.get_ylim()
    level = max(agreement, low)
    axes.axhspan(low, level, color="0.88", zorder=0)
    axes.annotate(
        f"the two references differ by {agreement:.0e}",
        (0.99, level),
        xycoords=("axes fraction", "data"),
        xytext=(0.0, 2.0),
        textcoords="offset points",
        ha="right",
        fontsize=_SMALL,
        color="0.35",
    )


def _label(axes: Axes, measured: Measured) -> None:
    """Settings beside the first and the last point of each method, where nothing else is; else not at all."""
    found = [row for row in measured.rows if row.error is not None]
    taken = [_box(axes, _point(row), (0.0, 0.0), 9.0, 9.0) for row in found]
    taken += [_bar_box(axes, row) for row in found]
    taken += [box for name in measured.methods for box in _line_boxes(axes, measured.of(name))]
    taken += [text.get_window_extent() for text in axes.texts]
    window = axes.get_window_extent()
    for name in measured.methods:
        found = [row for row in measured.of(name) if row.error is not None and row.mark]
        for row in {row.mark: row for row in (found[:1] + found[-1:])}.values():
            width, height = 0.6 * _SMALL * len(row.mark), 1.1 * _SMALL
            across, up = 0.5 * width + 7.0, 0.5 * height + 6.0
            near = ((across, 0.0), (-across, 0.0), (0.0, up), (0.0, -up))
            for shift in (*near, (across, up), (-across, -up), (across, -up), (-across, up)):
                box = _box(axes, _point(row), shift, width, height)
                if not box.count_overlaps(taken) and window.contains(*box.min) and window.contains(*box.max):
                    taken.append(box)
                    axes.annotate(
                        row.mark,
                        _point(row),
                        xytext=shift,
                        textcoords="offset points",
                        ha="center",
                        va="center",
                        fontsize=_SMALL,
                        color=_LOOKS[name]["color"],
                        zorder=4,
                    )
                    break


def _box(axes: Axes, point: tuple[float, float], shift: tuple[float, float], width: float, height: float) -> Bbox:
    """What a text beside a point covers [pixels]; shift and size in points of type."""
    from matplotlib.transforms import Bbox

    pixels = axes.get_figure(root=True).dpi / 72.0  # type: ignore[union-attr]
    x, y = axes.transData.transform(point) + pixels * np.array(shift)
    return Bbox.from_bounds(x - 0.5 * pixels * width, y - 0.5 * pixels * height, pixels * width, pixels * height)


def _bar_box(axes: Axes, row: Row) -> Bbox:
    """What the bar of a row's quartiles covers [pixels]."""
    from matplotlib.transforms import Bbox

    assert row.samples is not None
    low, _, high = quartiles(row.samples.seconds)
    _, error = _point(row)
    (left, y), (right, _) = axes.transData.transform([(low / ms, error), (high / ms, error)])
    return Bbox.from_bounds(left - 4.0, y - 6.0, right - left + 8.0, 12.0)


def _line_boxes(axes: Axes, rows: list[Row]) -> list[Bbox]:
    """What the line through a method's points covers, in short pieces [pixels]."""
    points = [_point(row) for row in rows if row.error is not None]
    boxes = []
    for start, end in pairwise(np.log10(points) if points else []):
        for share in np.linspace(0.0, 1.0, 30):
            time, error = 10.0 ** (start + share * (end - start))
            boxes.append(_box(axes, (time, error), (0.0, 0.0), 2.0, 2.0))
    return boxes


def _draw_strip(axes: Axes, measured: Measured, lost: list[str]) -> None:
    for place, name in enumerate(reversed(lost)):
        times = [row.seconds / ms for row in measured.of(name) if _is_lost(row) and row.seconds is not None]
        look = {**_look(name), "linestyle": "none", "markerfacecolor": "white", "markersize": 5.0}
        look["markeredgecolor"] = _LOOKS[name]["color"]
        axes.plot(times, [place] * len(times), **look)
    axes.set_ylim(-0.6, len(lost) - 0.4)
    axes.set_yticks([])
    axes.set_facecolor("0.95")
    axes.tick_params(axis="x", which="both", bottom=False, labelbottom=False)
    axes.text(0.01, 0.5, "no answer", transform=axes.transAxes, fontsize=_SMALL, va="center", color="0.3")


def _legend(figure: Figure, measured: Measured) -> None:
    """A line for every method, and under it what it could not do."""
    from matplotlib.lines import Line2D

    x, y = _RIGHT + 0.015, _TOP - 0.005
    for name in measured.methods:
        look = _look(name)
        rows = measured.of(name)
        if not any(row.outcome == "answer" for row in rows):
            look |= {"markerfacecolor": "white", "markeredgecolor": look["color"]}
        middle = y + 0.35 * _ROW
        look["transform"] = figure.transFigure
        figure.add_artist(Line2D([x, x + 0.05], [middle] * 2, **{**look, "marker": ""}))
        figure.add_artist(Line2D([x + 0.025], [middle], **{**look, "linestyle": "none"}))
        figure.text(x + 0.06, y, name, fontsize=style.FONT_SIZE)
        y -= _ROW
        for line in (line for text in troubles(rows) for line in textwrap.wrap(text, 44)):
            figure.text(x + 0.065, y, line, fontsize=_SMALL, color="0.3")
            y -= 0.87 * _ROW
        y -= 0.35 * _ROW


def troubles(rows: list[Row]) -> list[str]:
    """What a method could not do, settings with the same trouble together."""
    found: dict[str, list[str]] = {}
    for row in rows:
        if row.remark:
            found.setdefault(row.remark, []).append(row.setting)
    if len(rows) == 1:
        return list(found)
    # "20, 40, 80 steps": what settings have in common is said once.
    return [f"{_together(settings)}: {remark}" for remark, settings in found.items()]


def _together(settings: list[str]) -> str:
    numbers, units = zip(*(setting.partition(" ")[::2] for setting in settings), strict=True)
    if len(set(units)) == 1:
        return f"{', '.join(numbers)} {units[0]}"
    if len(set(numbers)) == 1:
        return f"{numbers[0]} {', '.join(units)}"
    return ", ".join(settings)
