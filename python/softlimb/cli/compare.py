"""``softlimb compare``: a scene against a measured curve, centreline, or list of tips."""

from __future__ import annotations

import argparse
import csv
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from softlimb import measured as measuring
from softlimb.cli.scene_arguments import add_outputs, add_scene, heading, loads_line, naming, save_picture, scene_of
from softlimb.cli.tables import aligned, number
from softlimb.units import deg, kPa, mm

if TYPE_CHECKING:
    from softlimb.scenes import Scene

_UNITS = {"elongation": ("mm", mm), "bending": ("deg", deg)}


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Arguments of the subcommand."""
    parser = subparsers.add_parser(
        "compare",
        help="compare a scene with measured points",
        description="How far a prediction is from what was measured. The columns of the file say what it holds.",
        epilog=measuring.__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_scene(parser)
    parser.add_argument("measured", metavar="MEASURED.csv", type=Path, help="what was measured")
    add_outputs(parser, "write measured and predicted numbers")
    parser.add_argument(
        "--column",
        action="append",
        default=[],
        metavar="NAME=THEIRS",
        help="a column that the file calls otherwise: pressure_kPa=P_kPa (may be repeated)",
    )
    parser.add_argument(
        "--reference-length-mm", type=float, metavar="L", help="what per cent are of [mm]; default: the limb's length"
    )


def run(arguments: argparse.Namespace) -> int:
    """Read, predict, print, write."""
    scene = scene_of(arguments)
    measured = measuring.read_measured(arguments.measured, _columns(arguments.column))
    reference = scene.limb.length
    if arguments.reference_length_mm is not None:
        reference = arguments.reference_length_mm * mm
        if not (np.isfinite(reference) and reference > 0.0):
            raise ValueError(f"--reference-length-mm must be positive, got {arguments.reference_length_mm:g}")
    print(f"{heading(arguments.scene, scene)}, against {arguments.measured}")
    print(loads_line(scene))
    if measured.skipped:
        print(f"left out: {measured.skipped} rows with empty cells")
    print()
    comparison: measuring.CurveComparison | measuring.PositionComparison
    if isinstance(measured, measuring.Curve):
        comparison = _compare_curve(scene, measured)
    elif isinstance(measured, measuring.Centreline):
        comparison = measuring.compare_centreline(measured, scene.solve(), reference_length=reference)
    else:
        with naming(str(arguments.measured)):
            comparison = _compare_tips(scene, measured, reference)
    headings, rows = (
        _curve_rows(comparison) if isinstance(comparison, measuring.CurveComparison) else _position_rows(comparison)
    )
    print(aligned(headings, rows))
    print()
    print("\n".join(_verdict(comparison)))
    if arguments.table is not None:
        with arguments.table.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([[_column_name(name) for name in headings], *rows])
        print(f"table: {arguments.table}")
    if arguments.output is not None:
        from softlimb import plot

        save_picture(plot.comparison(comparison), arguments.output)
    return 1 if comparison.failed else 0


def _columns(pairs: list[str]) -> dict[str, str]:
    columns = {}
    for pair in pairs:
        ours, equals, theirs = pair.partition("=")
        if not (ours and equals and theirs):
            raise ValueError(f"--column must be NAME=THEIRS, such as pressure_kPa=P_kPa, got {pair!r}")
        columns[ours] = theirs
    return columns


def _compare_curve(scene: Scene, measured: measuring.Curve) -> measuring.CurveComparison:
    response = measuring.response_of(scene, measured.kind)
    grid = np.unique(np.array([0.0, *scene.sweep_axes[0].values]))
    return measuring.compare_curve(measured, response, grid)


def _compare_tips(scene: Scene, measured: measuring.Tips, reference: float) -> measuring.PositionComparison:
    from softlimb.sweep import sweep

    if measured.pressures.shape[1] != sum(scene.counts):
        found = measured.pressures.shape[1]
        raise ValueError(f"the measured file has pressures of {found} actuators, the limb has {sum(scene.counts)}")
    batch = sweep(scene.limb, measured.pressures, progress=False, **scene.solve_options())
    return measuring.compare_tips(measured, batch.tip[:, :3, 3], reference_length=reference)


def _curve_rows(comparison: measuring.CurveComparison) -> tuple[list[str], list[list[str]]]:
    measured = comparison.measured
    unit, factor = _UNITS[measured.kind]
    headings = [
        "pressure [kPa]",
        f"measured {measured.kind} [{unit}]",
        f"predicted {measured.kind} [{unit}]",
        "predicted pressure [kPa]",
    ]
    rows = [
        [number(p / kPa, 2), number(value / factor, 3), number(f / factor, 3), number(reached / kPa, 2)]
        for p, value, f, reached in zip(
            measured.pressures, measured.values, comparison.predicted, comparison.pressures, strict=True
        )
    ]
    return headings, rows


def _position_rows(comparison: measuring.PositionComparison) -> tuple[list[str], list[list[str]]]:
    measured = comparison.measured
    points = measured.points if isinstance(measured, measuring.Centreline) else measured.positions
    headings = ["point", *(f"{kind} {axis} [mm]" for kind in ("measured", "predicted") for axis in "xyz"), "error [mm]"]
    rows = [
        [str(i), *(number(x / mm, 2) for x in (*point, *predicted)), number(error / mm, 2)]
        for i, (point, predicted, error) in enumerate(
            zip(points, comparison.predicted, comparison.errors, strict=True), start=1
        )
    ]
    return headings, rows


def _verdict(comparison: measuring.CurveComparison | measuring.PositionComparison) -> list[str]:
    if isinstance(comparison, measuring.CurveComparison):
        kind = comparison.measured.kind
        unit, factor = _UNITS[kind]
        lines = [
            f"pressure MAE at equal {kind}: {number(comparison.pressure_mae / kPa, 4)} kPa",
            f"R^2 of the {kind}: {number(comparison.r_squared, 4)}",
            f"{kind} MAE at equal pressure: {number(comparison.value_mae / factor, 3)} {unit}",
        ]
        if comparison.unreached:
            lines.append(
                f"{comparison.unreached} of {len(comparison.pressures)} measured points are beyond the prediction "
                "and not in the pressure MAE"
            )
    else:
        over_all = isinstance(comparison.measured, measuring.Tips)
        errors = comparison.errors[np.isfinite(comparison.errors)]
        largest = float(errors.max()) if errors.size else float("nan")
        lines = [
            f"{'mean tip' if over_all else 'tip'} error: {number(comparison.tip_error / mm, 2)} mm = "
            f"{number(comparison.tip_error_percent, 2)} % of the reference length "
            f"{number(comparison.reference_length / mm, 1)} mm",
            f"largest {'tip error' if over_all else 'distance from the centreline'}: {number(largest / mm, 2)} mm",
            f"R^2 of the positions: {number(comparison.r_squared, 4)}",
        ]
        if comparison.posture is not None and not comparison.posture.success:
            lines.append(f"status: {comparison.posture.status}: {comparison.posture.message}")
    if comparison.failed:
        lines.append(f"{comparison.failed} predictions did not succeed and are left out")
    return lines


def _column_name(heading: str) -> str:
    """ "tip x [mm]" as "tip_x_mm"."""
    return heading.replace(" [", "_").replace("]", "").replace(" ", "_")
