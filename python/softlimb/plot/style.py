"""What all pictures share: sizes, line colours, and how a measured point differs from a predicted line."""

from __future__ import annotations

from functools import partial
from io import BytesIO
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Line and markers differ in shape and lightness, not in hue alone: they must survive a grey print.
PREDICTED: dict[str, Any] = {"color": "#1f4e79", "linewidth": 1.8}
MEASURED: dict[str, Any] = {
    "color": "#d1495b",
    "marker": "o",
    "markersize": 5.0,
    "markerfacecolor": "white",
    "linestyle": "none",
}
LOAD_COLOUR = "#b3122a"
GRAVITY_COLOUR = "#555555"
PRESSURE_COLOURS = "YlOrBr"  # from pale to dark: the value can be read from a grey print as well
PRESSURE_SHARE = (0.06, 0.82)  # part of the map in use: beyond it the shading of a tube would drown in black
FONT_SIZE = 9.0
DOTS_PER_INCH = 200
_NOTEBOOK_DOTS_PER_INCH = 110  # 180 mm are 780 pixels, which every notebook shows without scaling


def new_figure(width_mm: float, height_mm: float, *, constrained: bool = True) -> Figure:
    """A figure that belongs to nobody: no window, no global state.

    `constrained` lets matplotlib make room for labels; without it the caller places the axes.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(
        figsize=(width_mm / 25.4, height_mm / 25.4), layout="constrained" if constrained else None, dpi=DOTS_PER_INCH
    )
    FigureCanvasAgg(figure)
    # Notebooks show what has this method; without it a figure that pyplot does not know prints as text.
    setattr(figure, "_repr_png_", partial(as_png, figure))  # noqa: B010
    return figure


def as_png(figure: Figure) -> bytes:
    """The figure as a PNG of a notebook's width."""
    buffer = BytesIO()
    figure.savefig(buffer, format="png", dpi=_NOTEBOOK_DOTS_PER_INCH)
    return buffer.getvalue()


def finish(axes: Axes, x_label: str, y_label: str) -> None:
    """Labels with units, small ticks, no box on top and right, a faint grid."""
    axes.set_xlabel(x_label, fontsize=FONT_SIZE)
    axes.set_ylabel(y_label, fontsize=FONT_SIZE)
    axes.tick_params(labelsize=FONT_SIZE - 1.0)
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(color="0.9", linewidth=0.6)
    axes.set_axisbelow(True)
