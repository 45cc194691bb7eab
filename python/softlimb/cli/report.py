"""``softlimb report``: error against run time, scene by scene, as tables, pictures and a page."""

from __future__ import annotations

import argparse
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING

from softlimb.cli.scene_arguments import new_folder
from softlimb.cli.tables import aligned

if TYPE_CHECKING:
    from softlimb.report.measure import Measured

_WIDTH = 110
_FOLDER = "softlimb-report"

_EPILOG = """\
Twelve scenes: tube, cantilever, segment and limb, each mild, stiff and extreme. Errors are true ones, against what two
independent methods agree on; times are taken in the same run, as milliseconds and as multiples of the yardstick that
`softlimb bench` measures. What a method cannot do is a row that says why. Every scene's picture (PNG) and table (CSV)
and the page (report.md, report.html) are written as soon as the scene is done. Ends with 1 where an answer of the
package is wrong or missing."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Arguments of the subcommand."""
    parser = subparsers.add_parser(
        "report",
        help="error against run time of the package and of other methods",
        description="How exact answers are for the time that they take: this package beside other methods.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--out", type=new_folder, default=_FOLDER, metavar="DIR", help=f"where the files go; default: {_FOLDER}"
    )
    parser.add_argument("--only", nargs="+", metavar="SCENE", help="some scenes; an unknown name lists the known ones")
    parser.add_argument("--quick", action="store_true", help="less than a minute: fewer settings, short limits")


def run(arguments: argparse.Namespace) -> int:
    """Measure, print and write, scene by scene. Returns 1 when an answer of the package is wrong or missing, else 0."""
    import numpy as np

    from softlimb.bench.clock import Clock
    from softlimb.bench.figures import about_the_yardstick
    from softlimb.bench.machine import machine
    from softlimb.report.files import write_page, write_scene
    from softlimb.report.measure import measure
    from softlimb.report.page import Page
    from softlimb.report.scenes import SCENES

    names = [scene.name for scene in SCENES]
    unknown = [name for name in arguments.only or () if name not in names]
    if unknown:
        raise ValueError(f"--only has no scene {unknown[0]!r}: expected some of {', '.join(names)}")
    chosen = [scene for scene in SCENES if arguments.only is None or scene.name in arguments.only]
    limit = 1.0 if arguments.quick else 6.0
    clock = Clock(budget=0.06 if arguments.quick else 0.4)
    facts = machine()
    folder: Path = arguments.out
    folder.mkdir(exist_ok=True)

    done: list[Measured] = []
    for scene in chosen:
        print(f"{scene.name}: {scene.what}", flush=True)
        measured = measure(scene, clock, limit, arguments.quick)
        done.append(measured)
        _print(measured)
        write_scene(measured, folder, float(np.median(clock.readings or [clock.yardstick()])))
        reached = [other.name for other in done]
        waiting = [
            (name, "left out by --only" if name not in [s.name for s in chosen] else "not yet run")
            for name in names
            if name not in reached
        ]
        notes, _ = about_the_yardstick(clock.readings)
        write_page(Page(done, waiting, facts, notes, limit, _command(arguments)), folder)
        print(flush=True)
    for note in notes:
        print(note)
    print(f"page: {folder / 'report.html'}, with report.md, and a picture and a table of each scene beside it")
    return 1 if any(measured.fault for measured in done) else 0


def _command(arguments: argparse.Namespace) -> str:
    """The command without the folder, which says nothing about the figures."""
    words = ["softlimb report", *(["--only", *arguments.only] if arguments.only else [])]
    return " ".join([*words, "--quick"] if arguments.quick else words)


def _print(measured: Measured) -> None:
    from softlimb.report.page import HEADINGS, cells

    if measured.reference is not None:
        reference = measured.reference
        text = f"true by {reference.names[0]} and by {reference.names[1]}: they differ by {reference.agreement:.1e}"
        print(textwrap.fill(text, _WIDTH, subsequent_indent="  "))
    if measured.fault:
        print(textwrap.fill(f"FAULT: {measured.fault}", _WIDTH, subsequent_indent="  "))
    if measured.rows:
        rows = [cells(row) for row in measured.rows]
        # Remarks are sentences: they follow their table instead of making it wide.
        print(aligned(HEADINGS[:-1], [row[:-1] for row in rows]))
        for row in rows:
            if row[-1]:
                name = ", ".join(part for part in row[:2] if part)
                print(textwrap.fill(f"{name}: {row[-1]}", _WIDTH, subsequent_indent="  "))
