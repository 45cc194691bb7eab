"""What a search for pressures found: the limb beside its target, and each pressure between its bounds."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from softlimb.plot import style
from softlimb.plot.limb import hull, outline_of_tip, side_view, ticks
from softlimb.units import deg, kPa, mm

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from softlimb.reach import Reach

Array: TypeAlias = NDArray[np.float64]

_WIDTH, _HEIGHT = 180.0, 100.0  # of the figure [mm]
_BOTTOM, _TALL = 0.14, 0.68  # of all axes, as parts of the height; above them the outcome and the legend
_VIEWS, _BARS = (0.075, 0.56), (0.735, 0.25)  # where they start, and how wide they may be, as parts of the width
_GAP = 0.075
_MARGIN = 0.06  # around a target outside the limb, of the picture's longer side


def reach(found: Reach) -> Figure:
    """Draw the posture from two sides with the target, and the pressures between their bounds.

    Parameters
    ----------
    found : Reach

    Returns
    -------
    Figure

    Notes
    -----
    Lengths in mm, equal on both axes and in both views. A target position is a cross, a target pose the outline of the
    tip's plate as well; a line leads from the tip to a target that was missed. A limb that gravity pulls along +z is
    drawn hanging.
    """
    figure = style.new_figure(_WIDTH, _HEIGHT, constrained=False)
    posture = found.posture
    views = [figure.add_axes((0.1 + 0.3 * axis, _BOTTOM, 0.25, _TALL)) for axis in (0, 1)]
    for axis, ax in enumerate(views):
        side_view(posture, ax, axis)
        _draw_target(found, ax, axis)
    _place(views, found)
    _draw_pressures(found, figure.add_axes((_BARS[0], _BOTTOM, _BARS[1], _TALL)))
    colour = "black" if found.reached else style.LOAD_COLOUR
    figure.suptitle(_outcome(found), fontsize=style.FONT_SIZE + 1.0, color=colour, x=0.02, y=0.985, ha="left")
    handles, names = views[0].get_legend_handles_labels()
    figure.legend(
        handles, names, loc="upper left", bbox_to_anchor=(0.01, 0.94), ncols=3, frameon=False, fontsize=style.FONT_SIZE
    )
    return figure


def _outcome(found: Reach) -> str:
    error = found.error
    if found.reached:
        return "target reached"
    angle = "" if error.rotation is None else f" and {error.rotation / deg:.3g} deg"
    length = found.posture.limb.length
    return f"target missed by {error.position / mm:.3g} mm ({error.relative:.2%} of {length / mm:.4g} mm){angle}"


def _draw_target(found: Reach, ax: Axes, axis: int) -> None:
    shown = [axis, 2]
    place, tip = found.target[shown, 3] / mm, found.posture.tip[shown, 3] / mm
    if found.weights[3:].any():
        outline = hull(outline_of_tip(found.posture, found.target)[:, shown]) / mm
        ax.fill(
            *outline.T,
            facecolor="none",
            edgecolor=style.LOAD_COLOUR,
            linewidth=1.2,
            linestyle=(0, (3, 1.5)),
            zorder=6,
            label="plate at the target",
        )
    if not found.reached:
        ax.plot(
            *np.stack([tip, place]).T, color=style.LOAD_COLOUR, linewidth=1.0, linestyle=":", zorder=6, label="miss"
        )
    ax.plot(
        *place,
        color=style.LOAD_COLOUR,
        marker="x",
        markersize=8.0,
        markeredgewidth=2.0,
        linestyle="none",
        zorder=7,
        label="target",
    )


def _place(views: list[Axes], found: Reach) -> None:
    """Both views on one scale, wide enough for the target, side by side."""
    bounds = []
    for axis, ax in enumerate(views):
        low_high = []
        for limits, place in (
            (sorted(ax.get_xlim()), found.target[axis, 3] / mm),
            (sorted(ax.get_ylim()), found.target[2, 3] / mm),
        ):
            margin = _MARGIN * max(np.ptp(limits), abs(place - np.mean(limits)))
            low_high.append((min(limits[0], place - margin), max(limits[1], place + margin)))
        bounds.append(low_high)
    vertical = (min(b[1][0] for b in bounds), max(b[1][1] for b in bounds))
    widths = [b[0][1] - b[0][0] for b in bounds]
    room = (_VIEWS[1] - _GAP) * _WIDTH, _TALL * _HEIGHT
    scale = min(room[0] / sum(widths), room[1] / (vertical[1] - vertical[0]))  # mm of paper per mm
    left = _VIEWS[0] + 0.4 * (room[0] - scale * sum(widths)) / _WIDTH
    tall = scale * (vertical[1] - vertical[0]) / _HEIGHT
    for ax, (across, _), width in zip(views, bounds, widths, strict=True):
        hangs = ax.yaxis_inverted()
        ax.set_aspect("auto")
        ax.set_position((left, _BOTTOM + _TALL - tall, scale * width / _WIDTH, tall))
        ax.set_xlim(*across)
        ax.set_ylim(*(vertical[::-1] if hangs else vertical))
        # A tick label is 6 mm wide and 3 mm high on paper.
        ax.xaxis.set_major_locator(ticks(8.0 / scale, *across))
        ax.yaxis.set_major_locator(ticks(8.0 / scale, *vertical))
        left += scale * width / _WIDTH + _GAP
    views[1].set_ylabel("")
    views[1].tick_params(labelleft=False)


def _draw_pressures(found: Reach, ax: Axes) -> None:
    names = [
        f"{j}.{i}"
        for j, segment in enumerate(found.posture.limb.segments, start=1)
        for i in range(1, len(segment.actuators) + 1)
    ]
    rows = np.arange(len(names))
    low, high, values = found.min_pressures / kPa, found.max_pressures / kPa, found.pressures / kPa
    ax.barh(rows, high - low, left=low, height=0.8, color="0.92", edgecolor="0.75", linewidth=0.6, label="bounds")
    at_bound = np.isin(rows, list(found.active))
    for rows_of, face, name in ((~at_bound, style.PREDICTED["color"], "pressure"), (at_bound, "white", "at its bound")):
        if rows_of.any():
            ax.plot(
                values[rows_of],
                rows[rows_of],
                marker="o",
                markersize=6.0,
                markerfacecolor=face,
                markeredgecolor=style.PREDICTED["color"],
                linestyle="none",
                clip_on=False,
                zorder=5,
                label=name,
            )
    style.finish(ax, "gauge pressure [kPa]", "segment.actuator")
    ax.set_yticks(rows, names)
    ax.invert_yaxis()
    ax.grid(visible=False, axis="y")
    ax.legend(
        loc="lower right",
        bbox_to_anchor=(1.03, 1.0),
        ncols=2,
        frameon=False,
        fontsize=style.FONT_SIZE - 1.0,
        columnspacing=1.0,
        handletextpad=0.4,
    )
