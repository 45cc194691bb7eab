"""A limb as a TOML document, and back bit for bit.

The document names what it uses more than once, and the segments refer to it::

    [materials.skin]
    law = "yeoh"
    c1_MPa = 0.0861
    c2_MPa = 0.0136

    [tubes.proximal]
    length_mm = 200
    mass_g = 98
    layers = [
        { inner_radius_mm = 18, outer_radius_mm = 20.5, material = "dragon-skin-30" },
        { inner_radius_mm = 20.5, outer_radius_mm = 21.5, material = "skin", fibres = [
            { angle_deg = 1.33, modulus_GPa = 31.067, fraction = 0.0083 },
            { angle_deg = -1.33, modulus_GPa = 31.067, fraction = 0.0083 },
        ] },
    ]

    [tubes.distal]  # the short form, for `Tube.fibre_reinforced`
    length_mm = 200
    radii_mm = [9, 10.25, 10.75]
    core = "dragon-skin-30"
    skin = "dragon-skin-30"
    thread_diameter_mm = 0.18
    pitch_mm = 3

    [[segments]]
    actuators = ["proximal", "proximal", "proximal"]
    ring_radius_mm = 28
    plate = { thickness_mm = 25, mass_g = 140 }

A material that the document does not define is looked up in `softlimb.materials`. Rods given directly stand under
``[rods.<name>]`` and a segment lists them as ``rods = [...]``; ``base_frames`` and ``end_frames`` replace the ring.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from softlimb.arguments import is_rotation
from softlimb.quantities import (
    ANGLE,
    BENDING_STIFFNESS,
    COMPLIANCE,
    COUPLING,
    DENSITY,
    FORCE,
    LENGTH,
    MASS,
    MASS_PER_LENGTH,
    PRESSURE,
    TWIST_PER_LENGTH,
    Dimension,
    Nested,
    named_quantity,
)
from softlimb.scenes.table import Table, read_document, write_document

if TYPE_CHECKING:
    from softlimb import Section
    from softlimb.limb import Limb, Plate, Rod, Segment
    from softlimb.materials import Law
    from softlimb.tube import Fibres, Layer, Tube


Thing = TypeVar("Thing")


class _Namer:
    """Gives equal things one name: the tables `[materials.*]`, `[tubes.*]`, `[rods.*]` of a document."""

    def __init__(self, stem: str) -> None:
        self.stem = stem
        self.things: list[Any] = []
        self.tables: dict[str, dict[str, Any]] = {}

    def name_of(self, thing: Any, table: Callable[[], dict[str, Any]]) -> str:
        for i, known in enumerate(self.things, start=1):
            if known == thing:
                return f"{self.stem}-{i}"
        self.things.append(thing)
        name = f"{self.stem}-{len(self.things)}"
        self.tables[name] = table()
        return name


def _entry(quantity: str, value: Any, dimension: Dimension, *prefer: str) -> dict[str, Nested]:
    """One key with its unit."""
    number: Nested = value.tolist() if isinstance(value, np.ndarray) else value
    key, number = named_quantity(quantity, number, dimension, prefer)
    return {key: number}


# Every law's coefficients are pressures except these. A file gives them under the law's own parameter names.
_PLAIN_COEFFICIENTS = ("alpha", "jm")
_SECTION_QUANTITIES: dict[str, Dimension] = {
    "axial": FORCE,
    "shear": FORCE,
    "bending": BENDING_STIFFNESS,
    "torsion": BENDING_STIFFNESS,
    "mass_per_length": MASS_PER_LENGTH,
    "rest_twist": TWIST_PER_LENGTH,
    "extension_twist": COUPLING,
}
# Places in the state that pickles a section (cpp/bindings/section.cpp).
_STRETCHES, _AXIAL_LAW = slice(7, 9), slice(9, 13)
_STIFFNESSES = ("axial", "shear", "bending", "torsion")


def limb_to_dict(limb: Limb) -> dict[str, Any]:
    """Describe a limb by plain tables, ready for a TOML writer.

    Parameters
    ----------
    limb : Limb
        Built of tubes, of rods, or of both.

    Returns
    -------
    dict
        As `limb_from_dict` reads it; the limb it makes equals `limb` bit for bit.
    """
    materials, tubes, rods = _Namer("material"), _Namer("tube"), _Namer("rod")
    segments = [_segment_to_dict(segment, materials, tubes, rods) for segment in limb.segments]
    document = {"materials": materials.tables, "tubes": tubes.tables, "rods": rods.tables, "segments": segments}
    return {name: content for name, content in document.items() if content}


def limb_from_dict(content: Mapping[str, Any], where: str = "") -> Limb:
    """Build the limb that tables of a TOML document describe.

    Parameters
    ----------
    content : mapping
        Tables ``materials``, ``tubes``, ``rods``, ``segments``.
    where : str
        Path of the limb's table in its document, for messages.

    Returns
    -------
    Limb

    Raises
    ------
    ValueError
        A key is unknown, missing, of the wrong type, not finite or has no unit; a name refers to nothing; or the limb's
        own checks fail. The message says in which table.
    """
    from softlimb.limb import Limb

    top = Table(content, where, others=("materials", "tubes", "rods", "segments"))
    laws = {name: _law_from_dict(*part) for name, part in _named_tables(top, "materials").items()}
    tubes = {name: _tube_from_dict(*part, laws) for name, part in _named_tables(top, "tubes").items()}
    rods = {name: _rod_from_dict(*part) for name, part in _named_tables(top, "rods").items()}
    segments = [_segment_from_dict(*part, tubes, rods) for part in top.mappings("segments")]
    if not segments:
        raise top.error("a limb needs at least one table `[[segments]]`: none")
    return _checked(lambda: Limb(segments), top)


def read_limb(path: str | Path) -> Limb:
    """Read a limb from a TOML file.

    Raises
    ------
    FileNotFoundError, ValueError
        As `limb_from_dict`; the message starts with the file's name.
    """
    try:
        return limb_from_dict(read_document(path))
    except ValueError as error:
        raise ValueError(error if str(path) in str(error) else f"{path}: {error}") from None


def write_limb(limb: Limb, path: str | Path) -> None:
    """Write a limb to a TOML file from which `read_limb` makes an equal limb."""
    write_document(limb_to_dict(limb), path)


def _named_tables(top: Table, name: str) -> dict[str, tuple[Mapping[str, Any], str]]:
    tables = top.mapping(name)
    for key, content in tables.items():
        if not isinstance(content, dict):
            raise top.error(f"`{name}.{key}` must be a table, got {content!r},")
    return {key: (content, f"{top.path(name)}.{key}") for key, content in tables.items()}


def _checked(build: Callable[[], Thing], table: Table) -> Thing:
    """Build a thing; its own complaint gets the place in the file."""
    try:
        return build()
    except (ValueError, TypeError) as error:
        raise ValueError(f"{error} (in [{table.where}])" if table.where else str(error)) from None


def _law_classes() -> dict[str, Any]:
    from softlimb import _core

    classes = [getattr(_core, name) for name in _core.law_class_names()]
    return {law.name: law for law in classes}


def _coefficient_names(law: type) -> list[str]:
    """Names of a law's coefficients: what its class can be asked for, besides what every law has."""
    shared = ("name", "density", "max_strain", "shear_modulus", "parameters")
    return [name for name, member in vars(law).items() if isinstance(member, property) and name not in shared]


