"""``softlimb sweep``: a table of postures over ranges of pressure."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

import numpy as np

from softlimb.cli.scene_arguments import (
    add_outputs,
    add_scene,
    heading,
    loads_line,
    naming,
    new_file,
    save_picture,
    scene_of,
)
from softlimb.cli.tables import aligned, number
from softlimb.units import deg, kPa, mm

if TYPE_CHECKING:
    from softlimb.sweep import Batch

_FIRST_ROWS, _LAST_ROWS = 20, 5  # what fits on a screen; the files have all
_PRINTED_FAILURES = 10


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Arguments of the subcommand."""
    parser = subparsers.add_parser(
        "sweep",
        help="solve a scene over ranges of pressure",
        description="One posture for each combination of the scene's ranges ([[scene.sweep]]). Ctrl-C keeps what is "
        "solved by then; with --file so does anything else, and the same command goes on from there.",
    )
    add_scene(parser)
    add_outputs(parser, "write all rows")
    parser.add_argument("--netcdf", type=new_file, metavar="NC", help="write a netCDF file (needs softlimb[sweep])")
    parser.add_argument(
        "--file",
        type=new_file,
        metavar="FILE",
        help="keep the rows in this file as they are solved; where it has some of them already, solve the others "
        "(softlimb.Batch.load reads it)",
    )
    parser.add_argument("--threads", type=int, metavar="N", help="rows that are solved at once (default: all cores)")
    parser.add_argument(
        "--ordered", action="store_true", help="each row starts from the postures before it, in groups of 32 rows"
    )
    parser.add_argument("--no-progress", action="store_true", help="no progress bar")


def run(arguments: argparse.Namespace) -> int:
    """Solve, print, write."""
    scene = scene_of(arguments)
    with naming(arguments.scene):
        rows = scene.sweep_pressures()
    if arguments.netcdf is not None:
        _need("xarray", "netCDF4")
    print(heading(arguments.scene, scene))
    print(loads_line(scene))
    print("ranges: " + "; ".join(f"{axis.label} ({len(axis.values)} values)" for axis in scene.sweep_axes))
    batch = scene.sweep(
        progress=not arguments.no_progress,
        threads=arguments.threads,
        ordered=arguments.ordered,
        file=arguments.file,
    )
    print()
    print(_table(batch, rows))
    print()
    print(
        f"{len(batch)} postures, {int(batch.success.sum())} successful; "
        f"reference length {batch.limb.length / mm:.1f} mm"
    )
    print(f"solved by {batch.build}")
    remarks = batch.remarks
    if len(remarks):
        print(
            f"{len(remarks)} rows carry remarks (the table has all); row {remarks[0] + 1}: {batch.message[remarks[0]]}"
        )
    for line in _failures(batch):
        print(line)
    if batch.file is not None:
        more = " (the same command goes on with it)" if batch.interrupted else ""
        print(f"file: {batch.file}{more}")
    if arguments.table is not None:
        batch.to_csv(arguments.table)
        print(f"table: {arguments.table}")
    if arguments.netcdf is not None:
        batch.to_xarray().to_netcdf(arguments.netcdf)
        print(f"netCDF: {arguments.netcdf}")
    if arguments.output is not None:
        from softlimb import plot

        save_picture(plot.sweep(batch, scene.sweep_axes), arguments.output)
    if batch.interrupted:
        return 130
    return 0 if bool(batch.success.all()) else 1


def _table(batch: Batch, rows: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> str:
    headings = ["row", "pressures [kPa]", "tip x [mm]", "y [mm]", "z [mm]", "bending [deg]", "status"]
    from softlimb.sweep import bending_angle

    hidden = range(_FIRST_ROWS, len(batch) - _LAST_ROWS)
    cells = []
    for row in (*range(min(len(batch), _FIRST_ROWS)), *range(max(_FIRST_ROWS, hidden.stop), len(batch))):
        if hidden and row == hidden.stop:
            cells.append(["..."] * len(headings))
        tip = batch.tip[row, :3, 3] / mm
        cells.append(
            [
                str(row + 1),
                " ".join(number(p, 1) for p in rows[row] / kPa),
                *(number(x, 2) for x in tip),
                number(float(bending_angle(batch.tip[row]) / deg), 2),
                batch.status[row]
                if batch.stable[row] or not batch.success[row]
                else f"{batch.status[row]}, not stable",
            ]
        )
    table = aligned(headings, cells)
    return f"{table}\n{len(hidden)} rows are not shown (--table writes all)" if hidden else table


def _failures(batch: Batch) -> list[str]:
    """Why rows failed: the first few one by one, what an interruption left out in one line."""
    from softlimb.sweep import NOT_RUN

    not_run = batch.having(NOT_RUN)
    failures = np.setdiff1d(np.flatnonzero(~batch.success), not_run, assume_unique=True)
    lines = [
        f"row {row + 1}: {batch.status[row]}: {batch.message[row]}" for row in failures[:_PRINTED_FAILURES].tolist()
    ]
    if len(failures) > len(lines):
        lines.append(f"... and {len(failures) - len(lines)} more rows failed (--table writes all)")
    left_out = len(not_run)
    return [*lines, f"interrupted: {left_out} of {len(batch)} rows were not run"] if left_out else lines


def _need(*modules: str) -> None:
    """Say what is missing before the work and not after it."""
    from importlib.util import find_spec

    missing = [name for name in modules if find_spec(name) is None]
    if missing:
        raise ModuleNotFoundError(f"this needs {' and '.join(missing)}: pip install 'softlimb[sweep]'")
