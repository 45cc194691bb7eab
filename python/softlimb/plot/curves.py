"""Curves over pressure and positions, predicted beside measured."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from softlimb.measured import Centreline, CurveComparison, PositionComparison
from softlimb.plot import style
from softlimb.units import deg, kPa, mm

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from softlimb.scenes import Axis
    from softlimb.sweep import Batch

Array: TypeAlias = NDArray[np.float64]

_UNITS = {"elongation": ("mm", mm), "bending": ("deg", deg)}


def comparison(result: CurveComparison | PositionComparison) -> Figure:
    """The picture that fits a comparison: a curve over pressure, or positions from two sides.

    Parameters
    ----------
    result : CurveComparison or PositionComparison

    Returns
    -------
    Figure
    """
    if isinstance(result, CurveComparison):
        figure = style.new_figure(100.0, 78.0)
        curve(result, figure.add_subplot())
        return figure
    return positions(result)


def curve(result: CurveComparison, ax: Axes) -> Axes:
    """A predicted curve over pressure with the measured points and the figures of merit.

    Parameters
    ----------
    result : CurveComparison
    ax : matplotlib axes

    Returns
    -------
    Axes
    """
    measured = result.measured
    unit, factor = _UNITS[measured.kind]
    ax.plot(result.curve_pressures / kPa, result.curve_values / factor, label="predicted", **style.PREDICTED)
    ax.plot(measured.pressures / kPa, measured.values / factor, label="measured", **style.MEASURED)
    style.finish(ax, "gauge pressure [kPa]", f"{measured.kind} [{unit}]")
    text = f"pressure MAE {result.pressure_mae / kPa:.3g} kPa\n$R^2$ = {result.r_squared:.3f}"
    ax.legend(
        fontsize=style.FONT_SIZE,
        frameon=False,
        loc="upper left",
        title=text,
        title_fontsize=style.FONT_SIZE,
        alignment="left",
    )
    return ax


def positions(result: PositionComparison) -> Figure:
    """Measured and predicted positions seen along y and along x, on equal axes.

    Parameters
    ----------
    result : PositionComparison

    Returns
    -------
    Figure
    """
    measured = result.measured
    points = measured.points if isinstance(measured, Centreline) else measured.positions
    line = result.predicted
    hangs = bool(np.nanmean(points[:, 2]) > 0.0)
    if result.posture is not None:
        if result.posture.success:
            line = result.posture.centreline(100)
        hangs = bool(result.posture.loads["gravity"][2] > 0.0)
    joined = isinstance(measured, Centreline)
    everything = np.concatenate([points, line[np.isfinite(line).all(axis=1)]]) / mm
    figure, views = _two_views(everything)
    for axis, ax in enumerate(views):
        shown = [axis, 2]
        if joined:
            ax.plot(*(line[:, shown].T / mm), label="predicted", **style.PREDICTED)
            ax.plot(*(line[-1, shown] / mm), **_tip(style.PREDICTED["color"]))
        else:
            for a, b in zip(points, line, strict=True):
                ax.plot(*(np.array([a, b])[:, shown].T / mm), color="0.6", linewidth=0.8)
            ax.plot(*(line[:, shown].T / mm), label="predicted", **_tip(style.PREDICTED["color"]))
        ax.plot(*(points[:, shown].T / mm), label="measured", **style.MEASURED)
        style.finish(ax, f"{'xy'[axis]} [mm]", "z [mm]")
        _equal(ax, everything[:, shown], everything, hangs)
    views[1].set_ylabel("")
    what = "tip error" if joined else "mean tip error"
    error, share, length = result.tip_error / mm, result.tip_error_percent, result.reference_length / mm
    title = f"{what} {error:.2f} mm = {share:.2f} % of {length:.1f} mm"
    if result.posture is not None and not result.posture.success:
        title = f"no prediction, not an equilibrium: {result.posture.status}"
    figure.suptitle(title, fontsize=style.FONT_SIZE)
    figure.legend(
        *views[0].get_legend_handles_labels(),
        loc="outside lower center",
        ncols=2,
        fontsize=style.FONT_SIZE,
        frameon=False,
    )
    return figure


def sweep(batch: Batch, axes: Sequence[Axis] = ()) -> Figure:
    """A sweep: tip height and bending over the pressure of its one axis, or all tips from two sides.

    Parameters
    ----------
    batch : Batch
    axes : sequence of Axis, optional
        What the sweep varies; with exactly one, the picture is drawn over its values.

    Returns
    -------
    Figure
        Rows that did not succeed leave gaps.
    """
    if len(axes) == 1 and len(batch) == len(axes[0].values):
        return _over_axis(batch, axes[0])
    tips = batch.tip[:, :3, 3] / mm
    good = tips[np.isfinite(tips).all(axis=1)]
    failed = len(good) == 0
    good = np.zeros((1, 3)) if failed else good
    figure, views = _two_views(good)
    if failed:
        figure.suptitle("no row succeeded", color=style.LOAD_COLOUR, fontsize=style.FONT_SIZE)
    colours = dict(zip(("vmin", "vmax"), _range(batch.bending / deg), strict=True))
    hangs = bool(np.asarray(batch.scene.get("gravity", (0.0, 0.0, 0.0)))[2] > 0.0)
    for axis, ax in enumerate(views):
        drawn = ax.scatter(
            tips[:, axis],
            tips[:, 2],
            c=batch.bending / deg,
            cmap="cividis_r",
            s=14.0,
            edgecolors="0.2",
            linewidths=0.3,
            **colours,
        )
        style.finish(ax, f"tip {'xy'[axis]} [mm]", "tip z [mm]")
        _equal(ax, good[:, [axis, 2]], good, hangs)
    views[1].set_ylabel("")
    figure.colorbar(drawn, ax=views, shrink=0.7).set_label("bending of the tip [deg]", fontsize=style.FONT_SIZE)
    return figure


def _over_axis(batch: Batch, axis: Axis) -> Figure:
    values = np.array(axis.values) if axis.scales else np.array(axis.values) / kPa
    label = "part of the scene's pressures [1]" if axis.scales else "gauge pressure [kPa]"
    figure = style.new_figure(120.0, 110.0)
    upper, lower = figure.subplots(2, 1, sharex=True)
    for i, (name, line, marker) in enumerate((("x", "--", "s"), ("y", ":", "^"), ("z", "-", "o"))):
        shade = ("#8c8c8c", "#5a7fa6", "#1f4e79")[i]
        upper.plot(
            values,
            batch.tip[:, i, 3] / mm,
            linestyle=line,
            marker=marker,
            markersize=3.5,
            color=shade,
            label=f"tip {name}",
        )
    lower.plot(values, batch.bending / deg, marker="o", markersize=3.5, **style.PREDICTED)
    low, high = _range(values)
    lower.set_xlim(low - 0.04 * (high - low), high + 0.04 * (high - low))
    for ax, drawn in ((upper, batch.tip[:, :3, 3] / mm), (lower, batch.bending / deg)):
        low, high = _range(drawn)
        ax.set_ylim(low - 0.06 * (high - low), high + 0.06 * (high - low))
    style.finish(upper, "", "tip position [mm]")
    style.finish(lower, label, "bending of the tip [deg]")
    upper.legend(fontsize=style.FONT_SIZE - 1.0, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def _range(values: Array) -> tuple[float, float]:
    """Ends of an axis that holds all values, wide enough not to blow rounding errors up: 1 mm, 1 deg or 1 kPa."""
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    return (low, high) if high - low >= 1.0 else (0.5 * (low + high) - 0.5, 0.5 * (low + high) + 0.5)


def _tip(colour: str) -> dict[str, Any]:
    return {"marker": "D", "markersize": 4.5, "color": colour, "linestyle": "none"}


def _spans(everything: Array) -> tuple[float, float]:
    """Width and height of a view that holds all points in both views [mm]."""
    width, height = float(np.ptp(everything[:, :2], axis=0).max()), float(np.ptp(everything[:, 2]))
    least = 0.3 * max(width, height, 10.0)
    return 1.1 * max(width, least), 1.1 * max(height, least)


def _two_views(everything: Array) -> tuple[Figure, Any]:
    """A figure as high as its two views need: each is 62 mm wide, labels and legend take 32 mm."""
    width, height = _spans(everything)
    figure = style.new_figure(150.0, float(np.clip(62.0 * height / width, 30.0, 110.0)) + 32.0)
    return figure, figure.subplots(1, 2, sharey=True)


def _equal(ax: Axes, points: Array, everything: Array, hangs: bool) -> None:
    """Equal scales in both directions, the same window size in both views, z pointing down for a hanging limb."""
    width, height = _spans(everything)
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    ax.set_xlim(middle[0] - 0.5 * width, middle[0] + 0.5 * width)
    limits = (middle[1] - 0.5 * height, middle[1] + 0.5 * height)
    ax.set_ylim(*(limits[::-1] if hangs else limits))
    ax.set_aspect("equal", adjustable="box")
    ax.locator_params(axis="x", nbins=5)