def _law_to_dict(law: Law) -> dict[str, Any]:
    table: dict[str, Any] = {"law": law.name}
    for name, value in law.parameters.items():
        number: Any = list(value) if isinstance(value, (tuple, list, np.ndarray)) else float(value)
        table |= {name: number} if name in _PLAIN_COEFFICIENTS else _entry(name, number, PRESSURE, "MPa", "kPa", "Pa")
    table |= _entry("density", law.density, DENSITY)
    return table | ({"max_strain": law.max_strain} if law.max_strain else {})


def _law_from_dict(content: Mapping[str, Any], where: str) -> Law:
    classes = _law_classes()
    name = content.get("law")
    if not isinstance(name, str) or name not in classes:
        known = ", ".join(f"{law!r}" for law in classes)
        found = "is missing" if name is None else f"must be one of {known}, got {name!r},"
        raise ValueError(f"`law` {found} in [{where}]")
    coefficients = _coefficient_names(classes[name])
    quantities = {key: PRESSURE for key in coefficients if key not in _PLAIN_COEFFICIENTS} | {"density": DENSITY}
    plain = [key for key in coefficients if key in _PLAIN_COEFFICIENTS]
    table = Table(content, where, quantities=quantities, others=("law", "max_strain", "source", *plain))
    table.text("source", "")
    values: dict[str, Any] = {}
    for key in coefficients:
        if key in table:
            # Ogden's law alone is a sum of any number of terms.
            values[key] = table.nested(key) if "alpha" in coefficients else _coefficient(table, key)
    if "density" in table:
        values["density"] = table.quantity("density")
    if "max_strain" in table:
        values["max_strain"] = table.number("max_strain")
    try:
        law: Law = classes[name](**values)
        return law
    except TypeError:
        given = ", ".join(f"`{table.key(key)}`" for key in coefficients if key in table) or "none"
        raise table.error(f"law {name!r} takes the coefficients {', '.join(coefficients)}; given: {given}") from None
    except ValueError as error:
        raise table.error(f"{error}") from None


