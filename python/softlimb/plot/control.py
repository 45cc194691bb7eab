"""Pictures of control: pressures, commands, weights; learning rates and where they fail; the tip's path; a film."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from softlimb.arguments import one_positive
from softlimb.control import LearningLimit, PostureRun, Trace
from softlimb.plot import style
from softlimb.plot.limb import colour_bar, side_view
from softlimb.units import kPa, mm

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array: TypeAlias = NDArray[np.float64]

_LINES: tuple[dict[str, Any], ...] = (
    {"color": "#1f4e79", "linestyle": "-"},
    {"color": "#c05a00", "linestyle": "--"},
    {"color": "#5b8c5a", "linestyle": ":"},
    {"color": "black", "linestyle": "-."},
)
_MOST_POINTS = 4000  # of a line: more than the picture has pixels


def pressure_control(trace: Trace, channels: Sequence[int] = (0,), *, title: str | None = None) -> Figure:
    """Pressures with their targets, valve commands, and weights, over time.

    Parameters
    ----------
    trace : Trace
    channels : sequence of int
        Actuators to show, from 0 in flat order; four at most. Weights are those of the first.
    title : str, optional
        Which controller, signal and disturbance these are, which the trace does not know.

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
        pressures.plot(time, trace.pressures[::step, channel] / kPa, linewidth=1.2, label=f"actuator {channel}", **line)
        commands.plot(time, trace.commands[::step, channel], linewidth=0.8, **line)
    pressures.plot([], [], color="0.55", linewidth=2.6, alpha=0.6, label="target")
    for number, line in enumerate(_LINES[:3]):
        weights.plot(time, trace.weights[::step, channels[0], number], linewidth=1.2, label=f"w{number + 1}", **line)
    weights.set_yscale("symlog", linthresh=0.1)
    style.finish(pressures, "", "gauge pressure [kPa]")
    style.finish(commands, "", "command")
    commands.set_ylim(-1.1, 1.1)
    style.finish(weights, "time [s]", f"weights, actuator {channels[0]}")
    for ax in (pressures, weights):
        _legend(ax, 5)
    for fault in trace.faults:
        for ax in (pressures, commands):
            ax.axvline(fault.time, color=style.LOAD_COLOUR, linewidth=1.2)
    if title is not None:
        figure.suptitle(title, fontsize=style.FONT_SIZE + 1.0, x=0.01, ha="left")
    if trace.faults:
        figure.supxlabel(trace.faults[0].message, color=style.LOAD_COLOUR, fontsize=style.FONT_SIZE, x=0.01, ha="left")
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


