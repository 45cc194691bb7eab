"""Pictures of a workspace: the cloud with its projections, density, slices, settling; and payloads by direction."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from softlimb.arguments import one_of, one_whole
from softlimb.plot import style
from softlimb.units import deg, kPa, mm

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from softlimb.payload import PayloadRose
    from softlimb.workspace import Workspace
    from softlimb.workspace.cloud import AxisName

Array: TypeAlias = NDArray[np.float64]

_WIDTH, _HEIGHT = 180.0, 135.0  # of the figure [mm]
_DRAWN = 8000  # tips in a scatter; more only make the file larger
_BINS = 60  # along the longest side of a density picture
_TILT = "cividis_r"  # pale to dark as the tip turns over: the value can be read from a grey print as well
_DENSITY = "Greys"
_PALEST = 0.15  # part of that map where it starts: a single posture must be seen on white
_SHADOW = "0.72"
_LIMITS: dict[str, tuple[str, str]] = {
    "fold": ("o", "fold"),
    "bifurcation": ("s", "bifurcation"),
    "deflection": ("D", "deflection"),
    "pressure": ("^", "pressure limit"),
    "force": ("v", "end of the search: carries more"),
    "lost": ("X", "path lost: may carry more"),
}


def workspace(found: Workspace) -> Figure:
    """Cloud of tips with its projections, density of postures from two sides, and three slices across z.

    Parameters
    ----------
    found : Workspace

    Returns
    -------
    Figure

    Notes
    -----
    Lengths in mm, equal on both axes of a picture. Density counts postures, which shows how pressures were sampled as
    much as the limb. A cloud of more than 8000 tips is drawn by an even selection of them; sizes count all. A limb
    that gravity pulls along +z is drawn hanging.
    """
    if not len(found):
        raise ValueError(f"an empty workspace has no picture: {found.message}")
    figure = style.new_figure(_WIDTH, _HEIGHT, constrained=False)
    _draw_cloud(found, figure.add_axes((-0.025, 0.46, 0.385, 0.5), projection="3d"))
    views = [figure.add_axes((left, 0.54, 0.185, 0.38)) for left in (0.495, 0.71)]
    drawn = _draw_density(found, views)
    _bar(figure, drawn, (0.915, 0.61, 0.012, 0.26), "postures in a column")
    slices = [figure.add_axes((left, 0.08, 0.225, 0.36)) for left in (0.085, 0.37, 0.655)]
    tilted = slices_across(found, slices)
    _bar(figure, tilted, (0.915, 0.13, 0.012, 0.26), "tilt of the tip [deg]")
    volume = found.volume
    x, y, z = found.extents / mm
    low, high = (bound / kPa for bound in found.pressure_range)
    figure.suptitle(
        f"{len(found):,} postures at {low.min():.3g} to {high.max():.3g} kPa: box {x:.0f} x {y:.0f} x {z:.0f} mm,\n"
        f"volume {volume.size:.3g} ± {volume.error:.2g} m³ (voxels of {volume.cell / mm:.0f} mm)",
        fontsize=style.FONT_SIZE + 0.5,
        x=0.02,
        y=0.985,
        ha="left",
    )
    return figure


def _bar(figure: Figure, drawn: Any, place: tuple[float, float, float, float], label: str) -> None:
    bar = figure.colorbar(drawn, cax=figure.add_axes(place))
    bar.set_label(label, fontsize=style.FONT_SIZE)
    bar.ax.tick_params(labelsize=style.FONT_SIZE - 1.0)


def _hangs(found: Workspace) -> bool:
    return bool(np.asarray(found.batch.scene.get("gravity", (0.0, 0.0, 0.0)))[2] > 0.0)


def _some(tilt: Array) -> NDArray[np.int64]:
    """Numbers of the tips to draw, spread evenly over all; the steepest come last and lie on top."""
    chosen = np.unique(np.linspace(0, max(len(tilt) - 1, 0), min(len(tilt), _DRAWN)).astype(np.int64))
    ordered: NDArray[np.int64] = chosen[np.argsort(tilt[chosen], kind="stable")]
    return ordered


def _window(found: Workspace) -> Array:
    """Limits of x, y, z in mm with a margin, the sides of x and y alike, shape (2, 3)."""
    low, high = found.box / mm
    sides = np.maximum(high - low, 10.0)  # a line or a point is drawn 10 mm wide
    sides[:2] = sides[:2].max()
    middle, half = 0.5 * (low + high), 0.55 * sides
    return np.stack([middle - half, middle + half])


def _tilt_colours(found: Workspace) -> dict[str, Any]:
    """One scale of the tilt in degrees for all pictures of a workspace, as arguments of a scatter."""
    return {"cmap": _TILT, "vmin": 0.0, "vmax": found.tilt_range[1] / deg, "edgecolors": "none"}


def _draw_cloud(found: Workspace, ax: Any) -> None:
    some, window, hangs = _some(found.tilt), _window(found), _hangs(found)
    tips = found.positions[some] / mm
    # The walls behind the cloud, as the viewer stands.
    walls = (window[0, 0], window[1, 1], window[1, 2] if hangs else window[0, 2])
    for axis, wall in enumerate(walls):
        shadow = tips.copy()
        shadow[:, axis] = wall
        ax.scatter(*shadow.T, s=0.4, color=_SHADOW, edgecolors="none", depthshade=False, rasterized=True)
    ax.scatter(*tips.T, c=found.tilt[some] / deg, s=0.8, depthshade=False, rasterized=True, **_tilt_colours(found))
    for name, limits in zip("xyz", window.T, strict=True):
        low, high = limits[::-1] if hangs and name == "z" else limits
        getattr(ax, f"set_{name}lim")(low, high)
        getattr(ax, f"set_{name}label")(f"{name} [mm]", fontsize=style.FONT_SIZE - 1.0, labelpad=-3.0)
        getattr(ax, f"{name}axis").set_major_locator(_ticks(4))
    ax.tick_params(labelsize=style.FONT_SIZE - 2.0, pad=-2.0)
    ax.set_box_aspect(np.ptp(window, axis=0), zoom=0.88)
    ax.view_init(elev=18.0, azim=-55.0)


def _ticks(count: int) -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(nbins=count, steps=[1, 2, 5, 10])


def _draw_density(found: Workspace, views: Sequence[Axes]) -> Any:
    """How many postures lie behind each square, seen along y and along x."""
    import matplotlib
    from matplotlib.colors import ListedColormap, LogNorm

    window = _window(found)
    edge = float(np.ptp(window, axis=0).max()) / _BINS
    counts, edges = [], []
    for axis in (0, 1):
        across, up = (np.arange(window[0, a], window[1, a] + edge, edge) for a in (axis, 2))
        tips = found.positions / mm
        count, *at = np.histogram2d(tips[:, axis], tips[:, 2], bins=(across, up))
        counts.append(np.ma.masked_equal(count, 0.0))
        edges.append(at)
    shades = ListedColormap(matplotlib.colormaps[_DENSITY](np.linspace(_PALEST, 1.0, 256)))
    scale = LogNorm(1.0, max(float(max(count.max() for count in counts)), 2.0))
    for axis, ax in enumerate(views):
        drawn = ax.pcolormesh(*edges[axis], counts[axis].T, cmap=shades, norm=scale, rasterized=True)
        style.finish(ax, f"tip {'xy'[axis]} [mm]", "tip z [mm]" if axis == 0 else "")
        _place(ax, window[:, axis], window[:, 2], _hangs(found))
        ax.set_title(f"density seen along {'yx'[axis]}", fontsize=style.FONT_SIZE)
    views[1].tick_params(labelleft=False)
    return drawn


def slices_across(found: Workspace, views: Sequence[Axes], axis: AxisName = "z") -> Any:
    """Draw slabs of the cloud at even distances across an axis, tips coloured by their tilt.

    Parameters
    ----------
    found : Workspace
    views : sequence of matplotlib axes
        One a slice, from low to high.
    axis : {"x", "y", "z"}

    Returns
    -------
    PathCollection
        What a colour bar is made of [deg].
    """
    one_of("axis", axis, ("x", "y", "z"))
    normal = "xyz".index(axis)
    others = [a for a in range(3) if a != normal]
    window = _window(found)
    low, high = found.box[:, normal]
    for number, ax in enumerate(views, start=1):
        part = found.slice(axis, low + (high - low) * number / (len(views) + 1))
        tilt = found.tilt[np.searchsorted(found.rows, part.rows)]
        order = _some(tilt)
        drawn = ax.scatter(
            part.points[order, 0] / mm,
            part.points[order, 1] / mm,
            c=tilt[order] / deg,
            s=4.0,
            rasterized=True,
            **_tilt_colours(found),
        )
        style.finish(ax, f"tip {'xyz'[others[0]]} [mm]", f"tip {'xyz'[others[1]]} [mm]" if number == 1 else "")
        _place(ax, window[:, others[0]], window[:, others[1]], others[1] == 2 and _hangs(found))
        ax.set_title(
            f"{axis} = {part.at / mm:.0f} ± {0.5 * part.thickness / mm:.0f} mm: {part.area.size:.2g} m²",
            fontsize=style.FONT_SIZE,
        )
        if number > 1:
            ax.tick_params(labelleft=False)
    return drawn


def _place(ax: Axes, across: Array, up: Array, hangs: bool) -> None:
    ax.set_xlim(*across)
    ax.set_ylim(*(up[::-1] if hangs else up))
    ax.set_aspect("equal")
    ax.xaxis.set_major_locator(_ticks(5))
    ax.yaxis.set_major_locator(_ticks(5))


def settling(found: Workspace, *, steps: int = 6) -> Figure:
    """How volume, hull and box settle while the number of samples doubles.

    Parameters
    ----------
    found : Workspace
    steps : int
        How often the number of samples is halved.

    Returns
    -------
    Figure
        Volume by voxels with its error, the hull's where scipy is installed, and the sides of the box; without the edge
        rows, whose values are the lines across.
    """
    from importlib.util import find_spec

    steps = one_whole("steps", steps, 1)
    counts = [found.samples // 2**step for step in range(steps, -1, -1) if found.samples // 2**step >= 4]
    if not counts:
        raise ValueError(f"at least 4 samples are needed to see them settle, got {found.samples}")
    parts = [found.first(count) for count in counts]
    figure = style.new_figure(170.0, 80.0)
    left, right = figure.subplots(1, 2)
    volumes = [part.volume for part in parts]
    left.errorbar(
        counts,
        [volume.size for volume in volumes],
        [volume.error for volume in volumes],
        color=style.PREDICTED["color"],
        marker="o",
        markersize=4.0,
        capsize=2.5,
        label="voxels, with their error",
    )
    if find_spec("scipy") is not None:
        left.plot(counts, [part.hull_volume for part in parts], color="0.45", marker="s", markersize=4.0, label="hull")
        left.axhline(found.hull_volume, color="0.45", linestyle=":", label="hull with edge rows")
    left.set_ylim(bottom=0.0)
    for axis, (name, line, marker) in enumerate((("x", "--", "s"), ("y", ":", "^"), ("z", "-", "o"))):
        shade = ("#8c8c8c", "#5a7fa6", "#1f4e79")[axis]
        right.plot(
            counts,
            [part.extents[axis] / mm for part in parts],
            linestyle=line,
            marker=marker,
            markersize=4.0,
            color=shade,
            label=f"side along {name}",
        )
        lines = "with edge rows" if axis == 2 else None
        right.axhline(found.extents[axis] / mm, color=shade, linewidth=0.8, label=lines)
    for ax, label in ((left, "volume [m³]"), (right, "side of the box [mm]")):
        style.finish(ax, "samples", label)
        ax.set_xscale("log", base=2)
        ax.set_xticks(counts, [f"{count}" for count in counts], rotation=30.0)
        ax.minorticks_off()
        ax.legend(fontsize=style.FONT_SIZE - 1.0, frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    return figure


def payload_rose(*found: PayloadRose, names: Sequence[str] = ()) -> Figure:
    """The largest tip force by its direction in a plane, one closed line a rose.

    Parameters
    ----------
    *found : PayloadRose
        In the same plane.
    names : sequence of str
        One a rose, for the legend.

    Returns
    -------
    Figure
        Markers say what ends each payload; those beyond which the limb may carry more are hollow.

    Raises
    ------
    ValueError
        No rose, planes that differ, or not one name each.
    """
    if not found:
        raise ValueError("a picture of payloads needs at least one rose, got none")
    if any(rose.plane != found[0].plane for rose in found):
        raise ValueError(f"roses must be in one plane, got {', '.join(rose.plane for rose in found)}")
    if names and len(names) != len(found):
        raise ValueError(f"names must be one a rose, got {len(names)} for {len(found)}")
    figure = style.new_figure(125.0, 105.0)
    ax: Any = figure.add_subplot(projection="polar")
    shades = ("#1f4e79", "#d1495b", "0.35", "#b8860b")
    used: dict[str, None] = {}
    for number, rose in enumerate(found):
        shade, line = shades[number % len(shades)], ("-", "--", ":", "-.")[number % 4]
        ax.plot(
            np.append(rose.angles, rose.angles[0] + 2.0 * np.pi),
            np.append(rose.forces, rose.forces[0]),
            color=shade,
            linestyle=line,
            linewidth=1.6,
            label=names[number] if names else None,
        )
        for angle, each in zip(rose.angles, rose.payloads, strict=True):
            hollow = each.limit in ("force", "lost")
            used[each.limit] = None
            ax.plot(
                angle,
                each.force,
                marker=_LIMITS[each.limit][0],
                markersize=4.5,
                color=shade,
                markerfacecolor="white" if hollow else shade,
                linestyle="none",
            )
    for limit in used:
        marker, text = _LIMITS[limit]
        ax.plot(
            [],
            [],
            marker=marker,
            color="0.3",
            markerfacecolor="white" if limit in ("force", "lost") else "0.3",
            linestyle="none",
            markersize=4.5,
            label=text,
        )
    first, second = found[0].plane
    ends = (f"+{first}", f"+{second}", f"−{first}", f"−{second}")
    ax.set_xticks(np.arange(4) * np.pi / 2, ends, fontsize=style.FONT_SIZE)
    ax.set_ylim(0.0, 1.08 * max(float(np.max(rose.forces)) for rose in found))
    ax.yaxis.set_major_locator(_ticks(4))
    ax.set_rlabel_position(22.5)
    ax.tick_params(axis="y", labelsize=style.FONT_SIZE - 1.0)
    ax.grid(color="0.85", linewidth=0.6)
    ax.set_title("largest force at the tip [N] by its direction", fontsize=style.FONT_SIZE, pad=10.0)
    figure.legend(loc="outside lower center", ncols=3, fontsize=style.FONT_SIZE - 1.0, frameon=False)
    return figure
