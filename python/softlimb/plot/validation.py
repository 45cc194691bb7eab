"""Pictures of an identification's profile and of a validation."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from softlimb.plot import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from softlimb.identify import Profile
    from softlimb.validate import Validation

_SERIES = {
    "off by": ("from measured to model", {"color": "0.7", "linewidth": 0.7, "zorder": 1}),
    "predicted": ("model", {**style.PREDICTED, "zorder": 3}),
    "measured": ("measured", {**style.MEASURED, "markersize": 4.0}),
    "measured, other branch": (
        "measured, pressure falling",
        {"color": "#444444", "marker": "v", "markersize": 4.5, "linestyle": "none"},
    ),
    "model at points": (
        "model, fitted",
        {"color": style.PREDICTED["color"], "marker": "D", "markersize": 4.5, "linestyle": "none"},
    ),
    "held out": ("model, held out", {"color": "0.25", "marker": "x", "markersize": 4.5, "linestyle": "none"}),
}


def profile(result: Profile, ax: Axes | None = None, *, label: str | None = None, unit: float = 1.0) -> Figure | Axes:
    """How much worse the data are met as one parameter moves away from its estimate.

    Parameters
    ----------
    result : Profile
        From `Identified.profile`.
    ax : matplotlib axes, optional
        Default: a new figure.
    label : str, optional
        Of the parameter, with its unit; default: its name.
    unit : float
        What the parameter is divided by.

    Returns
    -------
    Figure, or the axes that were given
    """
    figure = None
    if ax is None:
        figure = style.new_figure(100.0, 78.0)
        ax = figure.add_subplot()
    x = result.values / unit
    ax.plot(x, np.abs(result.distance), label="profile", **style.PREDICTED)
    if np.isfinite(result.standard_error):
        straight = np.abs(result.values - result.estimate) / result.standard_error
        ax.plot(x, straight, linestyle="--", color="0.45", linewidth=1.2, label="linear model")
    ax.axhline(result.quantile, color=style.LOAD_COLOUR, linewidth=1.0, linestyle=":")
    for end in result.interval:
        if np.isfinite(end):
            ax.axvline(end / unit, color=style.LOAD_COLOUR, linewidth=1.0, linestyle=":")
    ax.plot([], [], color=style.LOAD_COLOUR, linewidth=1.0, linestyle=":", label="interval")
    top = max(1.6 * result.quantile, 1.05 * float(np.max(np.abs(result.distance[np.isfinite(result.distance)]))))
    ax.set_ylim(0.0, top)
    style.finish(ax, result.name if label is None else label, "distance from the data\n[standard deviations]")
    ax.legend(fontsize=style.FONT_SIZE - 1.0, frameon=False, loc="upper center")
    return ax if figure is None else figure


def validation(result: Validation) -> Figure:
    """The panels of a validation, three a row, with one legend.

    Parameters
    ----------
    result : Validation

    Returns
    -------
    Figure
    """
    count = len(result.panels)
    columns = min(count, 3)
    rows = -(-count // columns)
    figure = style.new_figure(64.0 * columns, 58.0 * rows + 10.0)
    grid = figure.subplots(rows, columns, squeeze=False)
    handles = {}
    for panel, ax in zip(result.panels, grid.flat, strict=False):
        for series in panel.series:
            label, drawing = _SERIES[series.kind]
            (handles[label],) = ax.plot(series.x, series.y, **drawing)
        style.finish(ax, panel.x_label, panel.y_label)
        ax.set_title(panel.title, fontsize=style.FONT_SIZE)
        if panel.equal:
            ax.set_aspect("equal", adjustable="datalim")
    for ax in list(grid.flat)[count:]:
        ax.set_axis_off()
    figure.legend(
        list(handles.values()), list(handles), loc="outside lower center", ncols=4, fontsize=style.FONT_SIZE,
        frameon=False,
    )  # fmt: skip
    return figure
