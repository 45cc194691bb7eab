"""What a search for pressures found: the limb beside its target, and each pressure between its bounds."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from softlimb.plot import style
from softlimb.plot.limb import hull, outline_of_tip, side_view, ticks
from softlimb.reach import distance_in_words
from softlimb.units import kPa, mm

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from softlimb.reach import Reach

Array: TypeAlias = NDArray[np.float64]

_WIDTH, _HEIGHT = 180.0, 100.0  # of the figure [mm]
_BOTTOM, _TALL = 0.14, 0.68  # of all axes, as parts of the height; above them the outcome and the legend
_VIEWS, _BARS = (0.075, 0.56), (0.735, 0.25)  # where they start, and how wide they may be, as parts of the width
_GAP = 0.075
_MARGIN = 3.0  # around a target outside the limb [mm on paper]: half its cross and some air
_FAR = 3.0  # times the limb's length: at the scale of a target farther away the limb would be a speck
_ARROW = 0.4  # of the limb's length, towards a far target
_SHORTEST_ARROW = 0.06  # of the limb's length: seen shorter than that it would be all head


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
    tip's plate as well; a line leads from the tip to a target that was missed. One that was missed by more than three
    lengths of the limb is an arrow from the tip towards it (in the view along it a dot), and its distance is in the
    legend. A limb that gravity pulls along +z is drawn hanging.
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
    if found.reached:
        return "target reached"
    return f"target missed by {found.error.in_words(found.posture.limb.length)}"


def _shown_target(found: Reach) -> tuple[Array, bool]:
    """Where the target is drawn, shape (3,) [m], and whether it is too far away to be drawn at its place."""
    place, tip = found.target[:3, 3], found.posture.tip[:3, 3]
    if found.error.relative <= _FAR:
        return place, False
    way = (place - tip) / np.abs(place - tip).max()  # squares of what is very far overflow
    return tip + _ARROW * found.posture.limb.length * way / np.linalg.norm(way), True


def _draw_target(found: Reach, ax: Axes, axis: int) -> None:
    shown = [axis, 2]
    where, far = _shown_target(found)
    place, tip = where[shown] / mm, found.posture.tip[shown, 3] / mm
    if far:
        colour, ends = style.LOAD_COLOUR, (tuple(place), tuple(tip))
        name = f"to the target, {distance_in_words(found.error.position)} away"
        ax.plot(*np.stack([tip, place]).T, color=colour, linewidth=1.6, zorder=7, label=name)
        if np.linalg.norm(place - tip) * mm > _SHORTEST_ARROW * found.posture.limb.length:
            head = {"arrowstyle": "-|>", "color": colour, "linewidth": 1.6, "shrinkA": 0.0, "shrinkB": 0.0}
            ax.annotate("", *ends, zorder=7, arrowprops=head)
        else:
            ax.plot(*tip, color=colour, marker="o", markersize=5.0, zorder=7)
        return
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
    target = _shown_target(found)[0] / mm
    limits = [(*sorted(ax.get_xlim()), target[axis]) for axis, ax in enumerate(views)]
    limits += [(*sorted(ax.get_ylim()), target[2]) for ax in views]
    room = (_VIEWS[1] - _GAP) * _WIDTH, _TALL * _HEIGHT
    margin = 0.0
    for _ in range(2):  # the margin on paper is known once the scale is, which it changes little
        bounds = [(min(low, place - margin), max(high, place + margin)) for low, high, place in limits]
        vertical = (min(low for low, _ in bounds[2:]), max(high for _, high in bounds[2:]))
        widths = [high - low for low, high in bounds[:2]]
        scale = min(room[0] / sum(widths), room[1] / (vertical[1] - vertical[0]))  # mm of paper per mm
        margin = _MARGIN / scale
    left = _VIEWS[0] + 0.4 * (room[0] - scale * sum(widths)) / _WIDTH
    tall = scale * (vertical[1] - vertical[0]) / _HEIGHT
    for ax, across, width in zip(views, bounds[:2], widths, strict=True):
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