def tip_path(runs: Mapping[str, PostureRun]) -> Figure:
    """The tip's way in space beside the one that was wanted, and its distance from there over time.

    Parameters
    ----------
    runs : mapping of str to PostureRun
        Of one task, by name; four at most. Settling is left out.

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        There is none, more than four, or they are of different tasks.
    """
    if not 1 <= len(runs) <= len(_LINES):
        raise ValueError(f"runs must be one to {len(_LINES)}, got {len(runs)}")
    tasks = {run.task.name for run in runs.values()}
    if len(tasks) > 1:
        raise ValueError(f"runs must be of one task, got {', '.join(sorted(tasks))}")
    figure = style.new_figure(180.0, 95.0, constrained=False)
    space = figure.add_axes((0.0, 0.02, 0.46, 0.88), projection="3d")
    time = figure.add_axes((0.6, 0.15, 0.38, 0.74))
    first = next(iter(runs.values()))
    wanted = first.wanted[first.time > 0.0] / mm
    space.plot(*wanted.T, color="0.55", linewidth=3.0, alpha=0.6, label="wanted")
    vented: list[str] = []
    for line, (name, run) in zip(_LINES, runs.items(), strict=False):
        rows = run.time > 0.0
        space.plot(*(run.tip[rows, :3, 3] / mm).T, linewidth=1.2, label=name, **line)
        time.plot(run.time[rows], run.distances[rows] / mm, linewidth=1.2, **line)
        if run.faults:  # from there on nobody controls, and the limb hangs by itself
            end = run.faults[0].time
            at = int(np.argmin(np.abs(run.time - end)))
            time.plot(end, run.distances[at] / mm, marker="X", markersize=7.0, linestyle="none", color=line["color"])
            vented.append(f"{name}: vented at {end:.2f} s")
    top = 1.16 * time.get_ylim()[1]
    time.set_ylim(0.0, top)
    # room for the last phase's name
    time.set_xlim(0.0, max(1.12 * first.task.seconds, *(float(run.time[-1]) for run in runs.values())))
    for number, (start, phase) in enumerate(first.task.phases):  # names in two rows: phases may be short
        time.axvline(start, color="0.6", linewidth=0.8, linestyle=":")
        text = time.annotate(
            phase, (start, (1.0 - 0.05 * (number % 2)) * top), (2.5, 0.0), textcoords="offset points",
            fontsize=style.FONT_SIZE - 2.0, va="top",
        )  # fmt: skip
        text.set_bbox({"facecolor": "white", "edgecolor": "none", "pad": 0.4})  # the next phase's line may pass behind
    if vented:
        time.set_title("\n".join(vented), color=style.LOAD_COLOUR, fontsize=style.FONT_SIZE - 1.0, loc="left")
    style.finish(time, "time [s]", "distance of tip from target [mm]")
    _finish_space(space, first)
    figure.legend(
        *space.get_legend_handles_labels(), loc="upper left", ncols=5, frameon=False, fontsize=style.FONT_SIZE
    )
    return figure


def _finish_space(ax: Any, run: PostureRun) -> None:
    for name in "xyz":
        getattr(ax, f"set_{name}label")(f"{name} [mm]", fontsize=style.FONT_SIZE, labelpad=1.0)
        getattr(ax, f"{name}axis").pane.set_facecolor("white")
    ax.tick_params(labelsize=style.FONT_SIZE - 2.0, pad=0.0)
    ax.locator_params(nbins=5)
    ax.view_init(elev=22.0, azim=-58.0)
    spans = [np.ptp(getattr(ax, f"get_{name}lim")()) for name in "xyz"]
    # equal scales, but a level path keeps a height to be seen in
    box = np.maximum(spans, 0.35 * max(spans))
    stretched = [f"{name} x {times:.2g}" for name, times in zip("xyz", box / spans, strict=True) if times > 1.05]
    if stretched:
        ax.text2D(
            0.98, 0.02, f"drawn larger: {', '.join(stretched)}", transform=ax.transAxes, ha="right",
            fontsize=style.FONT_SIZE - 2.0,
        )  # fmt: skip
    ax.set_box_aspect(box, zoom=0.88)
    if run.postures[0].loads["gravity"][2] > 0.0:
        ax.invert_zaxis()


