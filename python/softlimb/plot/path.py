"""Picture of a followed path: a coordinate of the tip over the parameter, stable and unstable, with its folds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from softlimb.arguments import one_of, one_positive
from softlimb.path import Path
from softlimb.plot import style
from softlimb.units import mm

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_AXES = {"x": 0, "y": 1, "z": 2}


def path(
    followed: Path, parameter_label: str, *, coordinate: Literal["x", "y", "z"] = "z", unit: float = 1.0
) -> Figure:
    """The tip's coordinate along a path; stable postures in a full line, unstable ones in a dashed one.

    Parameters
    ----------
    followed : Path
    parameter_label : str
        Name and unit of the parameter, for the axis.
    coordinate : {"x", "y", "z"}
        Of the tip, base frame.
    unit : float
        What the parameter is divided by, for instance ``units.kPa``.

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        The path is empty, the coordinate is none of the three, or the unit is not positive.
    """
    if not isinstance(followed, Path):
        raise TypeError(f"followed must be a Path, got {type(followed).__name__}")
    one_of("coordinate", coordinate, tuple(_AXES))
    unit = one_positive("unit", unit)
    if not len(followed):
        raise ValueError(f"an empty path has no picture: {followed.message}")
    figure = style.new_figure(110.0, 80.0)
    axes = figure.subplots()
    _draw(axes, followed, _AXES[coordinate], unit)
    style.finish(axes, parameter_label, f"tip {coordinate} [mm]")
    axes.ticklabel_format(useOffset=False)
    axes.legend(fontsize=style.FONT_SIZE - 1.0, frameon=False)
    return figure


def _draw(axes: Axes, followed: Path, axis: int, unit: float) -> None:
    # Events stand between points: with them in place the line is whole and changes its dash where stability does.
    parameters, heights = list(followed.parameters), [posture.tip[axis, 3] for posture in followed.postures]
    stable = list(followed.stable)
    for shift, event in enumerate(followed.events):
        place = event.after + 1 + shift
        parameters.insert(place, event.parameter)
        heights.insert(place, event.posture.tip[axis, 3])
        stable.insert(place, True)
    x, y = np.array(parameters) / unit, np.array(heights) / mm
    events = {event.after + 1 + shift for shift, event in enumerate(followed.events)}
    labelled: set[bool] = set()
    start = 0
    for place in range(1, len(x)):
        last = place == len(x) - 1
        if place not in events and not last:
            continue
        inside = stable[start + 1] if start in events and start + 1 < len(x) else stable[start]
        axes.plot(
            x[start : place + 1],
            y[start : place + 1],
            color=style.PREDICTED["color"] if inside else "#8a8a8a",
            linewidth=1.8 if inside else 1.4,
            linestyle="-" if inside else "--",
            label=None if inside in labelled else ("stable" if inside else "unstable"),
        )
        labelled.add(inside)
        start = place
    for kind, marker in (("fold", "o"), ("bifurcation", "s")):
        found = [event for event in followed.events if event.kind == kind]
        if not found:
            continue
        axes.plot(
            [event.parameter / unit for event in found],
            [event.posture.tip[axis, 3] / mm for event in found],
            color=style.LOAD_COLOUR,
            marker=marker,
            markersize=5.0,
            linestyle="none",
            label=kind,
        )
