"""What posture, reach, sweep and compare have in common: the scene, its pressures, and how they are shown."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from softlimb.units import kPa

if TYPE_CHECKING:
    from softlimb.scenes import Scene

_PICTURES = (".png", ".pdf", ".svg", ".jpg", ".jpeg", ".tif", ".tiff", ".eps")


def add_scene(parser: argparse.ArgumentParser, *, pressures: bool = True) -> None:
    """The scene, by file or by name, and what overrules it: with its pressures, unless they are what is sought."""
    from softlimb.scenes import available_scenes

    names = ", ".join(available_scenes())
    parser.add_argument("scene", metavar="SCENE", help=f"a TOML file, or a scene of the package: {names}")
    parser.set_defaults(pressures_kPa=None)
    if pressures:
        parser.add_argument(
            "--pressures-kPa",
            type=float,
            nargs="+",
            metavar="P",
            help="gauge pressures in place of the scene's own [kPa], segment by segment",
        )
    parser.add_argument(
        "--tolerance", type=float, metavar="T", help="tip error asked for, relative to the limb's length"
    )


def add_outputs(parser: argparse.ArgumentParser, table: str) -> None:
    """Where picture and table go."""
    parser.add_argument("--output", type=picture, metavar="PNG", help="write a picture (PNG, PDF or SVG)")
    parser.add_argument("--table", type=new_file, metavar="CSV", help=table)


def new_file(name: str) -> Path:
    """Where a file can be written, checked before the work and not after it.

    Raises
    ------
    argparse.ArgumentTypeError
        No name, the name of a folder, or its folder is missing or cannot be written to.
    """
    from tempfile import TemporaryFile

    path = Path(name)
    if not name.strip():
        raise argparse.ArgumentTypeError("expected the name of a file, got an empty one")
    if path.is_dir():
        raise argparse.ArgumentTypeError(f"expected the name of a file, {name!r} is a folder")
    if not path.parent.is_dir():
        raise argparse.ArgumentTypeError(f"cannot write {name}: there is no folder {path.parent}")
    try:
        # Permissions alone do not tell: some folders take no files from anybody.
        with TemporaryFile(dir=path.parent):
            pass
    except OSError as error:
        raise argparse.ArgumentTypeError(f"cannot write {name}: {error.strerror} in {path.parent}") from None
    return path


def new_folder(name: str) -> Path:
    """A folder that is there, or that can be made.

    Raises
    ------
    argparse.ArgumentTypeError
        No name, the name of a file, or the folder that it would be in is missing.
    """
    path = Path(name)
    if not name.strip():
        raise argparse.ArgumentTypeError("expected the name of a folder, got an empty one")
    if path.exists() and not path.is_dir():
        raise argparse.ArgumentTypeError(f"expected the name of a folder, {name!r} is a file")
    if not path.parent.is_dir():
        raise argparse.ArgumentTypeError(f"cannot make the folder {name}: there is no folder {path.parent}")
    return path


def picture(name: str) -> Path:
    """A `new_file` whose ending says a format of pictures."""
    path = new_file(name)
    if path.suffix.lower() not in _PICTURES:
        raise argparse.ArgumentTypeError(f"{name!r} must end in one of {', '.join(_PICTURES)}")
    return path


def scene_of(arguments: argparse.Namespace) -> Scene:
    """The scene that the arguments name, with their changes."""
    from softlimb.scenes import load_scene

    scene = load_scene(arguments.scene)
    if arguments.tolerance is not None:
        if not 1e-12 <= arguments.tolerance <= 0.1:  # as of a solve
            raise ValueError(f"--tolerance must be within 1e-12 and 0.1, got {arguments.tolerance:g}")
        scene = scene.replaced(tolerance=arguments.tolerance)
    if arguments.pressures_kPa is None:
        return scene
    pressures = np.array(arguments.pressures_kPa) * kPa
    if len(pressures) != sum(scene.counts):
        raise ValueError(f"--pressures-kPa has {len(pressures)} numbers but the limb has {sum(scene.counts)} actuators")
    if not np.all(np.isfinite(pressures)):
        raise ValueError("--pressures-kPa must be finite")
    return scene.replaced(pressures=pressures, rest_lengths=None)


@contextmanager
def naming(scene: str) -> Iterator[None]:
    """Put the scene's name before what is wrong with it, unless the message has it."""
    try:
        yield
    except ValueError as error:
        raise ValueError(error if scene in str(error) else f"{scene}: {error}") from None


def heading(name: str, scene: Scene) -> str:
    """Name and title of a scene."""
    return f"{name}: {scene.title}" if scene.title else name


def loads_line(scene: Scene) -> str:
    """What acts on the limb, in one line."""
    from softlimb.cli.tables import vector

    parts = []
    for name, values, unit in (
        ("gravity", scene.gravity, "m/s^2"),
        ("tip force", scene.tip_force, "N"),
        ("tip moment", scene.tip_moment, "N m"),
    ):
        if np.any(values):
            parts.append(f"{name} {vector(values, 6)} {unit}")
    for j, wrench in enumerate([] if scene.plate_wrenches is None else scene.plate_wrenches, start=1):
        if np.any(wrench):
            parts.append(f"plate {j}: force {vector(wrench[:3], 6)} N, moment {vector(wrench[3:], 6)} N m")
    if scene.rod_forces is not None or scene.rod_moments is not None:
        parts.append("loads along rods")
    if scene.tip_pose is not None:
        parts.append("tip held")
    return "loads: " + ("; ".join(parts) if parts else "none")


def save_picture(figure: object, path: Path) -> None:
    """Write a figure; the ending of the name says the format."""
    from matplotlib.figure import Figure

    assert isinstance(figure, Figure)
    figure.savefig(path)
    print(f"picture: {path}")
