"""``softlimb reach``: pressures that put the tip on a target, as a table and as a picture."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

import numpy as np

from softlimb.cli.posture import outcome, plate_columns, plate_table
from softlimb.cli.scene_arguments import (
    add_outputs,
    add_scene,
    heading,
    loads_line,
    naming,
    save_picture,
    scene_of,
)
from softlimb.cli.tables import aligned, number, write_csv
from softlimb.units import deg, kPa, mm

if TYPE_CHECKING:
    from softlimb.reach import Reach
    from softlimb.scenes import Scene

_HIGHEST_KPA = 100.0


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Arguments of the subcommand."""
    parser = subparsers.add_parser(
        "reach",
        help="find pressures for a target of the tip",
        description="Find pressures within bounds that put the tip of a scene's limb on a target, under the scene's "
        "loads and with the least effort; where the target is out of reach, those that come nearest. Exit code 1 when "
        "it is not reached.",
    )
    add_scene(parser, pressures=False)
    parser.add_argument(
        "--position-mm", type=float, nargs=3, required=True, metavar=("X", "Y", "Z"), help="target of the tip [mm]"
    )
    parser.add_argument(
        "--rotation-deg",
        type=float,
        nargs=3,
        metavar=("RX", "RY", "RZ"),
        help="and its rotation vector: axis times angle [deg], base axes",
    )
    parser.add_argument(
        "--max-pressure-kPa",
        type=float,
        nargs="+",
        default=[_HIGHEST_KPA],
        metavar="P",
        help=f"largest gauge pressure, of all actuators or of each [kPa] (default: {_HIGHEST_KPA:g})",
    )
    parser.add_argument(
        "--min-pressure-kPa",
        type=float,
        nargs="+",
        default=[0.0],
        metavar="P",
        help="smallest, in the same way [kPa] (default: 0)",
    )
    parser.add_argument(
        "--prefer-kPa",
        type=float,
        nargs="+",
        metavar="P",
        help="of all pressures that reach take those nearest to these, in the same way [kPa] (default: 0)",
    )
    add_outputs(parser, "write the plates' table")


def run(arguments: argparse.Namespace) -> int:
    """Search, print, write."""
    scene = scene_of(arguments)
    with naming(arguments.scene):
        found = scene.limb.reach(**_target(arguments), **_bounds(arguments), **_options(scene))
    print(heading(arguments.scene, scene))
    print(loads_line(scene))
    print()
    if not (found.posture.success and found.posture.stable):
        # What was met is no posture that the limb would keep: shown in any form it would be taken for one.
        print(f"status: {found.status}\nmessage: {found.message}")
        return 1
    print(_target_table(found))
    print()
    print(plate_table(found.posture, scene.counts))
    print()
    print("target: " + found.message)
    print(outcome(found.posture))
    if arguments.table is not None:
        columns = plate_columns(found.posture, scene.counts)
        write_csv(arguments.table, list(columns), list(zip(*columns.values(), strict=True)))
    if arguments.output is not None:
        from softlimb import plot

        save_picture(plot.reach(found), arguments.output)
    return 0 if found.reached else 1


def _target(arguments: argparse.Namespace) -> dict[str, Any]:
    position = np.array(arguments.position_mm) * mm
    if not np.isfinite(position).all():
        raise ValueError(f"--position-mm must be finite, got {arguments.position_mm}")
    if arguments.rotation_deg is None:
        return {"position": position}
    vector = np.array(arguments.rotation_deg) * deg
    if not np.isfinite(vector).all():
        raise ValueError(f"--rotation-deg must be finite, got {arguments.rotation_deg}")
    from softlimb.sweep import rotation_matrix

    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation_matrix(vector), position
    return {"pose": pose}


def _bounds(arguments: argparse.Namespace) -> dict[str, Any]:
    def each(values: list[float]) -> Any:
        return values[0] * kPa if len(values) == 1 else np.array(values) * kPa

    bounds = {"max_pressure": each(arguments.max_pressure_kPa), "min_pressure": each(arguments.min_pressure_kPa)}
    return bounds if arguments.prefer_kPa is None else bounds | {"prefer": each(arguments.prefer_kPa)}


def _options(scene: Scene) -> dict[str, Any]:
    """The scene's loads and holds; an answer is stable in any case."""
    return {name: value for name, value in scene.solve_options().items() if name != "prefer_stable"}


def _target_table(found: Reach) -> str:
    """Target, tip and their difference, a line each."""
    from softlimb.sweep import rotation_vector

    tip, target, gap = found.posture.tip, found.target, found.gap
    rows = [["target"], ["tip"], ["tip - target"]]
    for i in range(3):
        for row, x in zip(rows, (target[i, 3], tip[i, 3], gap[i]), strict=True):
            row.append(number(x / mm, 3))
    headings = ["", *(f"{axis} [mm]" for axis in "xyz")]
    if found.weights[3:].any():
        headings += [f"rotation {axis} [deg]" for axis in "xyz"]
        vectors = rotation_vector(np.stack([target, tip]))
        for row, vector in zip(rows, (vectors[0], vectors[1], gap[3:]), strict=True):
            row += [number(x / deg, 3) for x in vector]
    return aligned(headings, rows)