def _coefficient(table: Table, key: str) -> float:
    return table.quantity(key) if key in table.quantities else table.number(key)


def _law_named(name: str, laws: Mapping[str, Law], table: Table) -> Law:
    from softlimb import materials

    if name in laws:
        return laws[name]
    try:
        return materials.get(name)
    except (KeyError, ValueError) as error:
        raise table.error(f"material {name!r} is neither defined in the file nor in the package: {error}") from None


def _fibres_to_dict(fibres: Fibres) -> dict[str, Any]:
    table = _entry("angle", fibres.angle, ANGLE)
    # A family given by its stiffness leaves the silicone whole: that is how the two ways are told apart.
    if fibres.modulus is None and fibres.fraction == 0.0:
        return table | _entry("stiffness", fibres.stiffness, PRESSURE, "GPa", "MPa", "Pa")
    modulus = _entry("modulus", fibres.modulus or 0.0, PRESSURE, "GPa", "MPa", "Pa")
    return table | modulus | {"fraction": fibres.fraction}


def _fibres_from_dict(content: Mapping[str, Any], where: str) -> Fibres:
    from softlimb.tube import Fibres

    quantities = {"angle": ANGLE, "modulus": PRESSURE, "stiffness": PRESSURE}
    table = Table(content, where, quantities=quantities, others=("fraction",))
    options: dict[str, Any] = {"angle": table.quantity("angle")}
    if "stiffness" in table:
        options["stiffness"] = table.quantity("stiffness")
        if "modulus" in table or "fraction" in table:
            raise table.error("a fibre family takes either `stiffness` or `modulus` and `fraction`, got both")
    else:
        options |= {"modulus": table.quantity("modulus"), "fraction": table.number("fraction")}
    return _checked(lambda: Fibres(**options), table)


def _layer_to_dict(layer: Layer, materials: _Namer) -> dict[str, Any]:
    table: dict[str, Any] = _entry("inner_radius", layer.inner, LENGTH)
    table |= _entry("outer_radius", layer.outer, LENGTH)
    table["material"] = materials.name_of(layer.law, lambda: _law_to_dict(layer.law))
    fibres = [_fibres_to_dict(family) for family in layer.fibres]
    return table | ({"fibres": fibres} if fibres else {})


def _layer_from_dict(content: Mapping[str, Any], where: str, laws: Mapping[str, Law]) -> Layer:
    from softlimb.tube import Layer

    quantities = {"inner_radius": LENGTH, "outer_radius": LENGTH}
    table = Table(content, where, quantities=quantities, others=("material", "fibres"))
    inner, outer = table.quantity("inner_radius"), table.quantity("outer_radius")
    law = _law_named(table.text("material"), laws, table)
    fibres = [_fibres_from_dict(*part) for part in table.mappings("fibres")]
    return _checked(lambda: Layer(inner, outer, law, fibres=fibres), table)


def _tube_to_dict(tube: Tube, materials: _Namer) -> dict[str, Any]:
    table: dict[str, Any] = _entry("length", tube.length, LENGTH)
    if tube._given_mass is not None:  # without it the mass follows from the densities, in the file as well
        table |= _entry("mass", tube._given_mass, MASS)
    if tube.cap_length:
        table |= _entry("cap_length", tube.cap_length, LENGTH)
    table |= {"tension_only": tube.tension_only, "ends": tube.ends}
    return table | {"layers": [_layer_to_dict(layer, materials) for layer in tube.layers]}


_TUBE_QUANTITIES = {"length": LENGTH, "mass": MASS, "cap_length": LENGTH}
_WOUND_QUANTITIES = {
    "radii": LENGTH,
    "thread_diameter": LENGTH,
    "pitch": LENGTH,
    "angle": ANGLE,
    "modulus": PRESSURE,
}


