"""softlimb fit: a material law from a tensile test."""

from __future__ import annotations

import argparse
from pathlib import Path

from softlimb.cli.scene_arguments import picture
from softlimb.materials import FIT_LAWS, Fit, fit_csv
from softlimb.units import MPa, kPa


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the parser of `softlimb`."""
    parser = subparsers.add_parser(
        "fit",
        help="fit a material law to a tensile test",
        description="Fit a material law to a tensile test: least squares of the nominal stress over a strain range.",
        epilog="The CSV names its columns with units, such as `stretch,nominal_stress_MPa` or `strain,stress_kPa`, "
        "separated by , or ; -- or is a file of the Soft Robotics Materials Database.",
    )
    parser.add_argument("csv", type=Path, metavar="CSV", help="the tensile test")
    parser.add_argument("--law", choices=FIT_LAWS, default="yeoh", help="law to fit (default: %(default)s, two terms)")
    parser.add_argument(
        "--max-strain", type=float, metavar="STRAIN", help="end of the fit range, 0.5 is 50 %% (default: all points)"
    )
    parser.add_argument(
        "--output", type=picture, metavar="PICTURE", help="write a picture of data and law (png, pdf, svg)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Fit, print, draw. Returns 0 when the fit converged to a legal law, 1 otherwise; mistakes in the input raise."""
    fit = fit_csv(arguments.csv, arguments.law, max_strain=arguments.max_strain)
    print(report(fit))
    if arguments.output is not None and fit.success:
        from softlimb.plot.material import draw_fit

        draw_fit(fit).savefig(arguments.output, dpi=150)
        print(f"picture: {arguments.output}")
    return 0 if fit.success else 1


def report(fit: Fit) -> str:
    """The fit as text: coefficients with standard errors in MPa, quality, stability, notes."""
    lines = [
        f"{fit.data_name}: {fit.law_name}, nominal strain up to {fit.max_strain:.4g}, {fit.points} of "
        f"{fit.stretch.size} points",
        "",
    ]
    width = max(len(name) for name in fit.coefficients)
    for name, value in fit.coefficients.items():
        # Exponents and Gent's limit are pure numbers; everything else is a stress.
        pure = name.startswith("alpha") or name == "jm"
        scale, unit = (1.0, "") if pure else (MPa, " MPa")
        error = fit.standard_errors[name]
        lines.append(f"  {name:<{width}} = {value / scale:.5f} +- {error / scale:.5f}{unit}   (standard error)")
    lines += [
        "",
        f"  R^2 = {fit.r_squared:.5f}   rmse = {fit.rmse / kPa:.3f} kPa",
        f"  Drucker: {fit.drucker.message}" if fit.drucker is not None else "  Drucker: not checked, there is no law",
        f"  outcome: {fit.message}",
        *([f"  law: {fit.law}"] if fit.success else []),
        *(f"  note: {note}" for note in fit.notes),
    ]
    return "\n".join(lines)
