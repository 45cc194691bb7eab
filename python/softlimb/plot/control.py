"""Pictures of pressure control: pressures, commands and weights over time; learning rates and where they fail."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from softlimb.control import LearningLimit, Trace
from softlimb.plot import style
from softlimb.units import kPa

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LINES: tuple[dict[str, Any], ...] = (
    {"color": "#1f4e79", "linestyle": "-"},
    {"color": "#c05a00", "linestyle": "--"},
    {"color": "#5b8c5a", "linestyle": ":"},
    {"color": "black", "linestyle": "-."},
)
_MOST_POINTS = 4000  # of a line: more than the picture has pixels


def pressure_control(trace: Trace, channels: Sequence[int] = (0,)) -> Figure:
    """Pressures with their targets, valve commands, and weights, over time.

    Parameters
    ----------
    trace : Trace
    channels : sequence of int
        Actuators to show, from 0 in flat order; four at most. Weights are those of the first.

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        No channel, more than four, or one that the trace does not have.
    """
    count = trace.targets.shape[1]
    if not 1 <= len(channels) <= len(_LINES) or not all(0 <= k < count for k in channels):
        raise ValueError(f"channels must be one to {len(_LINES)} of 0 to {count - 1}, got {tuple(channels)}")
    figure = style.new_figure(180.0, 130.0)
    pressures, commands, weights = figure.subplots(3, 1, sharex=True, height_ratios=(2.0, 1.2, 1.2))
    step = max(1, len(trace.time) // _MOST_POINTS)
    time = trace.time[::step]
    for line, channel in zip(_LINES, channels, strict=False):
        pressures.plot(time, trace.targets[::step, channel] / kPa, color="0.55", linewidth=2.6, alpha=0.6)
        pressures.plot(
            time, trace.pressures[::step, channel] / kPa, linewidth=1.2, label=f"actuator {channel + 1}", **line
        )
        commands.plot(time, trace.commands[::step, channel], linewidth=0.8, **line)
    pressures.plot([], [], color="0.55", linewidth=2.6, alpha=0.6, label="target")
    for number, line in enumerate(_LINES[:3]):
        weights.plot(time, trace.weights[::step, channels[0], number], linewidth=1.2, label=f"w{number + 1}", **line)
    weights.set_yscale("symlog", linthresh=0.1)
    style.finish(pressures, "", "gauge pressure [kPa]")
    style.finish(commands, "", "command")
    commands.set_ylim(-1.1, 1.1)
    style.finish(weights, "time [s]", f"weights, actuator {channels[0] + 1}")
    for ax in (pressures, weights):
        _legend(ax, 5)
    for fault in trace.faults:
        for ax in (pressures, commands):
            ax.axvline(fault.time, color=style.LOAD_COLOUR, linewidth=1.2)
        pressures.set_title(fault.message, color=style.LOAD_COLOUR, fontsize=style.FONT_SIZE, loc="left")
    return figure


def learning(limits: Mapping[str, LearningLimit]) -> Figure:
    """Chatter of the command and integral of the error over the learning rate, with the rates that no longer settle.

    Parameters
    ----------
    limits : mapping of str to LearningLimit
        By name; four at most.

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        There is none, or more than four.
    """
    if not 1 <= len(limits) <= len(_LINES):
        raise ValueError(f"limits must be one to {len(_LINES)}, got {len(limits)}")
    from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter

    figure = style.new_figure(180.0, 80.0)
    left, right = figure.subplots(1, 2)
    for line, (name, found) in zip(_LINES, limits.items(), strict=False):
        left.plot(found.rates, found.chatter, marker="o", markersize=3.0, linewidth=1.2, label=name, **line)
        right.plot(found.rates, found.iae / kPa, marker="o", markersize=3.0, linewidth=1.2, **line)
        if found.limit is not None and found.limit > found.rates[0]:  # else it settles nowhere
            left.axvline(found.limit, linewidth=0.9, **line)
    threshold = next(iter(limits.values())).threshold
    left.axhline(threshold, color=style.LOAD_COLOUR, linewidth=0.9)
    left.text(
        0.02,
        threshold + 0.02,
        "no longer settles",
        fontsize=style.FONT_SIZE - 1.0,
        transform=left.get_yaxis_transform(),
    )
    top = max(float(np.max(found.chatter)) for found in limits.values())
    left.set_ylim(0.0, max(1.05, 1.05 * top))
    right.set_yscale("log")
    right.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    right.yaxis.set_major_formatter(ScalarFormatter())
    right.yaxis.set_minor_formatter(NullFormatter())
    for ax in (left, right):
        ax.set_xscale("log")
    style.finish(left, "learning rate of all weights", "rms command, target still")
    style.finish(right, "learning rate of all weights", "integral of |error| [kPa s]")
    figure.legend(
        *left.get_legend_handles_labels(), loc="outside upper center", ncols=4, frameon=False, fontsize=style.FONT_SIZE
    )
    return figure


def _legend(ax: Axes, columns: int) -> None:
    ax.legend(
        loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=columns, frameon=False, fontsize=style.FONT_SIZE - 1.0
    )
