"""``softlimb posture``: one posture, as a table and as a picture."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

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
from softlimb.cli.tables import aligned, number, vector, write_csv
from softlimb.units import deg, kPa, mm

if TYPE_CHECKING:
    from softlimb.limb import Posture

Array: TypeAlias = NDArray[np.float64]

_CENTRELINE_POINTS = 131  # every 5 mm of the reference limb at rest


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Arguments of the subcommand."""
    parser = subparsers.add_parser(
        "posture",
        help="solve one posture of a scene",
        description="Find the posture of a limb under its pressures and loads.",
    )
    add_scene(parser)
    add_outputs(parser, "write the plates' table")
    parser.add_argument(
        "--centreline",
        type=new_file,
        metavar="CSV",
        help="write points along the limb (x_mm, y_mm, z_mm) from base to tip",
    )


def run(arguments: argparse.Namespace) -> int:
    """Solve, print, write."""
    scene = scene_of(arguments)
    with naming(arguments.scene):
        posture = scene.solve()
    print(heading(arguments.scene, scene))
    print(loads_line(scene))
    print()
    if not posture.success:
        # The best point is no posture of the limb: shown in any form it would be taken for one.
        print(f"status: {posture.status} after {posture.iterations} iterations: not an equilibrium")
        print(f"message: {posture.message}")
        for kind in ("table", "centreline", "output"):
            path = getattr(arguments, kind)
            if path is not None:
                print(f"not written, there is no equilibrium to show: {path}")
        return 1
    print(plate_table(posture, scene.counts))
    print()
    print(outcome(posture))
    if arguments.table is not None:
        columns = plate_columns(posture, scene.counts)
        write_csv(arguments.table, list(columns), list(zip(*columns.values(), strict=True)))
    if arguments.centreline is not None:
        points = posture.centreline(_CENTRELINE_POINTS) / mm
        write_csv(arguments.centreline, ["x_mm", "y_mm", "z_mm"], [[f"{x:.6f}" for x in point] for point in points])
    if arguments.output is not None:
        from softlimb import plot

        save_picture(plot.limb(posture), arguments.output)
    return 0


def plate_table(posture: Posture, counts: tuple[int, ...]) -> str:
    """One line a segment: its pressures, its rods' lengths along the axis, where the plate at its end is."""
    from softlimb.sweep import bending_angle

    plates = np.asarray(posture.plates)
    columns = {"segment": [str(j) for j in range(1, len(counts) + 1)]}
    if posture.pressures is not None:
        parts = _per_segment(posture.pressures, counts)
        columns["pressures [kPa]"] = [" ".join(number(p, 1) for p in part) for part in parts]
    columns["rod lengths [mm]"] = [" ".join(number(rod.length / mm, 1) for rod in rods) for rods in posture.rods]
    for i, axis in enumerate("xyz"):
        columns[f"plate {axis} [mm]"] = [number(x, 2) for x in plates[:, i, 3] / mm]
    columns["bending [deg]"] = [number(x, 2) for x in bending_angle(plates) / deg]
    return aligned(list(columns), list(zip(*columns.values(), strict=True)))


def plate_columns(posture: Posture, counts: tuple[int, ...]) -> dict[str, list[str]]:
    """The same for a file, with the plates' rotation vectors; cells of actuators that a segment lacks are empty."""
    from softlimb.sweep import bending_angle, rotation_vector

    plates = np.asarray(posture.plates)
    columns = {"segment": [str(j) for j in range(1, len(counts) + 1)]}
    per_actuator = {"rod_length_{}_mm": [np.array([rod.length / mm for rod in rods]) for rods in posture.rods]}
    if posture.pressures is not None:
        per_actuator = {"pressure_{}_kPa": _per_segment(posture.pressures, counts)} | per_actuator
    for name, parts in per_actuator.items():
        for i in range(max(len(rods) for rods in posture.rods)):
            columns[name.format(i + 1)] = [f"{part[i]:.12g}" if i < len(part) else "" for part in parts]
    for i, axis in enumerate("xyz"):
        columns[f"{axis}_mm"] = [f"{x:.12g}" for x in plates[:, i, 3] / mm]
    for i, axis in enumerate("xyz"):
        columns[f"rotation_{axis}_deg"] = [f"{x:.12g}" for x in rotation_vector(plates)[:, i] / deg]
    columns["bending_deg"] = [f"{x:.12g}" for x in bending_angle(plates) / deg]
    return columns


def _per_segment(pressures: Array, counts: tuple[int, ...]) -> list[Array]:
    """In kPa, one array a segment."""
    return np.split(pressures / kPa, np.cumsum(counts)[:-1])


def outcome(posture: Posture) -> str:
    """Status, stability, clearance, base wrench and reference length of an equilibrium in words."""
    stable = "stable" if posture.stable else "UNSTABLE"
    error = f"estimated error {posture.error_estimate:.0e} of the limb's length"
    lines = [f"status: {posture.status} after {posture.iterations} iterations, {error}; {stable}"]
    if posture.message != posture.status:
        lines.append(f"message: {posture.message}")
    if posture.clearance is not None and not posture.touching:  # the message says when they touch
        lines.append(f"smallest gap between tubes: {number(posture.clearance / mm, 2)} mm")
    wrench = np.asarray(posture.base_wrench)
    lines.append(f"ground on base: force {vector(wrench[:3], 3)} N, moment {vector(wrench[3:], 4)} N m")
    if np.any(posture.tip_reaction):
        reaction = posture.tip_reaction
        lines.append(f"hold on tip: force {vector(reaction[:3], 3)} N, moment {vector(reaction[3:], 4)} N m")
    lines.append(f"reference length: {number(posture.limb.length / mm, 1)} mm")
    return "\n".join(lines)