def _tube_from_dict(content: Mapping[str, Any], where: str, laws: Mapping[str, Law]) -> Tube:
    from softlimb.tube import Tube

    others = ("tension_only", "ends", "layers", "core", "skin", "thread")
    table = Table(content, where, quantities=_TUBE_QUANTITIES | _WOUND_QUANTITIES, others=others)
    options: dict[str, Any] = {name: table.quantity(name) for name in ("mass", "cap_length") if name in table}
    options["tension_only"] = table.boolean("tension_only", False)
    options["ends"] = table.text("ends", "free", choices=("free", "bonded"))
    wound = [table.key(name) for name in (*_WOUND_QUANTITIES, "core", "skin", "thread") if name in table]
    if not wound:
        layers = [_layer_from_dict(*part, laws) for part in table.mappings("layers")]
        length = table.quantity("length")
        return _checked(lambda: Tube(length, layers, **options), table)
    if "layers" in table:
        raise table.error(f"a tube is given by `layers` or by its winding (`{wound[0]}`): got both")
    options |= {name: table.quantity(name) for name in ("thread_diameter", "pitch")}
    options |= {name: table.quantity(name) for name in ("angle", "modulus") if name in table}
    options |= {name: _law_named(table.text(name), laws, table) for name in ("core", "skin")}
    options["thread"] = table.text("thread", "smeared", choices=("smeared", "layer"))
    length, radii = table.quantity("length"), table.array("radii", (3,)).tolist()
    return _checked(lambda: Tube.fibre_reinforced(length, radii=radii, **options), table)


def _section_to_dict(section: Section) -> dict[str, Any]:
    table: dict[str, Any] = {}
    for name, dimension in _SECTION_QUANTITIES.items():
        value = getattr(section, name)
        if name in _STIFFNESSES or value != 0.0:
            table |= _entry(name, value, dimension, dimension.si)
    if section.stretch != 1.0:
        table["stretch"] = section.stretch
    if section.largest_stretch != 0.0:
        table["largest_stretch"] = section.largest_stretch
    if section.nonlinear:
        degree, centre, half_range, coefficients = section.__getstate__()[_AXIAL_LAW]
        table["axial_law"] = _entry("centre", centre, FORCE) | _entry("half_range", half_range, FORCE)
        table["axial_law"] |= _entry("coefficients", list(coefficients)[: degree + 1], COMPLIANCE)
    return table


def _section_from_dict(content: Mapping[str, Any], where: str) -> Section:
    from softlimb import Section

    others = ("stretch", "largest_stretch", "axial_law")
    table = Table(content, where, quantities=_SECTION_QUANTITIES, others=others)
    values = {name: table.quantity(name, None if name in _STIFFNESSES else 0.0) for name in _SECTION_QUANTITIES}
    section: Section = _checked(lambda: Section(**values), table)
    if not any(name in table for name in others):
        return section
    # What a tube knows of its section besides the stiffnesses has no constructor, only the state that pickles it.
    state = list(section.__getstate__())
    state[_STRETCHES] = [table.number("stretch", 1.0), table.number("largest_stretch", 0.0)]
    if "axial_law" in table:
        state[_AXIAL_LAW] = _axial_law_state(table, len(state[_AXIAL_LAW][-1]))
    full: Section = Section.__new__(Section)
    full.__setstate__(tuple(state))
    return full


def _axial_law_state(table: Table, most: int) -> list[Any]:
    quantities = {"centre": FORCE, "half_range": FORCE, "coefficients": COMPLIANCE}
    law = Table(table.mapping("axial_law"), table.path("axial_law"), quantities=quantities)
    centre, half_range = law.quantity("centre"), law.quantity("half_range")
    coefficients = law.array("coefficients", (-1,)).tolist()
    if half_range <= 0.0:
        raise law.error(f"`half_range` must be positive, got {half_range},")
    if not 2 <= len(coefficients) <= most:
        raise law.error(f"`coefficients` must be 2 to {most} numbers, got {len(coefficients)},")
    return [len(coefficients) - 1, centre, half_range, [*coefficients, *[0.0] * (most - len(coefficients))]]


def _rod_to_dict(rod: Rod) -> dict[str, Any]:
    radius = {} if rod.radius is None else _entry("radius", rod.radius, LENGTH)
    return _entry("length", rod.length, LENGTH) | radius | {"section": _section_to_dict(rod.section)}


