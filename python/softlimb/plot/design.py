"""Picture of the study of the radius ratio: payload against flexibility, and the merit along the ratio."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from softlimb.arguments import one_of
from softlimb.design import FLEXIBILITIES, RatioStudy
from softlimb.plot import style
from softlimb.units import deg

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_AXES = {
    "bending": ("mean bending angle [deg]", deg),
    "workspace": ("workspace volume [litre]", 1e-3),
    "compliance": ("compliance [mm/N]", 1e-3),
}
_FRONT = style.PREDICTED["color"]
_BEATEN = "#9a9a9a"
_NAMED = (0.3, 0.5, 0.7, 1.0)  # ratios that are written beside their designs
_LINES = ((1.0, ":"), (0.5, "-"), (0.0, "--"))  # weights of the payload


def radius_ratio(studies: RatioStudy | Sequence[RatioStudy], kind: str = "bending") -> Figure:
    """Payload over flexibility with the Pareto front, and below it the merit for three weights; a column a study.

    Parameters
    ----------
    studies : RatioStudy or sequence of RatioStudy
        Usually one for each thing that is held.
    kind : {"bending", "workspace", "compliance"}
        What flexibility means.

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        No study, or an unknown kind of flexibility.
    """
    one_of("kind", kind, tuple(FLEXIBILITIES))
    columns = [studies] if isinstance(studies, RatioStudy) else list(studies)
    if not columns:
        raise ValueError("studies must be at least one, got none")
    for study in columns:
        if not isinstance(study, RatioStudy):
            raise TypeError(f"studies must each be a RatioStudy, got {type(study).__name__}")
    figure = style.new_figure(30.0 + 60.0 * len(columns), 115.0)
    axes = figure.subplots(2, len(columns), squeeze=False)
    for column, study in enumerate(columns):
        _draw_front(axes[0, column], study, kind, first=column == 0)
        axes[1, column].sharey(axes[1, 0])
        _draw_merit(axes[1, column], study, kind, first=column == 0, last=column == len(columns) - 1)
        axes[0, column].set_title(f"{study.held} held", fontsize=style.FONT_SIZE)
    return figure


def _draw_front(axes: Axes, study: RatioStudy, kind: str, first: bool) -> None:
    label, unit = _AXES[kind]
    x, y, front = study.flexibility(kind) / unit, study.payload, study.pareto(kind)
    axes.plot(x, y, color=_BEATEN, linewidth=1.0, zorder=1)
    plain: dict[str, Any] = {"linestyle": "none", "markersize": 4.5}
    axes.plot(x[~front], y[~front], marker="o", color=_BEATEN, markerfacecolor="white", label="beaten", **plain)
    axes.plot(x[front], y[front], marker="o", color=_FRONT, label="Pareto front", **plain)
    for ratio in _NAMED:
        k = int(np.argmin(np.abs(study.ratios - ratio)))
        if abs(study.ratios[k] - ratio) < 1e-9:
            # On the side that the curve leaves free.
            rises = np.gradient(y)[k] * np.gradient(x)[k] > 0.0
            small: dict[str, Any] = {"textcoords": "offset points", "fontsize": style.FONT_SIZE - 1.5}
            axes.annotate(f"{ratio:g}", (x[k], y[k]), (-4 if rises else 3, 3), ha="right" if rises else "left", **small)
    best = study.best(0.5, kind)
    place = np.interp(best, study.ratios, x), np.interp(best, study.ratios, y)
    axes.plot(*place, marker="*", markersize=12, color=style.LOAD_COLOUR, linestyle="none", label=r"best, $w$ = 0.5")
    axes.margins(x=0.2, y=0.12)
    style.finish(axes, label, "smallest payload [N]" if first else "")
    if first:
        axes.legend(fontsize=style.FONT_SIZE - 1.5, frameon=False, loc="best")


def _draw_merit(axes: Axes, study: RatioStudy, kind: str, first: bool, last: bool) -> None:
    for weight, line in _LINES:
        merit = study.merit(weight, kind)
        axes.plot(study.ratios, merit, line, color=_FRONT, linewidth=1.6, label=f"$w$ = {weight:g}")
        k = int(np.argmax(merit))
        axes.plot(study.ratios[k], merit[k], marker="o", color=_FRONT, markersize=4.5)
    axes.axvline(0.5, color="0.6", linewidth=0.8)
    text: dict[str, Any] = {"textcoords": "offset points", "fontsize": style.FONT_SIZE - 1.5, "color": "0.35"}
    axes.annotate("paper", (0.5, 0.02), (3, 0), xycoords=("data", "axes fraction"), **text)
    style.finish(axes, "radius ratio distal / proximal", "merit / largest" if first else "")
    if last:
        axes.legend(
            fontsize=style.FONT_SIZE - 1.5, frameon=False, title=r"payload$^w$ flexibility$^{1-w}$",
            title_fontsize=style.FONT_SIZE - 1.5, loc="lower right",
        )  # fmt: skip
