"""``softlimb bench``: how fast the package is, beside what is asked of it and beside other ways to the same answers."""

from __future__ import annotations

import argparse
import json
import textwrap
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from softlimb.cli.scene_arguments import new_file
from softlimb.units import ms, us

if TYPE_CHECKING:
    from softlimb.bench.clock import Clock
    from softlimb.bench.omissions import Difference
    from softlimb.bench.others import Outcome
    from softlimb.bench.speed import Effort, Row

_WIDTH = 110

_EPILOG = """\
All ratios are to the yardstick Y, one pass of a fixed loop in plain scalar C++ (nine rods of eight Runge-Kutta steps),
read before and after each sample: what is a multiple of Y means the same on any machine. Where Y takes more than 9 us
the machine is busy or slow, and the run is called void. Spread: quartiles. "C++" are the calls into the compiled core
that the question makes, "Python" is the question as a user asks it. Every answer is checked before it is timed."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Arguments of the subcommand."""
    parser = subparsers.add_parser(
        "bench",
        help="time the package, and other ways to the same answers",
        description="Times of the package beside what is asked of them, and of other methods on the same scenes.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    effort = parser.add_mutually_exclusive_group()
    effort.add_argument("--quick", action="store_true", help="less than half a minute; leaves out what takes longer")
    effort.add_argument("--full", action="store_true", help="sweeps of 100 000 rows, long limits: many minutes")
    parser.add_argument("--only", nargs="+", metavar="NAME", help="some rows; an unknown name lists the known ones")
    parser.add_argument("--json", type=new_file, metavar="FILE", help="write all figures, raw samples included")
    parser.add_argument(
        "--instructions", action="store_true", help="count the instructions of a solve, with valgrind (minutes)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Measure and print. Returns 1 when a check refuses an answer of the package itself, else 0."""
    from softlimb import _core
    from softlimb.bench.clock import Clock
    from softlimb.bench.machine import machine
    from softlimb.bench.omissions import OMISSIONS
    from softlimb.bench.others import SCENES
    from softlimb.bench.speed import ENTRIES, Effort

    names = [part.name for part in (*ENTRIES, *SCENES, *OMISSIONS)]
    chosen = _chosen(arguments.only, names)
    facts = machine()
    for name, value in facts.items():
        print(_wrapped(f"{name}: {value}"))
    microseconds, checksum = _core.yardstick()
    print(f"yardstick Y: {microseconds:.3f} us, checksum {checksum:.6f}")
    clock, effort = Clock(budget=3.0), Effort()
    if arguments.quick:
        clock, effort = Clock(budget=0.3), Effort(steps=20, cold=20, sweep_rows=4096, limit=2.0)
    elif arguments.full:
        clock, effort = Clock(budget=10.0), Effort(steps=100, cold=1000, limit=120.0)

    rows = _speed([entry for entry in ENTRIES if entry.name in chosen], clock, effort)
    scenes = [scene for scene in SCENES if scene.name in chosen]
    if arguments.quick and arguments.only is None:
        scenes = scenes[:2]  # what the limb of nine takes other methods would fill the half minute
    outcomes = _others(scenes, clock, effort, compiled=not arguments.quick)
    left_out = [name for name in names if name.startswith("other-") and name in chosen]
    left_out = [name for name in left_out if name not in [scene.name for scene in scenes]]
    if left_out:
        print(f"left out by --quick: {', '.join(left_out)}")
    differences = _omissions([part for part in OMISSIONS if part.name in chosen], clock)
    counts = _instructions() if arguments.instructions else {}

    print()
    summary = _yardstick(clock.readings or [microseconds * us], checksum)
    if arguments.json is not None:
        _write(
            arguments.json,
            {
                "machine": facts,
                "yardstick": summary,
                "speed": [row.to_dict() for row in rows],
                "others": [outcome.to_dict() for outcome in outcomes],
                "omissions": [difference.to_dict() for difference in differences],
                "instructions": counts,
            },
        )
    wrong = any(row.wrong for row in rows) or any(difference.fault for difference in differences)
    return 1 if wrong or any(o.method == "softlimb" and o.samples is None for o in outcomes) else 0


def _chosen(only: Sequence[str] | None, names: Sequence[str]) -> list[str]:
    if only is None:
        return list(names)
    unknown = [name for name in only if name not in names]
    if unknown:
        raise ValueError(f"--only has no row {unknown[0]!r}: expected some of {', '.join(names)}")
    return list(only)


# --- tables, a row as soon as it is there --------------------------------------------------------------------------

_SPEED = "{:<37}  {:<6}  {:>8}  {:>15}  {:>7}  {:<5}  {:>6}  {:>5}  {:<4}"
_OTHERS = "{:<29}  {:<22}  {:>7}  {:>8}  {:>15}  {:>7}  {:>8}"
_OMISSIONS = "{:<34}  {:>12}  {:>15}  {:>12}  {:>15}  {:>6}"


def _line(layout: str, cells: Iterable[object]) -> None:
    print(layout.format(*cells).rstrip(), flush=True)


def _heading(layout: str, cells: Sequence[str]) -> None:
    line = layout.format(*cells).rstrip()
    print(f"{line}\n{'-' * len(line)}", flush=True)


def _speed(entries: Sequence[Any], clock: Clock, effort: Effort) -> list[Row]:
    if not entries:
        return []
    from softlimb.bench.figures import median_and_spread, three_digits

    print("\nTable 1: times of the package, one core, tolerance 1e-6, gravity and tip load on")
    _heading(_SPEED, ["what", "way", "us", "quartiles", "ratio", "to", "asked", "aim", "met"])
    rows = []
    for entry in entries:
        for row in entry.measure(entry, clock, effort):
            rows.append(row)
            if row.samples is None:
                print(_wrapped(f"{row.what:<37}  {row.way:<6}  {row.remark}"), flush=True)
                continue
            goal, at_least = row.goal, ">=" if row.goal.at_least else ""
            asked, aim = f"{at_least}{goal.asked:g}", f"{at_least}{goal.aim:g}"
            values = [three_digits(row.value), goal.unit, asked, aim, goal.met(row.value)]
            _line(_SPEED, [row.what, row.way, *median_and_spread(row.samples, us), *values])
    for row in rows:
        if len(row.parts) > 1:
            parts = [f"{three_digits(n)} {name} {three_digits(t / us)} us" for name, (n, t) in row.parts.items()]
            print(_wrapped(f"calls of the core in `{row.name}`: {', '.join(parts)}"))
    return rows


def _others(scenes: Sequence[Any], clock: Clock, effort: Effort, compiled: bool) -> list[Outcome]:
    if not scenes:
        return []
    from softlimb.bench.clock import quartiles
    from softlimb.bench.figures import median_and_spread, three_digits
    from softlimb.bench.others import RIGHT_WITHIN, SIMULATED_WITHIN, compare

    print("\nTable 2: other ways to the same postures, cold, called from Python")
    print(
        _wrapped(
            f"right: the tip within {RIGHT_WITHIN:g} of the limb's length of ours ({SIMULATED_WITHIN:g} for "
            "PyElastica, whose clamp errs by half an element), ours verified by an independent integration"
        )
    )
    outcomes = []
    for scene in scenes:
        print(f"\n{scene.what}")
        _heading(_OTHERS, ["method", "outcome", "tip off", "ms", "quartiles", "x ours", "x Y"])
        for found in compare(scene, clock, effort.limit, compiled):
            outcomes.append(found)
            off = "" if found.off is None else f"{found.off:.0e}"
            if found.samples is None or found.times_ours is None:
                text = f"{found.outcome}, {found.detail}" if found.detail else found.outcome
                print(_wrapped(f"{found.method:<29}  {text}"), flush=True)
                continue
            ratio = quartiles(found.samples.ratios)[1]
            figures = [*median_and_spread(found.samples, ms), three_digits(found.times_ours), three_digits(ratio)]
            _line(_OTHERS, [found.method, found.outcome, off, *figures])
    return outcomes


def _omissions(omissions: Sequence[Any], clock: Clock) -> list[Difference]:
    if not omissions:
        return []
    from softlimb.bench.figures import median_and_spread
    from softlimb.bench.omissions import measure

    print("\nTable 3: what a scene does not need, where the plan of the solve says that it was left out")
    print("cold, from Python; means over scenes of random pressures to 60 kPa")
    rows = [row for omission in omissions if (row := measure(omission, clock)) is not None]
    if not rows:
        print(_wrapped(f"no plan of this build names any of: {', '.join(omission.what for omission in omissions)}"))
        return []
    _heading(_OMISSIONS, ["without", "with [us]", "quartiles", "without [us]", "quartiles", "saved"])
    for row in rows:
        if row.with_it is None or row.without_it is None or row.saved is None:
            print(_wrapped(f"{row.what:<34}  wrong: {row.fault}"))
            continue
        figures = [*median_and_spread(row.with_it, us), *median_and_spread(row.without_it, us)]
        _line(_OMISSIONS, [row.what, *figures, f"{row.saved:.0%}"])
    return rows


def _instructions() -> dict[str, float]:
    from softlimb.bench import instructions

    print("\nInstructions, counted by callgrind (C++ alone)")
    if not instructions.available():
        print("valgrind is not on PATH: nothing counted")
        return {}
    counts = {name: instructions.counted(name, 1) for name in ("yardstick", *instructions.WORKS)}
    for name, count in counts.items():
        what = "a pass of the yardstick" if name == "yardstick" else f"a solve, {name}"
        print(f"{what:<24} {count:>14,.0f}  {count / counts['yardstick']:>8.1f} Y", flush=True)
    return counts


def _yardstick(seconds: Sequence[float], checksum: float) -> dict[str, Any]:
    """Print how the yardstick fared, and return it for the file."""
    import numpy as np

    from softlimb.bench.clock import quartiles
    from softlimb.bench.figures import about_the_yardstick

    readings = np.array(seconds)
    low, middle, high = quartiles(readings)
    lines, void = about_the_yardstick(seconds)
    print("\n".join(lines))
    return {
        "median_us": middle / us,
        "quartiles_us": [low / us, high / us],
        "readings_us": (readings / us).tolist(),
        "checksum": checksum,
        "void": void,
    }


def _wrapped(text: str) -> str:
    return textwrap.fill(text, _WIDTH, subsequent_indent="  ", drop_whitespace=True, break_on_hyphens=False)


def _write(path: Path, figures: dict[str, Any]) -> None:
    path.write_text(json.dumps(figures, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    print(f"figures: {path}")
