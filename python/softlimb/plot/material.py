"""Tensile data and fitted law in one picture, in the fit range and beyond it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from softlimb.units import MPa, kPa

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from softlimb.materials import Fit

    Points = NDArray[np.float64]

# Light to dark in this order also when printed in grey.
_RANGE_COLOUR = "#e3ecf5"
_OUTSIDE_COLOUR = "#8a8a8a"
_LAW_COLOUR = "#c2410c"
_DATA_COLOUR = "#12263a"


def draw_fit(fit: Fit, *, title: str | None = None) -> Figure:
    """Draw measured points, law and residuals: the fit range enlarged, and the whole test with the law extrapolated.

    Parameters
    ----------
    fit : Fit
        From `fit_uniaxial` or `fit_csv`.
    title : str, optional
        Default: name of the data and of the law.

    Returns
    -------
    matplotlib.figure.Figure
        Not attached to any window: `figure.savefig(path)` writes it.

    Raises
    ------
    RuntimeError
        The fit gave no law.
    """
    from matplotlib.figure import Figure

    law = fit.law
    unit, unit_name = (MPa, "MPa") if np.abs(fit.nominal_stress[fit.in_range]).max() >= MPa else (kPa, "kPa")
    strain, stress = fit.stretch - 1.0, fit.nominal_stress
    beyond = bool(np.any(~fit.in_range))

    figure = Figure(figsize=(10.0 if beyond else 6.4, 6.0), layout="constrained")
    axes = figure.subplots(2, 2 if beyond else 1, sharex="col", squeeze=False, height_ratios=[3.0, 1.0])
    figure.suptitle(
        title if title is not None else f"{fit.data_name or 'Uniaxial test'}: {_law_title(fit)}", fontsize="large"
    )
    ranges = [("in the fit range", fit.in_range, unit, unit_name)]
    if beyond:
        big, big_name = (MPa, "MPa") if np.abs(stress).max() >= MPa else (kPa, "kPa")
        ranges.append(("whole test, law extrapolated beyond the range", np.ones_like(fit.in_range), big, big_name))

    for (upper, lower), (heading, shown, scale, scale_name) in zip(axes.T, ranges, strict=True):
        lowest, highest = min(float(strain[shown].min()), 0.0), float(strain[shown].max())
        grid = np.linspace(lowest, highest, 400)
        inside = grid <= fit.max_strain + 1e-12
        drawn = law.uniaxial_stress(1.0 + grid) / scale
        for panel in (upper, lower):
            panel.axvspan(lowest, fit.max_strain, color=_RANGE_COLOUR, zorder=0, label="fit range")
            panel.set_xlim(lowest, highest + 0.02 * (highest - lowest))
            panel.grid(True, color="0.9", linewidth=0.6)
            panel.set_axisbelow(True)
        _draw_points(upper, strain, stress / scale, shown, fit.in_range)
        upper.plot(grid[inside], drawn[inside], color=_LAW_COLOUR, linewidth=2.0, label="law")
        if not inside.all():
            upper.plot(grid[~inside], drawn[~inside], "--", color=_LAW_COLOUR, linewidth=2.0, label="law, extrapolated")
        # The law may leave the data by any factor out there; the data set the scale, and the law runs out of the top.
        top = float(np.nanmax(np.append(stress[shown] / scale, drawn[inside])))
        bottom = float(np.nanmin(np.append(stress[shown] / scale, drawn[inside])))
        upper.set_ylim(bottom - 0.03 * (top - bottom), top + 0.08 * (top - bottom))
        upper.set_title(heading, fontsize="medium")
        upper.set_ylabel(f"nominal stress [{scale_name}]")

        lower.axhline(0.0, color=_LAW_COLOUR, linewidth=1.2)
        small_enough = np.nanmax(np.abs(fit.residuals[shown])) < MPa
        small, small_name = (kPa, "kPa") if small_enough else (scale, scale_name)
        _draw_points(lower, strain, fit.residuals / small, shown, fit.in_range)
        lower.set_ylabel(f"law - data [{small_name}]")
        lower.set_xlabel("nominal strain [-]")
    figure.align_ylabels()
    # Below the panels, where no curve can run through it; the last panel shows every kind of point and line.
    figure.legend(*axes[0, -1].get_legend_handles_labels(), loc="outside lower center", ncols=5 if beyond else 3)
    return figure


def _draw_points(
    panel: Axes, strain: Points, values: Points, shown: NDArray[np.bool_], used: NDArray[np.bool_]
) -> None:
    """Points of the fit as filled circles, the others as small open ones."""
    few = int(shown.sum()) <= 60
    outside = shown & ~used
    if outside.any():
        panel.plot(
            strain[outside],
            values[outside],
            "o",
            markersize=3.0,
            markerfacecolor="white",
            markeredgecolor=_OUTSIDE_COLOUR,
            markeredgewidth=0.9,
            label="measured, not in the fit",
        )
    panel.plot(
        strain[used],
        values[used],
        "o",
        markersize=5.0 if few else 3.0,
        color=_DATA_COLOUR,
        label="measured, in the fit",
    )


def _law_title(fit: Fit) -> str:
    values = []
    for name, value in fit.coefficients.items():
        pure = name.startswith("alpha") or name == "jm"
        digits = ".5f" if abs(value) >= 1e-3 * MPa else ".3g"
        values.append(f"{name} = {value:.4g}" if pure else f"{name} = {value / MPa:{digits}} MPa")
    return fit.law_name + "\n" + ", ".join(values)