def _rod_from_dict(content: Mapping[str, Any], where: str) -> Rod:
    from softlimb.limb import Rod

    table = Table(content, where, quantities={"length": LENGTH, "radius": LENGTH}, others=("section",))
    section = _section_from_dict(table.mapping("section"), table.path("section"))
    length, radius = table.quantity("length"), table.quantity("radius") if "radius" in table else None
    return _checked(lambda: Rod(section, length, radius), table)


def pose_to_dict(pose: NDArray[np.float64]) -> dict[str, Any]:
    """A 4x4 pose as ``position_mm`` and, unless it is the identity, ``rotation`` (3x3, row by row)."""
    table: dict[str, Any] = _entry("position", pose[:3, 3], LENGTH)
    return table if np.array_equal(pose[:3, :3], np.eye(3)) else table | {"rotation": pose[:3, :3].tolist()}


def pose_from_dict(content: Mapping[str, Any], where: str) -> NDArray[np.float64]:
    """The 4x4 pose of `pose_to_dict`.

    Raises
    ------
    ValueError
        The rotation is not one.
    """
    table = Table(content, where, quantities={"position": LENGTH}, others=("rotation",))
    pose = np.eye(4)
    pose[:3, 3] = table.array("position", (3,))
    if "rotation" in table:
        rotation = table.array("rotation", (3, 3))
        if not is_rotation(rotation):
            raise table.error("`rotation` must be orthogonal with determinant 1; it is not")
        pose[:3, :3] = rotation
    return pose


def _plate_to_dict(plate: Plate) -> dict[str, Any]:
    return _entry("thickness", plate.thickness, LENGTH) | _entry("mass", plate.mass, MASS)


def _plate_from_dict(content: Mapping[str, Any], where: str) -> Plate:
    from softlimb.limb import Plate

    table = Table(content, where, quantities={"thickness": LENGTH, "mass": MASS})
    values = {name: table.quantity(name) for name in ("thickness", "mass") if name in table}
    return _checked(lambda: Plate(**values), table)


def _segment_to_dict(segment: Segment, materials: _Namer, tubes: _Namer, rods: _Namer) -> dict[str, Any]:
    table: dict[str, Any] = {}
    if segment.actuators:
        table["actuators"] = [tubes.name_of(t, partial(_tube_to_dict, t, materials)) for t in segment.actuators]
    else:
        table["rods"] = [rods.name_of(rod, partial(_rod_to_dict, rod)) for rod in segment.rods]
    if segment.ring_radius is not None:
        table |= _entry("ring_radius", segment.ring_radius, LENGTH)
    else:
        table["base_frames"] = [pose_to_dict(frame) for frame in segment.base_frames]
        table["end_frames"] = [pose_to_dict(frame) for frame in segment.end_frames]
    return table | {"plate": _plate_to_dict(segment.plate)}


def _segment_from_dict(
    content: Mapping[str, Any], where: str, tubes: Mapping[str, Tube], rods: Mapping[str, Rod]
) -> Segment:
    from softlimb.limb import Segment

    others = ("actuators", "rods", "plate", "base_frames", "end_frames")
    table = Table(content, where, quantities={"ring_radius": LENGTH}, others=others)
    options: dict[str, Any] = {}
    if ("actuators" in table) == ("rods" in table):
        raise table.error("a segment lists either `actuators` (names of tubes) or `rods`: give one of the two")
    if "actuators" in table:
        options["actuators"] = _referred(table, "actuators", "tubes", tubes)
    else:
        options["rods"] = _referred(table, "rods", "rods", rods)
    if ("ring_radius" in table) == ("base_frames" in table or "end_frames" in table):
        raise table.error("a segment is placed either by `ring_radius_mm` or by `base_frames` and `end_frames`: not so")
    if "ring_radius" in table:
        options["ring_radius"] = table.quantity("ring_radius")
    else:
        for name in ("base_frames", "end_frames"):
            options[name] = np.array([pose_from_dict(*part) for part in table.mappings(name)]).reshape(-1, 4, 4)
    if "plate" in table:
        options["plate"] = _plate_from_dict(table.mapping("plate"), table.path("plate"))
    return _checked(lambda: Segment(**options), table)


def _referred(table: Table, key: str, kind: str, known: Mapping[str, Any]) -> list[Any]:
    names = table.texts(key)
    for name in names:
        if name not in known:
            defined: Sequence[str] = [f"{entry!r}" for entry in known]
            listed = f"defined are {', '.join(defined)}" if defined else "none is defined"
            raise table.error(f"`{key}` refers to {name!r}, but there is no table [{kind}.{name}] ({listed})")
    return [known[name] for name in names]