def animation(run: PostureRun, path: str | Path, *, speed: float = 1.0) -> Path:
    """Write the limb's motion as a GIF: two views from the side, the target, and the way of the tip so far.

    Parameters
    ----------
    run : PostureRun
        Its ``kept`` says how many pictures there are: every fifth outer step is ten a second.
    path : str or Path
        Ends in ``.gif``.
    speed : float
        How much faster than life.

    Returns
    -------
    Path

    Raises
    ------
    ValueError
        Another ending, or a speed that is not positive.

    Notes
    -----
    In the axes of the true base. Colours show pressure, from pale to dark, on one scale for all pictures. After a fault
    the title says "vented" in place of the phase.
    """
    from matplotlib.animation import PillowWriter

    path = Path(path)
    if path.suffix.lower() != ".gif":
        raise ValueError(f"an animation must be written to a .gif, got {path.name!r}")
    count = len(run.postures)
    at = np.arange(count) * run.kept
    shown = [k for k in range(count) if run.time[at[k]] > 0.0 and run.postures[k].success]
    if not shown:
        raise ValueError("there is no posture of the task to show")
    wanted, tips = (run.wanted @ run.base) / mm, (run.tip[:, :3, 3] @ run.base) / mm
    highest = 10.0 * kPa * float(np.ceil(max(float(run.pressures.max()), 1.0) / (10.0 * kPa)))
    limits = _common_limits(run, shown, wanted)
    hangs = run.postures[0].loads["gravity"][2] > 0.0
    frame_time = run.kept * (run.time[1] - run.time[0])
    writer = PillowWriter(fps=max(1, round(one_positive("speed", speed) / frame_time)))
    figure = style.new_figure(160.0, 120.0, constrained=False)
    views = [figure.add_axes((0.1 + 0.42 * axis, 0.11, 0.33, 0.73)) for axis in (0, 1)]
    colour_bar(figure, figure.add_axes((0.905, 0.25, 0.014, 0.45)), highest / kPa)
    vented = run.faults[0] if run.faults else None
    marks: tuple[tuple[str, dict[str, Any]], ...] = (
        ("path wanted", {"color": "0.45", "linewidth": 0.8, "linestyle": ":"}),
        ("path of the tip", {"color": style.PREDICTED["color"], "linewidth": 1.2}),
        ("wanted now", {"color": style.LOAD_COLOUR, "marker": "x", "markersize": 7.0, "linestyle": "none"}),
        ("load", {"color": "black", "marker": "v", "markersize": 7.0, "linestyle": "none"}),
    )
    task_time = run.time > 0.0
    with writer.saving(figure, str(path), dpi=_FILM_DOTS_PER_INCH):
        for k in shown:
            now = int(at[k])
            for axis, ax in enumerate(views):
                ax.clear()
                side_view(run.postures[k], ax, axis, highest=highest)
                drawn = {
                    "path wanted": wanted[task_time],
                    "path of the tip": tips[task_time & (np.arange(len(tips)) <= now)],
                    "wanted now": wanted[[now]],
                    "load": tips[[now]] if run.load[now].any() else np.empty((0, 3)),
                }
                lines = [ax.plot(*drawn[name][:, [axis, 2]].T, **look)[0] for name, look in marks]
                ax.set_xlim(*limits[axis])
                ax.set_ylim(*(limits[2][::-1] if hangs else limits[2]))
            if figure.legends:
                figure.legends[0].remove()
            names = [name for name, _ in marks]
            figure.legend(
                lines, names, loc="upper left", bbox_to_anchor=(0.02, 0.945), ncols=4, frameon=False,
                fontsize=style.FONT_SIZE - 1.0,
            )  # fmt: skip
            over = vented is not None and run.time[now] >= vented.time
            phase = [name for start, name in run.task.phases if start <= run.time[now]]
            now_on = "vented" if over else phase[-1] if phase else "task"
            load = f", load {np.linalg.norm(run.load[now]):.2g} N" if run.load[now].any() else ""
            figure.suptitle(
                f"{run.task.name}: {run.time[now]:4.1f} s, {now_on}{load}",
                fontsize=style.FONT_SIZE + 1.0,
                color=style.LOAD_COLOUR if over else "black",
                x=0.03,
                ha="left",
            )
            writer.grab_frame()
    return path


_FILM_DOTS_PER_INCH = 110


def _common_limits(run: PostureRun, shown: Sequence[int], wanted: Array) -> Array:
    """What all pictures show, (3, 2) [mm]; x and y alike, so that both views have one scale."""
    points = np.concatenate([run.postures[k].centreline(20) for k in shown]) / mm
    points = np.concatenate([points, wanted[run.time > 0.0], np.zeros((1, 3))])
    # beside the centreline the tubes, beyond its end the tip's plate
    widest = max(segment.ring_radius or 0.0 for segment in run.postures[0].limb.segments)
    margin = 2.5 * widest / mm + 10.0
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    across = max(high[0] - low[0], high[1] - low[1])
    middle = 0.5 * (low + high)
    low[:2], high[:2] = middle[:2] - 0.5 * across, middle[:2] + 0.5 * across
    return np.stack([low, high], axis=1)


def _legend(ax: Axes, columns: int) -> None:
    ax.legend(
        loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=columns, frameon=False, fontsize=style.FONT_SIZE - 1.0
    )
