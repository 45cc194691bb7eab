"""``softlimb workspace``: where the tip gets to, as a table and as a picture."""

from __future__ import annotations

import argparse
import dataclasses
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np

from softlimb.cli.scene_arguments import (
    add_outputs,
    heading,
    loads_line,
    naming,
    new_file,
    save_picture,
    scene_of,
)
from softlimb.cli.tables import aligned, number, write_csv
from softlimb.units import deg, kPa, mm

if TYPE_CHECKING:
    from softlimb.payload import Payload
    from softlimb.scenes import Scene
    from softlimb.workspace import Workspace

_REFERENCE = "reference"
_HIGHEST_KPA = 90.0  # of the paper's experiments
_HALVINGS = 3  # of the samples, to show how sizes settle
_DEFLECTION = 0.1  # of the limb's length: where a payload of the table ends
_DIRECTIONS = {"+x": (1, 0, 0), "-x": (-1, 0, 0), "+y": (0, 1, 0), "-y": (0, -1, 0), "+z": (0, 0, 1), "-z": (0, 0, -1)}


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Arguments of the subcommand."""
    from softlimb.workspace.samples import SAMPLINGS

    parser = subparsers.add_parser(
        "workspace",
        help="where the tip gets to, beside published limbs",
        description="Try pressures up to a limit under a scene's loads: volume by voxels with its error and by the "
        "hull, box, reach, orientation, how they settle, and the limb beside Table II of the paper. Exit code 1 when "
        "no posture counts, 130 after Ctrl-C.",
    )
    parser.add_argument(
        "scene", metavar="SCENE", help=f'a TOML file, a scene of the package, or "{_REFERENCE}": that limb, unloaded'
    )
    parser.set_defaults(pressures_kPa=None)
    parser.add_argument("--tolerance", type=float, metavar="T", help="tip error asked for, relative to the length")
    parser.add_argument("--samples", type=int, default=10_000, metavar="N", help="postures to try (default: 10000)")
    parser.add_argument("--sampling", choices=SAMPLINGS, default="halton", help="how pressures are spread")
    parser.add_argument(
        "--even",
        action="store_true",
        help="spread all pressures evenly: the density is then theirs, but the cloud is thin towards its edge",
    )
    parser.add_argument("--seed", type=int, default=0, metavar="S", help="of the pressures (default: 0)")
    for name, default, text in (("max", _HIGHEST_KPA, "largest"), ("min", 0.0, "smallest")):
        parser.add_argument(
            f"--{name}-pressure-kPa",
            type=float,
            nargs="+",
            default=[default],
            metavar="P",
            help=f"{text} gauge pressure, of all actuators or of each [kPa] (default: {default:g})",
        )
    parser.add_argument("--gravity-m-s2", type=float, nargs=3, metavar=("X", "Y", "Z"), help="in place of the scene's")
    parser.add_argument("--tip-force-N", type=float, nargs=3, metavar=("X", "Y", "Z"), help="in place of the scene's")
    parser.add_argument(
        "--min-clearance-mm", type=float, metavar="D", help="leave out postures whose tubes come nearer than this"
    )
    parser.add_argument(
        "--payload",
        action="store_true",
        help=f"payload in six directions at the scene's pressures (without: half the largest), to a deflection of "
        f"{_DEFLECTION:.0%}% of the length",
    )
    parser.add_argument(
        "--check", type=int, metavar="N", help="ask of N random points of the box whether the tip reaches them"
    )
    add_outputs(parser, "write how the sizes settle")
    parser.add_argument("--file", type=new_file, metavar="FILE", help="keep the rows here, and go on from them")
    parser.add_argument("--threads", type=int, metavar="N", help="rows that are solved at once (default: all cores)")
    parser.add_argument("--no-progress", action="store_true", help="no progress bar")


def run(arguments: argparse.Namespace) -> int:
    """Try, print, write."""
    from softlimb.workspace import beside_published

    scene = _scene(arguments)
    with naming(arguments.scene):
        found = scene.limb.workspace(**_bounds(arguments), **_options(arguments), **scene.solve_options())
    print(heading(arguments.scene, scene))
    print(loads_line(scene))
    print(found.message)
    if not len(found):
        return 130 if found.batch.interrupted else 1
    print()
    settled = _settling(found)
    print(aligned(list(settled), list(zip(*settled.values(), strict=True))))
    print(f"\n{_sizes(found)}")
    if arguments.check is not None:
        asked = found.volume_by_reach(arguments.check)
        print(
            f"volume by reach: {asked.value:.4g} +- {asked.standard_error:.2g} m^3 (standard error), "
            f"{asked.reached} of {asked.points} points of the box"
        )
    print(f"reference length: {scene.limb.length / mm:.1f} mm; solved by {found.batch.build}\n")
    payloads = _payloads(scene, found) if arguments.payload else None
    print(beside_published(found, payloads))
    if arguments.table is not None:
        write_csv(arguments.table, list(settled), list(zip(*settled.values(), strict=True)))
    if arguments.file is not None:
        more = " (the same command goes on with it)" if found.batch.interrupted else ""
        print(f"file: {arguments.file}{more}")
    if arguments.output is not None:
        from softlimb import plot

        save_picture(plot.workspace(found), arguments.output)
    return 130 if found.batch.interrupted else 0


def _scene(arguments: argparse.Namespace) -> Scene:
    from softlimb.presets import reference_limb
    from softlimb.scenes import Scene

    if arguments.scene == _REFERENCE:
        scene = Scene(limb=reference_limb(), title="the reference limb", tolerance=arguments.tolerance)
    else:
        scene = scene_of(arguments)
    for name, given in (("gravity", arguments.gravity_m_s2), ("tip_force", arguments.tip_force_N)):
        if given is not None:
            scene = scene.replaced(**{name: np.array(given)})
    return scene


def _bounds(arguments: argparse.Namespace) -> dict[str, Any]:
    def each(values: list[float]) -> Any:
        return values[0] * kPa if len(values) == 1 else np.array(values) * kPa

    return {"max_pressure": each(arguments.max_pressure_kPa), "min_pressure": each(arguments.min_pressure_kPa)}


def _options(arguments: argparse.Namespace) -> dict[str, Any]:
    clearance = arguments.min_clearance_mm
    even: dict[str, Any] = {"at_bounds": 0.0, "explore": 0.0} if arguments.even else {}
    return even | {
        "samples": arguments.samples,
        "sampling": arguments.sampling,
        "seed": arguments.seed,
        "min_clearance": None if clearance is None else clearance * mm,
        "threads": arguments.threads,
        "progress": not arguments.no_progress,
        "file": arguments.file,
    }


def _settling(found: Workspace) -> dict[str, list[str]]:
    """Sizes of the first eighth, quarter, half of the samples, of all, with the edge rows, and without contact."""
    counts = sorted({max(found.samples // 2**halving, 1) for halving in range(_HALVINGS + 1)})
    parts = {str(count): found.first(count) for count in counts}
    if found.edge_rows:
        parts[f"+ {found.edge_rows} at the edge"] = found
    if found.touching and found.min_clearance is None:
        parts["tubes apart"] = dataclasses.replace(found, min_clearance=0.0)
    table: dict[str, list[str]] = {"samples": list(parts)}
    for axis, name in enumerate("xyz"):
        table[f"box {name} [mm]"] = [number(part.extents[axis] / mm, 1) for part in parts.values()]
    table["reach [mm]"] = [number(part.reach / mm, 1) for part in parts.values()]
    hull = [f"{part.hull_volume:.4g}" for part in parts.values()] if find_spec("scipy") else ["-"] * len(parts)
    table["hull [m^3]"] = hull
    table["voxels [m^3]"] = [f"{part.volume.size:.4g}" for part in parts.values()]
    table["error [m^3]"] = [f"{part.volume.error:.2g}" for part in parts.values()]
    table["voxel [mm]"] = [number(part.volume.cell / mm, 1) for part in parts.values()]
    table["tilt [deg]"] = [number(part.tilt_range[1] / deg, 1) for part in parts.values()]
    return table


def _sizes(found: Workspace) -> str:
    volume, regions = found.volume, found.regions()
    ends = "; ".join(
        f"{name} {number(low / mm, 1)} to {number(high / mm, 1)}"
        for name, low, high in zip("xyz", *found.box, strict=True)
    )
    fullest = int(np.argmax(regions.counts))
    lines = [
        f"tip [mm]: {ends}",
        f"volume: {volume.lower:.4g} m^3 surely inside, {volume.upper:.4g} m^3 at most, {volume.occupied} voxels",
        f"postures a voxel: {int(np.median(regions.counts))} in the middle of all voxels, "
        f"{regions.counts[fullest]} in the fullest",
        f"tilt of the tip: {number(found.tilt_range[0] / deg, 1)} to {number(found.tilt_range[1] / deg, 1)} deg; "
        f"within a voxel up to {regions.spread.max() / deg:.3g} deg off its mean",
    ]
    if not find_spec("scipy"):
        lines.append("hull: not computed, it needs scipy (pip install 'softlimb[workspace]')")
    return "\n".join(lines)


def _payloads(scene: Scene, found: Workspace) -> dict[str, Payload]:
    pressures = 0.5 * found.pressure_range[1] if scene.pressures is None else scene.pressures
    options = {name: value for name, value in scene.solve_options().items() if name != "prefer_stable"}
    limit = _DEFLECTION * scene.limb.length
    return {
        name: scene.limb.payload(along, pressures=pressures, max_deflection=limit, **options)
        for name, along in _DIRECTIONS.items()
    }
