"""``softlimb validate``: the model against measurements made elsewhere."""

from __future__ import annotations

import argparse
import csv
import os
import textwrap
from pathlib import Path

from softlimb.cli.scene_arguments import add_outputs, save_picture
from softlimb.cli.tables import aligned

_WIDTH = 110

_EPILOG = """\
Data sets: fibre_tubes (tubes with one family of fibres), tensile_curves (silicones), two_segment_arm (a pneumatic arm
of two segments), tendon_tentacle (a tapered rod pulled by tendons). The data are not part of the package; they are
looked for in the folder that --data names, or where SOFTLIMB_SHARED says, in measured/DATASET (tensile_curves:
materials/raw). Errors are in mm and in per cent of a length that is printed with them."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Arguments of the subcommand."""
    parser = subparsers.add_parser(
        "validate",
        help="the model against measured data sets",
        description="How far the model is from measurements: nothing or little fitted, and tested on data held out.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("dataset", metavar="DATASET", help="which data; an unknown name lists the known ones")
    parser.add_argument("--data", type=Path, metavar="FOLDER", help="where its files are")
    add_outputs(parser, "write the tables, one below the other")


def run(arguments: argparse.Namespace) -> int:
    """Read, fit, print, draw. Returns 1 where a prediction is missing or a search did not converge, else 0."""
    from softlimb.validate import DATASETS, validate

    if arguments.dataset not in DATASETS:
        raise ValueError(f"there is no data set {arguments.dataset!r}: expected one of {', '.join(DATASETS)}")
    folder = arguments.data
    if folder is None:
        shared = os.environ.get("SOFTLIMB_SHARED")
        if not shared:
            raise ValueError("where are the data? give --data FOLDER, or set SOFTLIMB_SHARED")
        folder = Path(shared) / DATASETS[arguments.dataset].place
    if not folder.is_dir():
        raise FileNotFoundError(f"there is no folder {folder}: give --data FOLDER, or set SOFTLIMB_SHARED")
    result = validate(arguments.dataset, folder)
    print(_wrapped(f"{result.name}: {result.what}"))
    for table in result.tables:
        print(f"\n{table.title}\n{aligned(table.headings, table.rows)}")
    print()
    for finding in result.findings:
        print(_wrapped(f"- {finding}"))
    print("\nunexplained:")
    for text in result.unexplained:
        print(_wrapped(f"- {text}"))
    if arguments.table is not None:
        with arguments.table.open("w", newline="", encoding="utf-8") as file:
            for table in result.tables:
                csv.writer(file).writerows([[table.title], table.headings, *table.rows, []])
        print(f"table: {arguments.table}")
    if arguments.output is not None:
        from softlimb import plot

        save_picture(plot.validation(result), arguments.output)
    return 0 if result.success else 1


def _wrapped(text: str) -> str:
    return textwrap.fill(text, _WIDTH, subsequent_indent="  ")
