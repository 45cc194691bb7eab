"""``softlimb design``: studies of designs, as tables and pictures."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from softlimb.cli.scene_arguments import add_outputs, new_folder, save_picture
from softlimb.cli.tables import aligned, number, write_csv
from softlimb.units import deg, g, kPa, mm

if TYPE_CHECKING:
    from softlimb.design import Evaluation, RatioStudy

_GRAVITY = {"hanging": 9.81, "standing": -9.81, "none": 0.0}
_HELD = ("proximal", "mass", "volume")
_FLEXIBILITIES = ("bending", "workspace", "compliance")

_EPILOG = """\
The ratio is the inner radius of the last segment's tubes over that of the first's; all radii and rings follow a
straight taper, lengths, laws, wall proportions, thread and pitch stay. Payload is the smallest of six directions: the
force that moves the tip by a limit, or at which stability ends. Flexibility is the mean bending angle over a set of
pressures, the volume of the hull of the tips, or the compliance. The best ratio is that of the largest
payload^w flexibility^(1-w).
Nothing is tuned: what is held, the loads and the meaning of flexibility decide where the optimum is, and the last lines
say whether the paper's 0.5 comes out. Ends with 1 where a design failed."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Arguments of the subcommand."""
    parser = subparsers.add_parser("design", help="study designs", description="Studies of designs.")
    studies = parser.add_subparsers(title="studies", dest="study", metavar="STUDY", required=True)
    ratio = studies.add_parser(
        "radius-ratio",
        help="payload against flexibility along the radius reduction ratio",
        description="Payload against flexibility along the radius reduction ratio of a limb.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    ratio.add_argument("--limb", metavar="TOML", help="a limb of tubes in place of the reference limb")
    ratio.add_argument(
        "--held", nargs="+", choices=_HELD, default=list(_HELD), metavar="WHAT",
        help=f"what stays the same, one study each: {', '.join(_HELD)} (default: all three)",
    )  # fmt: skip
    ratio.add_argument(
        "--ratios", type=float, nargs=2, default=[0.3, 1.0], metavar=("LOW", "HIGH"), help="range (default: 0.3 1)"
    )
    ratio.add_argument("--count", type=int, default=15, metavar="N", help="number of ratios (default: 15)")
    ratio.add_argument(
        "--flexibility", choices=_FLEXIBILITIES, default="bending", help="what it means (default: bending)"
    )
    ratio.add_argument(
        "--payload-weight", type=float, default=0.5, metavar="W", help="from 0 to 1: of the payload (default: 0.5)"
    )
    ratio.add_argument(
        "--pressures-kPa", type=float, nargs="+", default=[30.0], metavar="P",
        help="of the posture that is loaded, one for all actuators or one each [kPa] (default: 30)",
    )  # fmt: skip
    ratio.add_argument(
        "--max-deflection-mm", type=float, metavar="D", help="under the payload [mm] (default: a tenth of the length)"
    )
    ratio.add_argument(
        "--max-pressure-kPa", type=float, default=60.0, metavar="P", help="of the workspace [kPa] (default: 60)"
    )
    ratio.add_argument("--postures", type=int, default=512, metavar="N", help="of the workspace (default: 512)")
    ratio.add_argument("--seed", type=int, default=0, help="of the workspace's pressures (default: 0)")
    ratio.add_argument("--gravity", choices=tuple(_GRAVITY), default="hanging", help="(default: hanging)")
    ratio.add_argument("--workers", type=int, default=1, metavar="N", help="processes (default: 1)")
    ratio.add_argument(
        "--history", type=new_folder, metavar="DIR", help="keep each design there; the same command again goes on"
    )
    add_outputs(ratio, "write all designs")


def run(arguments: argparse.Namespace) -> int:
    """Study, print, write. Returns 1 when a design failed, else 0."""
    from softlimb import presets
    from softlimb.design import radius_ratio
    from softlimb.limb import Limb

    low, high = arguments.ratios
    if not np.isfinite([low, high]).all() or not 0.0 < low < high:
        raise ValueError(f"--ratios must be positive and ascend, got {low:g} {high:g}")
    if arguments.count < 3:
        raise ValueError(f"--count must be at least 3, got {arguments.count}")
    if not 0.0 <= arguments.payload_weight <= 1.0:
        raise ValueError(f"--payload-weight must be within 0 and 1, got {arguments.payload_weight:g}")
    limb = presets.reference_limb() if arguments.limb is None else Limb.from_toml(arguments.limb)
    actuators = sum(len(segment.actuators) for segment in limb)
    given = arguments.pressures_kPa * (actuators if len(arguments.pressures_kPa) == 1 else 1)
    if len(given) != actuators:
        raise ValueError(f"--pressures-kPa has {len(given)} numbers but the limb has {actuators} actuators")
    folder: Path | None = arguments.history
    if folder is not None:
        folder.mkdir(exist_ok=True)
    studies = []
    for held in dict.fromkeys(arguments.held):
        study = radius_ratio(
            limb,
            # Decimals as one would type them: 0.5 and not 0.49999999999999994.
            np.round(np.linspace(low, high, arguments.count), 12),
            held,
            pressures=np.array(given) * kPa,
            max_deflection=None if arguments.max_deflection_mm is None else arguments.max_deflection_mm * mm,
            max_pressure=arguments.max_pressure_kPa * kPa,
            postures=arguments.postures,
            seed=arguments.seed,
            gravity=(0.0, 0.0, _GRAVITY[arguments.gravity]),
            workers=arguments.workers,
            history=None if folder is None else folder / f"radius-ratio-{held}.jsonl",
            progress=_told(held, arguments.count),
        )
        studies.append(study)
        _print(study, arguments)
    for study in studies:
        print(study.verdict(arguments.flexibility))
    if arguments.table is not None:
        rows = [row for study in studies for row in _rows(study, 9)]
        write_csv(arguments.table, list(_HEADINGS), rows)
    if arguments.output is not None:
        from softlimb import plot

        save_picture(plot.radius_ratio(studies, arguments.flexibility), arguments.output)
    return 1 if any(study.failures for study in studies) else 0


def _told(held: str, count: int) -> Callable[[Evaluation, int], None] | None:
    def progress(_: Evaluation, known: int) -> None:
        print(f"\r{held}: {known + 1} of {count} designs", end="", file=sys.stderr, flush=True)

    # A terminal is told how far it is; a file or a pipe is not filled with it.
    return progress if sys.stderr.isatty() else None


_HEADINGS = (
    *("held", "ratio", "payload [N]", *(f"{sign}{axis} [N]" for axis in "xyz" for sign in "+-")),
    *("bending [deg]", "volume [l]", "compl. [mm/N]", "mass [g]", "gap [mm]", "law margin"),
)


def _rows(study: RatioStudy, digits: int) -> list[list[str]]:
    rows = []
    for k, ratio in enumerate(study.ratios):
        values = (
            (study.payload[k], 3),
            *((force, 3) for force in study.payloads[k]),
            (study.flexibility("bending")[k] / deg, 2),
            (study.flexibility("workspace")[k] / 1e-3, 3),
            (study.flexibility("compliance")[k] / mm, 1),
            (study.mass[k] / g, 0),
            (study.gap[k] / mm, 2),
            (study.law_margin[k], 3),
        )
        rows.append([study.held, f"{ratio:.10g}", *(number(v, max(d, digits)) for v, d in values)])
    return rows


def _print(study: RatioStudy, arguments: argparse.Namespace) -> None:
    kind = arguments.flexibility
    front = study.pareto(kind)
    print(f"{study.held} held")
    for assumption in study.assumptions:
        print(f"  {assumption}")
    print()
    headings = [*_HEADINGS[1:], "front", "merit"]
    merit = study.merit(arguments.payload_weight, kind)
    rows = [
        [*row[1:], "yes" if front[k] else "", number(merit[k], 3)] for k, row in enumerate(_rows(study, 0))
    ]
    print(aligned(headings, rows))
    for ratio, why in study.failures.items():
        print(f"  ratio {ratio:g} failed: {why}")
    best = study.best(arguments.payload_weight, kind)
    print(f"best ratio for a payload's weight of {arguments.payload_weight:g}: {best:.3f}")
    print()
