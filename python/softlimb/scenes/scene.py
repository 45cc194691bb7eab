"""A scene: a limb, its pressures and loads, what is asked of the solver, and the ranges of a sweep.

As a TOML file; everything but the limb may be left out, and any unit of the right dimension will do::

    [limb]
    preset = "reference-limb"       # with segments = ["proximal", ...] for a part of it; or
    # file = "limb.toml"            # beside this file; or the limb itself, as `softlimb.scenes.limb_file` shows

    [scene]
    title = "Pushed aside"
    pressures_kPa = [[90, 60, 30], [60, 40, 20], [50, 50, 50]]   # one list a segment, or flat
    # rest_lengths_mm = [...]       # of all rods, in place of pressures
    gravity_m_s2 = [0, 0, 9.81]
    tip_force_N = [0.5, 0, 0]
    tip_moment_Nm = [0, 0, 0.01]
    frame = "base"                  # or "plate": forces and moments turn with their plate
    tolerance = 1e-6                # tip error asked for, relative to the limb's length
    section = "tangent"             # or "nonlinear", "paper"
    valve = "open"                  # or "locked"
    prefer_stable = true

    [[scene.plate_loads]]           # segments, plates, rods and actuators count from 1, from the base
    plate = 2
    force_N = [0, 1, 0]
    moment_Nm = [0, 0, 0]

    [[scene.rod_loads]]             # without `rod`: on all rods of the segment
    segment = 1
    rod = 3
    force_per_length_N_m = [0, 2, 0]

    [scene.held_tip]
    position_mm = [100, 0, 700]
    rotation = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    freedoms = ["x", "y", "z", "rotation_x", "rotation_y", "rotation_z"]

    [[scene.sweep]]                 # one axis of a grid, no actuator in two; the last runs fastest
    actuators = [[1, 1], [1, 2]]    # or segment = 1
    from_kPa = 0                    # or values_kPa = [...]
    to_kPa = 60
    points = 13

    [[scene.sweep]]                 # the scene's own pressures in proportion
    factors = [0.5, 1.0]
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb.quantities import (
    ACCELERATION,
    FORCE,
    FORCE_PER_LENGTH,
    LENGTH,
    MOMENT,
    MOMENT_PER_LENGTH,
    PRESSURE,
    Dimension,
    Nested,
    named_quantity,
)
from softlimb.scenes.limb_file import limb_from_dict, limb_to_dict, pose_from_dict, pose_to_dict, read_limb
from softlimb.scenes.ranges import Axis, axis_from_dict, axis_to_dict, grid, require_distinct, require_few
from softlimb.scenes.table import Table, read_document, write_document

if TYPE_CHECKING:
    from softlimb.limb import Limb, Posture
    from softlimb.sweep import Batch

_ZERO = (0.0, 0.0, 0.0)
_FREEDOMS = ("x", "y", "z", "rotation_x", "rotation_y", "rotation_z")
_QUANTITIES: dict[str, Dimension] = {
    "pressures": PRESSURE,
    "rest_lengths": LENGTH,
    "gravity": ACCELERATION,
    "tip_force": FORCE,
    "tip_moment": MOMENT,
}
_OTHERS = (
    "title",
    "description",
    "frame",
    "plate_loads",
    "rod_loads",
    "held_tip",
    "tolerance",
    "section",
    "valve",
    "prefer_stable",
    "sweep",
)


@dataclass(frozen=True, kw_only=True, eq=False)
class Scene:
    """What a limb is asked to do.

    Parameters
    ----------
    limb : Limb
    pressures : array of float, shape (A,), optional
        Gauge pressures [Pa], segment by segment; or
    rest_lengths : array of float, shape (R,), optional
        Unloaded lengths of the rods [m] in their place.
    gravity : array of float, shape (3,)
        Acceleration in the base frame [m/s^2].
    tip_force, tip_moment : array of float, shape (3,)
        On the tip, at the tip frame's origin [N], [N m].
    plate_wrenches : array of float, shape (J, 6), optional
        Force and moment on each plate, at its frame's origin [N], [N m].
    frame : "base" or "plate"
        Axes of the loads: dead, or following the plate.
    rod_forces, rod_moments : sequence of arrays of float, shape (n_j, 3), optional
        Force and moment per rest length on each rod of each segment [N/m], [N], base axes.
    tip_pose : array of float, shape (4, 4), optional
        Where the tip is held.
    tip_held : tuple of 6 bool, optional
        Which freedoms of the tip are held: x, y, z, rotations about x, y, z.
    tolerance : float, optional
        Tip error asked for relative to the limb's length. None leaves the solver's default, here and below.
    section, valve : str, optional
        As `Limb.solve` takes them.
    prefer_stable : bool, optional
    sweep_axes : tuple of Axis
        Ranges of `sweep`.
    title, description : str
    """

    limb: Limb
    pressures: NDArray[np.float64] | None = None
    rest_lengths: NDArray[np.float64] | None = None
    gravity: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    tip_force: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    tip_moment: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    plate_wrenches: NDArray[np.float64] | None = None
    frame: str = "base"
    rod_forces: tuple[NDArray[np.float64], ...] | None = None
    rod_moments: tuple[NDArray[np.float64], ...] | None = None
    tip_pose: NDArray[np.float64] | None = None
    tip_held: tuple[bool, ...] | None = None
    tolerance: float | None = None
    section: str | None = None
    valve: str | None = None
    prefer_stable: bool | None = None
    sweep_axes: tuple[Axis, ...] = ()
    title: str = ""
    description: str = ""

    def __post_init__(self) -> None:
        from softlimb.limb import Limb

        if not isinstance(self.limb, Limb):
            raise ValueError(f"limb must be a Limb, got {self.limb!r}")
        require_distinct(self.sweep_axes)
        require_few(self.sweep_axes)

    @property
    def counts(self) -> tuple[int, ...]:
        """Number of actuators of each segment."""
        return actuator_counts(self.limb)

    def __eq__(self, other: object) -> bool:
        """The same limb and the same numbers; loads of zero are the same as none."""
        if not isinstance(other, Scene):
            return NotImplemented
        return self.limb == other.limb and all(
            _same(mine, theirs) for mine, theirs in zip(self._compared(), other._compared(), strict=True)
        )

    def __hash__(self) -> int:
        return hash((self.limb, self.title, self.description, self.frame, self.tolerance))

    def _compared(self) -> list[Any]:
        """What equality looks at besides the limb: every field, a load of zeros like no load."""
        values = {entry.name: getattr(self, entry.name) for entry in dataclasses.fields(self) if entry.name != "limb"}
        for name in ("plate_wrenches", "rod_forces", "rod_moments"):
            if values[name] is not None and not any(np.any(part) for part in values[name]):
                values[name] = None
        if self.tip_pose is not None and self.tip_held is None:
            values["tip_held"] = (True,) * 6
        return list(values.values())

    def solve(self, pressures: ArrayLike | None = None, **options: Any) -> Posture:
        """The posture of the scene.

        Parameters
        ----------
        pressures : array_like, shape (A,), optional
            Gauge pressures [Pa] in place of the scene's own.
        **options
            Further arguments of `Limb.solve`; they overrule the scene's.

        Returns
        -------
        Posture

        Raises
        ------
        ValueError
            There are no pressures, neither here nor in the scene; or `Limb.solve` refuses them.
        """
        loads = self.solve_options() | options
        if pressures is None and self.rest_lengths is not None:
            return self.limb.solve(rest_lengths=self.rest_lengths, **loads)
        if pressures is None and self.pressures is None and sum(self.counts) > 0:
            raise ValueError("the scene has no pressures: add `pressures_kPa` to [scene], or give them")
        return self.limb.solve(self.pressures if pressures is None else pressures, **loads)

    def sweep(self, **options: Any) -> Batch:
        """One posture for each combination of the sweep's ranges.

        Parameters
        ----------
        **options
            ``threads``, ``executor``, ``progress``, ``ordered``, ``file`` of `Limb.sweep`.

        Raises
        ------
        ValueError
            The scene has no ranges; or as `Limb.sweep`.
        """
        from softlimb.sweep import sweep

        return sweep(self.limb, self.sweep_pressures(), **self.solve_options() | options)

    def sweep_pressures(self) -> NDArray[np.float64]:
        """Pressures of the sweep [Pa], shape (N, A): the last range runs fastest.

        Raises
        ------
        ValueError
            The scene has no ranges.
        """
        if not self.sweep_axes:
            raise ValueError("the scene has no ranges to sweep: add a table `[[scene.sweep]]`")
        own = np.zeros(sum(self.counts)) if self.pressures is None else self.pressures
        return grid(own, self.sweep_axes, self.counts)

    def solve_options(self) -> dict[str, Any]:
        """Arguments of `Limb.solve` other than the pressures, those that the scene leaves open left out."""
        names = ("plate_wrenches", "rod_forces", "rod_moments", "tip_pose", "tip_held", "tolerance", "section", "valve")
        given = {name: getattr(self, name) for name in (*names, "prefer_stable")}
        loads = {"gravity": self.gravity, "tip_force": self.tip_force, "tip_moment": self.tip_moment}
        return loads | {"frame": self.frame} | {name: value for name, value in given.items() if value is not None}

    def replaced(self, **changes: Any) -> Scene:
        """The same scene with some fields changed."""
        return dataclasses.replace(self, **changes)

    @classmethod
    def from_toml(cls, path: str | Path) -> Scene:
        """Read a scene file.

        Parameters
        ----------
        path : str or Path
            A file name; ``file = ...`` inside is relative to its folder.

        Raises
        ------
        FileNotFoundError
            The scene or the limb it refers to is missing.
        ValueError
            Not TOML, or a key is unknown, missing, of a wrong type or without unit; the message names file and table.
        """
        path = Path(path)
        try:
            return cls.from_dict(read_document(path), path.parent)
        except ValueError as error:
            raise ValueError(error if str(path) in str(error) else f"{path}: {error}") from None

    @classmethod
    def from_dict(cls, content: Mapping[str, Any], folder: str | Path = ".") -> Scene:
        """Build a scene from the tables of a TOML document.

        Parameters
        ----------
        content : mapping
            Tables ``limb`` and ``scene``.
        folder : str or Path
            Where ``file = ...`` starts from.
        """
        top = Table(content, "", others=("limb", "scene"))
        if "limb" not in top:
            raise ValueError("missing table [limb]: give `preset`, `file`, or the limb itself")
        limb = _limb_of(top.mapping("limb"), Path(folder))
        table = Table(top.mapping("scene"), "scene", quantities=_QUANTITIES, others=_OTHERS)
        counts = actuator_counts(limb)
        if "pressures" in table and "rest_lengths" in table:
            raise table.error("give either `pressures` or `rest_lengths`: got both")
        axes = tuple(axis_from_dict(*part, counts) for part in table.mappings("sweep"))
        return cls(
            limb=limb,
            pressures=_per_actuator(table, "pressures", counts),
            rest_lengths=_per_actuator(table, "rest_lengths", rod_counts(limb)),
            gravity=table.array("gravity", (3,), _ZERO),
            tip_force=table.array("tip_force", (3,), _ZERO),
            tip_moment=table.array("tip_moment", (3,), _ZERO),
            plate_wrenches=_plate_wrenches(table, len(counts)),
            frame=table.text("frame", "base", choices=("base", "plate")),
            **_rod_loads(table, rod_counts(limb)),
            **_held_tip(table),
            tolerance=table.number("tolerance") if "tolerance" in table else None,
            section=table.text("section") if "section" in table else None,
            valve=table.text("valve") if "valve" in table else None,
            prefer_stable=table.boolean("prefer_stable") if "prefer_stable" in table else None,
            sweep_axes=axes,
            title=table.text("title", ""),
            description=table.text("description", ""),
        )

    def to_dict(self) -> dict[str, Any]:
        """Tables ``limb`` and ``scene`` of a document; the limb stands inside, so that the file stands alone."""
        scene: dict[str, Any] = {name: getattr(self, name) for name in ("title", "description") if getattr(self, name)}
        for name in ("pressures", "rest_lengths"):
            value = getattr(self, name)
            if value is not None:
                counts = self.counts if name == "pressures" else rod_counts(self.limb)
                scene |= _entry(name, split(value, counts), _QUANTITIES[name])
        for name in ("gravity", "tip_force", "tip_moment"):
            if np.any(getattr(self, name)):
                scene |= _entry(name, getattr(self, name).tolist(), _QUANTITIES[name])
        for name in ("tolerance", "section", "valve", "prefer_stable"):
            if getattr(self, name) is not None:
                scene[name] = getattr(self, name)
        scene["frame"] = self.frame
        if self.plate_wrenches is not None:
            scene["plate_loads"] = [
                {"plate": j} | _entry("force", w[:3].tolist(), FORCE) | _entry("moment", w[3:].tolist(), MOMENT)
                for j, w in enumerate(self.plate_wrenches, start=1)
                if np.any(w)
            ]
        loads = self._rod_load_tables()
        if loads:
            scene["rod_loads"] = loads
        if self.tip_pose is not None:
            held = self.tip_held or (True,) * 6
            names = [name for name, holds in zip(_FREEDOMS, held, strict=True) if holds]
            scene["held_tip"] = pose_to_dict(self.tip_pose) | {"freedoms": names}
        if self.sweep_axes:
            scene["sweep"] = [axis_to_dict(axis) for axis in self.sweep_axes]
        return {"limb": limb_to_dict(self.limb), "scene": scene}

    def _rod_load_tables(self) -> list[dict[str, Any]]:
        tables = []
        for j, count in enumerate(rod_counts(self.limb)):
            for i in range(count):
                table: dict[str, Any] = {}
                if self.rod_forces is not None and np.any(self.rod_forces[j][i]):
                    table |= _entry("force_per_length", self.rod_forces[j][i].tolist(), FORCE_PER_LENGTH)
                if self.rod_moments is not None and np.any(self.rod_moments[j][i]):
                    table |= _entry("moment_per_length", self.rod_moments[j][i].tolist(), MOMENT_PER_LENGTH)
                if table:
                    tables.append({"segment": j + 1, "rod": i + 1} | table)
        return tables

    def to_toml(self, path: str | Path) -> None:
        """Write the scene with its limb to a file that `from_toml` reads back to the same numbers."""
        write_document(self.to_dict(), path)


def _same(one: Any, other: Any) -> bool:
    """Equal, arrays and tuples of arrays entry by entry."""
    if one is None or other is None:
        return one is other
    if isinstance(one, (tuple, list)) and isinstance(other, (tuple, list)):
        return len(one) == len(other) and all(_same(a, b) for a, b in zip(one, other, strict=True))
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return np.array_equal(one, other)
    return bool(one == other)


def actuator_counts(limb: Limb) -> tuple[int, ...]:
    """Number of actuators of each segment; rods given directly do not count."""
    return tuple(len(segment.actuators) for segment in limb.segments)


def rod_counts(limb: Limb) -> tuple[int, ...]:
    """Number of rods of each segment, those that stand for actuators among them."""
    return tuple(len(segment.members) for segment in limb.segments)


def split(flat: NDArray[np.float64], counts: Sequence[int]) -> list[Any]:
    """Numbers in flat order as one list a segment."""
    return [part.tolist() for part in np.split(flat, np.cumsum(counts)[:-1])]


def available_scenes() -> list[str]:
    """Names of the scenes that come with the package."""
    from importlib.resources import files

    return sorted(entry.name[:-5] for entry in files("softlimb.scenes").iterdir() if entry.name.endswith(".toml"))


def load_scene(name: str | Path) -> Scene:
    """A scene by file name, or by the name of one that comes with the package.

    Raises
    ------
    FileNotFoundError
        Neither a file nor a known name; the message lists the names.
    ValueError
        As `Scene.from_toml`.
    """
    from importlib.resources import as_file, files

    if Path(name).exists() or Path(name).suffix == ".toml":
        return Scene.from_toml(name)
    known = available_scenes()
    if str(name) not in known:
        nearest = get_close_matches(str(name), known, n=1)
        hint = f"did you mean `{nearest[0]}`?" if nearest else f"the package has {', '.join(known)}"
        raise FileNotFoundError(f"there is no scene file and no scene named `{name}`: {hint}")
    with as_file(files("softlimb.scenes") / f"{name}.toml") as path:
        return Scene.from_toml(path)


def _entry(quantity: str, value: Nested, dimension: Dimension) -> dict[str, Nested]:
    key, number = named_quantity(quantity, value, dimension)
    return {key: number}


def _limb_of(content: Mapping[str, Any], folder: Path) -> Limb:
    from softlimb.presets import PRESETS

    if "preset" in content:
        table = Table(content, "limb", others=("preset", "segments"))
        name = table.text("preset")
        if name not in PRESETS:
            nearest = get_close_matches(name, PRESETS, n=1)
            hint = f": did you mean {nearest[0]!r}?" if nearest else f": known are {', '.join(PRESETS)}"
            raise table.error(f"unknown preset {name!r}{hint}")
        options = {"segments": table.texts("segments")} if "segments" in table else {}
        try:
            return PRESETS[name](**options)
        except ValueError as error:
            raise table.error(f"{error},") from None
    if "file" in content:
        path = folder / Table(content, "limb", others=("file",)).text("file")
        return read_limb(path)
    return limb_from_dict(content, "limb")


def _per_actuator(table: Table, name: str, counts: Sequence[int]) -> NDArray[np.float64] | None:
    """Flat numbers from a flat list or from one list a segment."""
    if name not in table:
        return None
    numbers = table.nested(name)
    rows = numbers if isinstance(numbers, list) else [numbers]
    flat: list[float] = []
    if any(isinstance(row, list) for row in rows):
        for row in rows:
            if not isinstance(row, list) or any(isinstance(entry, list) for entry in row):
                raise table.error(f"`{table.key(name)}` must be one list of numbers a segment, or one flat list,")
        found = [len(row) for row in rows if isinstance(row, list)]
        if found != list(counts):
            raise table.error(f"`{table.key(name)}` has {found} numbers a segment, expected {list(counts)},")
        flat = [entry for row in rows if isinstance(row, list) for entry in row if isinstance(entry, float)]
    else:
        flat = [row for row in rows if isinstance(row, float)]
        if len(flat) != sum(counts):
            raise table.error(f"`{table.key(name)}` has {len(flat)} numbers, expected {sum(counts)},")
    return np.array(flat, dtype=float)


def _counted(table: Table, name: str, count: int) -> int:
    number = table.integer(name)
    if not 1 <= number <= count:
        raise table.error(f"`{name}` must be within [1, {count}] (counted from the base, from 1), got {number},")
    return number


def _plate_wrenches(table: Table, plates: int) -> NDArray[np.float64] | None:
    wrenches = np.zeros((plates, 6))
    parts = table.mappings("plate_loads")
    for content, where in parts:
        load = Table(content, where, quantities={"force": FORCE, "moment": MOMENT}, others=("plate",))
        if "force" not in load and "moment" not in load:
            raise load.error("missing key `force_N` or `moment_Nm`")
        wrench = np.concatenate([load.array("force", (3,), _ZERO), load.array("moment", (3,), _ZERO)])
        wrenches[_counted(load, "plate", plates) - 1] += wrench
    return wrenches if parts else None


def _rod_loads(table: Table, counts: Sequence[int]) -> dict[str, Any]:
    """Forces and moments along rods; a table without `rod` loads all rods of its segment."""
    loads = {name: tuple(np.zeros((count, 3)) for count in counts) for name in ("rod_forces", "rod_moments")}
    given = set()
    quantities = {"force_per_length": FORCE_PER_LENGTH, "moment_per_length": MOMENT_PER_LENGTH}
    for content, where in table.mappings("rod_loads"):
        load = Table(content, where, quantities=quantities, others=("segment", "rod"))
        segment = _counted(load, "segment", len(counts)) - 1
        rods = [_counted(load, "rod", counts[segment]) - 1] if "rod" in load else list(range(counts[segment]))
        if not any(key in load for key in quantities):
            raise load.error("missing key `force_per_length_N_m` or `moment_per_length_Nm_m`")
        for key, name in (("force_per_length", "rod_forces"), ("moment_per_length", "rod_moments")):
            if key in load:
                loads[name][segment][rods] += load.array(key, (3,))
                given.add(name)
    return {name: loads[name] for name in given}


def _held_tip(table: Table) -> dict[str, Any]:
    if "held_tip" not in table:
        return {}
    content = dict(table.mapping("held_tip"))
    part = Table(content, table.path("held_tip"), quantities={"position": LENGTH}, others=("rotation", "freedoms"))
    held = part.texts("freedoms") if "freedoms" in part else list(_FREEDOMS)
    for name in held:
        if held.count(name) > 1:
            raise part.error(f"`freedoms` lists {name!r} {held.count(name)} times")
        if name not in _FREEDOMS:
            raise part.error(f"`freedoms` must be out of {', '.join(_FREEDOMS)}, got {name!r},")
    content.pop("freedoms", None)
    return {"tip_pose": pose_from_dict(content, part.where), "tip_held": tuple(name in held for name in _FREEDOMS)}
