"""Pictures of one tube: stress through the wall, elongation over pressure, stiffness over pressure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from softlimb.plot import style
from softlimb.tube import Tube, TubeState
from softlimb.units import kPa, mm

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Lines that lie in one picture differ in dash and in lightness, so that a grey print keeps them apart.
_LINES: list[dict[str, Any]] = [
    {"color": "#12263a", "linewidth": 1.8, "linestyle": "-"},
    {"color": "#c2410c", "linewidth": 1.8, "linestyle": "--"},
    {"color": "#3d7ea6", "linewidth": 1.8, "linestyle": "-."},
    {"color": "#8a8a8a", "linewidth": 1.8, "linestyle": ":"},
]
_LAYER_SHADES = ["#ffffff", "#e9eef3"]


def wall_stress(state: TubeState) -> Figure:
    """Cauchy stress through the wall: the silicone's range of a few kPa enlarged beside the whole.

    Fibres pull a thousand times harder than silicone; on one scale the silicone would lie on the axis.

    Parameters
    ----------
    state : TubeState
        One state of the thick-walled model.

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        The state holds several, or is not of the thick-walled model.
    """
    stress = state.stress()
    figure = style.new_figure(170.0, 85.0)
    whole, near = figure.subplots(1, 2, sharex=True)
    components = [("hoop", stress.hoop), ("axial", stress.axial), ("radial", stress.radial)]
    if np.max(np.abs(stress.shear)) > 1e-9 * np.max(np.abs(stress.hoop)):
        components.append(("shear", stress.shear))
    points = 25  # a layer, as `TubeState.stress` gives them
    for axes in (whole, near):
        for i in range(len(state.tube.layers)):
            part = slice(points * i, points * (i + 1))
            edges = stress.radius[part] / mm
            axes.axvspan(edges[0], edges[-1], color=_LAYER_SHADES[i % 2], zorder=0)
            for (name, values), line in zip(components, _LINES, strict=False):
                axes.plot(edges, values[part] / kPa, label=name if i == 0 else None, **line)
        style.finish(axes, "deformed radius [mm]", "Cauchy stress [kPa]")
        axes.set_xlim(stress.radius[0] / mm, stress.radius[-1] / mm)
    # The scale of the silicone: where no fibres are, or else the radial stress.
    bare = [i for i, layer in enumerate(state.tube.layers) if not layer.fibres]
    chosen = np.concatenate([np.arange(points * i, points * (i + 1)) for i in bare] or [np.arange(stress.radius.size)])
    shown = np.concatenate([values[chosen] for _, values in components] + [stress.radial]) / kPa
    low, high = float(shown.min()), float(shown.max())
    margin = 0.12 * (high - low) + 1e-9
    near.set_ylim(low - margin, high + margin)
    whole.set_title("whole range", fontsize=style.FONT_SIZE)
    near.set_title("enlarged to the stress in the silicone", fontsize=style.FONT_SIZE)
    whole.legend(fontsize=style.FONT_SIZE - 1.0, frameon=False)
    figure.suptitle(f"{state.pressure / kPa:.4g} kPa, stretch {state.stretch:.4g}", fontsize=style.FONT_SIZE + 1.0)
    return figure


def elongation(
    tubes: Tube | Sequence[Tube], pressures: NDArray[np.float64], ax: Axes, *, labels: Sequence[str] | None = None
) -> Axes:
    """Elongation over pressure of one tube or several; it ends where a tube has no stable state.

    Parameters
    ----------
    tubes : Tube or sequence of Tube
    pressures : ndarray
        [Pa]
    ax : matplotlib axes
    labels : sequence of str, optional
        One a tube.

    Returns
    -------
    Axes

    Raises
    ------
    ValueError
        There are not as many labels as tubes.
    """
    several = [tubes] if isinstance(tubes, Tube) else list(tubes)
    if labels is not None and len(labels) != len(several):
        raise ValueError(f"labels has {len(labels)} entries but there are {len(several)} tubes")
    for i, tube in enumerate(several):
        state = tube.inflate(pressures)
        values = np.where(state.success, (state.stretch - 1.0) * 100.0, np.nan)
        ax.plot(pressures / kPa, values, label=labels[i] if labels else None, **_LINES[i % len(_LINES)])
        if not np.all(state.success):
            last = np.flatnonzero(state.success)[-1] if np.any(state.success) else 0
            ax.plot(pressures[last] / kPa, values[last], marker="x", color="#12263a", markersize=6.0)
    style.finish(ax, "pressure [kPa]", "elongation [%]")
    if labels:
        ax.legend(fontsize=style.FONT_SIZE - 1.0, frameon=False)
    return ax


def stiffness(tube: Tube, pressures: NDArray[np.float64]) -> Figure:
    """EA and EI of the section over pressure beside the paper's constants.

    Parameters
    ----------
    tube : Tube
    pressures : ndarray
        [Pa], each with a stable state.

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        A pressure without a section.
    """
    figure = style.new_figure(170.0, 75.0)
    sections = [tube.section(float(p)) for p in pressures]
    locked = [tube.section(float(p), valve="locked") for p in pressures]
    paper = tube.section(0.0, model="paper")
    left, right = figure.subplots(1, 2)
    left.plot(pressures / kPa, [s.axial for s in sections], label="valve open", **_LINES[0])
    left.plot(pressures / kPa, [s.axial for s in locked], label="valve locked", **_LINES[1])
    left.axhline(paper.axial, label="the paper's constant", **_LINES[3])
    left.set_yscale("log")
    style.finish(left, "pressure [kPa]", "EA [N]")
    right.plot(pressures / kPa, [s.bending for s in sections], label="at this pressure", **_LINES[0])
    right.axhline(paper.bending, label="the paper's constant", **_LINES[3])
    right.set_ylim(bottom=0.0)
    style.finish(right, "pressure [kPa]", "EI [N m$^2$]")
    for axes in (left, right):
        axes.legend(fontsize=style.FONT_SIZE - 1.0, frameon=False)
    return figure


def ballooning(tube: Tube, largest_radius: float, ax: Axes) -> Axes:
    """Pressure over the inner radius under volume control, stable part and what lies beyond the limit point.

    Parameters
    ----------
    tube : Tube
    largest_radius : float
        Deformed inner radius up to which the volume grows [m].
    ax : matplotlib axes

    Returns
    -------
    Axes
    """
    state = tube.inflate_volume(inner_radius=np.linspace(tube.inner_radius, largest_radius, 150))
    radius, pressure = state.inner_radius / mm, state.pressure / kPa
    beyond = state.success & ~state.stable
    ax.plot(np.where(state.stable, radius, np.nan), pressure, label="stable under given pressure", **_LINES[0])
    ax.plot(np.where(beyond, radius, np.nan), pressure, label="only under given volume", **_LINES[1])
    if tube.limit_pressure is not None:
        ax.axhline(tube.limit_pressure / kPa, color="0.5", linewidth=0.8)
        ax.annotate(f"limit point {tube.limit_pressure / kPa:.1f} kPa", (radius[-1], tube.limit_pressure / kPa),
                    ha="right", va="bottom", fontsize=style.FONT_SIZE - 1.0)
    style.finish(ax, "inner radius [mm]", "pressure [kPa]")
    ax.legend(fontsize=style.FONT_SIZE - 1.0, frameon=False)
    return ax
