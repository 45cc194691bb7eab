"""Mutated scene files, tables and arguments: each either works or is refused by name, and nothing else happens.

    python tests/fuzz/fuzz_files.py --seconds 60 --seed 1

A case is a file of a kind that the package reads, or a set of arguments, damaged at random. Allowed are success, and
``ValueError``, ``TypeError`` or ``OSError`` with a message that names the file or the argument. Everything else is a
finding: another exception, a warning, a message that lists C++ signatures, a NaN under success, a success that its
independent check refuses, a case longer than 20 s, a crash (the last case stands in the folder that is printed).
Exit code 0 only without findings. The same seed makes the same cases.
"""

from __future__ import annotations

import argparse
import contextlib
import faulthandler
import io
import random
import re
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np

import softlimb as sl
from softlimb import presets
from softlimb.cli import main as command
from softlimb.materials import fit_csv
from softlimb.measured import read_measured
from softlimb.scenes import available_scenes, load_scene
from softlimb.units import mm

ALLOWED = (ValueError, TypeError, OSError)
LONGEST = 20.0  # [s] a case; the solver's budget of evaluations ends any solve long before
NUMBERS = [
    "nan", "inf", "-inf", "1e308", "-1e308", "1e-308", "-1", "0", "-0.0", "1", "3", "1e9", "1e-9", "1e30", "90", "0.5",
    "123456789012345678901234567890", "9" * 400, "0x10", "1_000", "true",
]  # fmt: skip
VALUES = [
    '"text"', '""', "1979-05-27", "07:32:00", "1979-05-27T07:32:00Z", "{}", "{ a = 1 }", "[]", "[[]]", "[[1], [2, 3]]",
    "[1, \"a\"]", "false", "'''\n'''", '"\\u0000"', "[nan, 0, 0]", "[[0, 0, 9.81]]", '["x", "x"]',
]  # fmt: skip


class Finding(Exception):
    """A rule that was broken without an exception."""


class TookTooLong(BaseException):
    """Raised by the alarm; no `except Exception` swallows it."""


# --- damage ------------------------------------------------------------------------------------------------------


def _numbers(text: str) -> list[re.Match[str]]:
    return list(re.finditer(r"(?<![\w.])-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?", text))


def _replaced(text: str, match: re.Match[str], new: str) -> str:
    return text[: match.start()] + new + text[match.end() :]


def other_number(rng: random.Random, text: str) -> str:
    found = _numbers(text)
    return _replaced(text, rng.choice(found), rng.choice(NUMBERS)) if found else text


def scaled_number(rng: random.Random, text: str) -> str:
    """A number that stays of its kind: these are the files that get as far as a solve."""
    found = _numbers(text)
    if not found:
        return text
    match = rng.choice(found)
    return _replaced(text, match, f"{float(match[0]) * rng.choice([-1.0, 0.1, 0.5, 0.9, 1.1, 2.0, 10.0, 1e3]):.6g}")


def other_value(rng: random.Random, text: str) -> str:
    found = list(re.finditer(r"(?m)(?<== ).+$", text))
    return _replaced(text, rng.choice(found), rng.choice([*VALUES, *NUMBERS])) if found else text


def other_key(rng: random.Random, text: str) -> str:
    found = list(re.finditer(r"(?m)[A-Za-z_0-9]{3,}(?= =)|(?<=\[)[\w.-]{3,}(?=\])", text))
    if not found:
        return text
    match = rng.choice(found)
    key = match[0]
    i = rng.randrange(len(key) - 1)
    swapped = key[:i] + key[i + 1] + key[i] + key[i + 2 :]
    units = ["mm", "kPa", "MPa", "N", "Nm", "deg", "psi", "g", "m_s2", "banana", ""]
    other_unit = key.rpartition("_")[0] + "_" + rng.choice(units)
    return _replaced(text, match, rng.choice([swapped, key[:-1], other_unit, "a.b"]))


def lines_moved(rng: random.Random, text: str) -> str:
    lines = text.splitlines(keepends=True)
    if not lines:
        return text
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    kind = rng.randrange(4)
    if kind == 0:
        del lines[i]
    elif kind == 1:
        lines.insert(j, lines[i])
    elif kind == 2:
        lines[i], lines[j] = lines[j], lines[i]
    else:
        lines = lines[:i]
    return "".join(lines)


def nested(rng: random.Random, text: str) -> str:
    depth = rng.choice([3, 9, 60, 3000])
    found = _numbers(text)
    deep = "[" * depth + "1" + "]" * depth
    if found and rng.random() < 0.7:
        return _replaced(text, rng.choice(found), deep)
    return text + "\n[" + ".".join(["a"] * depth) + "]\n" + "x = {" + "a = {" * depth + "}" * (depth + 1)


def damaged_bytes(rng: random.Random, data: bytes) -> bytes:
    kind = rng.randrange(8)
    if kind == 0:
        return b"\xef\xbb\xbf" + data
    if kind == 1:
        return data.replace(b"\n", rng.choice([b"\r\n", b"\r", b"\n\n"]))
    if kind == 2:
        return data.decode("utf-8", "replace").encode(rng.choice(["utf-16", "latin-1", "utf-8"]), "replace")
    if kind == 3:
        return b""
    changed = bytearray(data)
    for _ in range(rng.choice([1, 1, 2, 5])):
        if not changed:
            break
        i = rng.randrange(len(changed))
        if kind == 4:
            changed[i] ^= 1 << rng.randrange(8)
        elif kind == 5:
            changed[i:i] = rng.choice([b"\x00", b"\xff\xfe", b'"', b"[", b"]", b"=", b",", b";", b"\t", b"\n", b"#"])
        elif kind == 6:
            del changed[i : i + rng.choice([1, 3, 30])]
        else:
            changed[i] = rng.randrange(256)
    return bytes(changed)


TEXT_DAMAGE: list[Callable[[random.Random, str], str]] = [
    other_number, scaled_number, scaled_number, other_value, other_key, lines_moved, nested,
]  # fmt: skip


def damaged(rng: random.Random, text: str) -> bytes:
    for _ in range(rng.choice([1, 1, 1, 2, 4])):
        text = rng.choice(TEXT_DAMAGE)(rng, text)
    data = text.encode("utf-8", "surrogatepass")
    return damaged_bytes(rng, data) if rng.random() < 0.2 else data


# --- what is damaged ---------------------------------------------------------------------------------------------

RODS = """
[limb.rods.odd]
length_mm = 200
radius_mm = 8
section = { axial_N = 400, shear_N = 130, bending_Nm2 = 0.08, torsion_Nm2 = 0.06, mass_per_length_kg_m = 0.4, \
rest_twist_rad_m = 1, extension_twist_per_Nm = 0.05, stretch = 1.1, largest_stretch = 1.5, \
axial_law = { centre_N = 1, half_range_N = 30, coefficients_per_N = [0.0025, 2e-4, -1e-4] } }

[[limb.segments]]
rods = ["odd", "odd", "odd"]
base_frames = [{ position_mm = [20, 0, 0] }, { position_mm = [-10, 17, 0] }, { position_mm = [-10, -17, 0] }]
end_frames = [{ position_mm = [20, 0, 0] }, { position_mm = [-10, 17, 0] }, { position_mm = [-10, -17, 0], \
rotation = [[1, 0, 0], [0, 1, 0], [0, 0, 1]] }]
plate = { thickness_mm = 20, mass_g = 100 }

[scene]
rest_lengths_mm = [[200, 210, 190]]
gravity_m_s2 = [0, 0, 9.81]
tolerance = 1e-6
prefer_stable = true

[[scene.rod_loads]]
segment = 1
rod = 2
force_per_length_N_m = [0, 2, 0]
moment_per_length_Nm_m = [0, 0, 0.01]

[scene.held_tip]
position_mm = [10, 0, 200]
rotation = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
freedoms = ["x", "rotation_z"]
"""

WOUND = """
[limb.materials.skin]
law = "ogden"
mu_MPa = [0.63, 0.0012, -0.01]
alpha = [1.3, 5.0, -2.0]
density_kg_m3 = 1080
max_strain = 0.5

[limb.materials.core]
law = "gent"
mu_MPa = 0.16
jm = 30

[limb.tubes.wound]
length_mm = 200
radii_mm = [9, 10.25, 10.75]
core = "core"
skin = "skin"
thread_diameter_mm = 0.18
pitch_mm = 3
thread = "smeared"
tension_only = false
ends = "free"
cap_length_mm = 1

[limb.tubes.layered]
length_mm = 200
mass_g = 30
layers = [{ inner_radius_mm = 9, outer_radius_mm = 10.75, material = "dragon-skin-30", \
fibres = [{ angle_deg = 2.67, modulus_GPa = 31.067, fraction = 0.0166 }, { angle_deg = -2.67, stiffness_MPa = 500 }] }]

[[limb.segments]]
actuators = ["wound", "wound", "layered"]
ring_radius_mm = 14
plate = { thickness_mm = 25, mass_g = 140 }

[scene]
title = "Pushed aside"
pressures_kPa = [[50, 20, 30]]
tip_force_N = [0.3, 0, 0]
tip_moment_Nm = [0, 0, 0.01]
frame = "plate"
section = "nonlinear"
valve = "locked"

[[scene.plate_loads]]
plate = 1
force_N = [0, 0.3, 0]
moment_Nm = [0, 0, 0]

[[scene.sweep]]
actuators = [[1, 1], [1, 2]]
from_kPa = 0
to_kPa = 30
points = 3

[[scene.sweep]]
segment = 1
values_kPa = [1, 2]
"""

TENSILE = {
    "plain.csv": "stretch,nominal_stress_MPa\n"
    + "\n".join(f"{1 + 0.05 * i:.4g},{0.02 * i + 0.001 * i * i:.4g}" for i in range(12)),
    "percent.csv": "# a pull\nstrain_%;stress_kPa;note\n"
    + "\n".join(f"{5 * i};{20 * i + i * i};x" for i in range(12)),
    "database.csv": "Material;Dragon Skin 30\nStandard;ISO 37\n\nTime (s);Engineering Strain;Engineering Stress (MPa);"
    "True Strain;True Stress (MPa)\n"
    + "\n".join(f"{i};{0.05 * i:.4g};{0.02 * i:.4g};{0.049 * i:.4g};{0.021 * i:.4g}" for i in range(12)),
}
MEASURED = {
    "elongation.csv": "# by eye\npressure_kPa,elongation_mm\n0,0\n20,9.8\n40,22\n55,31\n",
    "bending.csv": "pressure_psi;bending_deg\n0;0\n3;10\n6;22\n",
    "centreline.csv": "x_mm\ty_mm\tz_mm\n0\t0\t0\n1\t2\t100\n3\t5\t220\n",
    "tips.csv": "pressure_1_1_kPa,pressure_1_2_kPa,pressure_1_3_kPa,tip_x_mm,tip_y_mm,tip_z_mm\n"
    "0,0,0,0,0,200\n30,20,10,5,-3,215\n",
}


def scene_files() -> dict[str, str]:
    """The package's own scenes, the same with the limb written out, and two that use every other key."""
    texts = {"rods.toml": RODS, "wound.toml": WOUND}
    with tempfile.TemporaryDirectory() as folder:
        for name in available_scenes():
            scene = load_scene(name)
            path = Path(folder) / "scene.toml"
            scene.to_toml(path)
            texts[f"{name}-whole.toml"] = path.read_text(encoding="utf-8")
            packaged = Path(sl.__file__).parent / "scenes" / f"{name}.toml"
            texts[f"{name}.toml"] = packaged.read_text(encoding="utf-8")
    return texts


# --- what is done with it ----------------------------------------------------------------------------------------


def check_posture(posture: sl.Posture) -> None:
    if not posture.message:
        raise Finding("a posture without a message")
    if not np.isfinite(posture.plates).all() and posture.success:
        raise Finding("success with a pose that is not finite")
    if not posture.success:
        return
    found = posture.verify()
    if not found.success:
        raise Finding(f"success, but {found}")
    curve = posture.centreline(11)
    if not (np.isfinite(curve).all() and np.isfinite(posture.base_wrench).all()):
        raise Finding("success with a curve or wrench that is not finite")


def use_scene(rng: random.Random, path: Path) -> None:
    scene = load_scene(path)
    again = path.with_name("again.toml")
    scene.to_toml(again)
    if load_scene(again) != scene:
        raise Finding("a scene that is written and read back is another")
    started = time.monotonic()
    check_posture(scene.solve())
    if scene.sweep_axes and time.monotonic() - started < 1.0:  # the limit of time is for one solve
        rows = scene.sweep_pressures()
        batch = scene.limb.sweep(rows[:2], progress=False, **scene.solve_options())
        if not np.isfinite(batch.tip[batch.success]).all():
            raise Finding("a sweep's success is not finite")


def use_tensile(rng: random.Random, path: Path) -> None:
    law = rng.choice(["neo-hooke", "yeoh", "yeoh3", "mooney-rivlin", "ogden2", "gent"])
    fit = fit_csv(path, law, max_strain=rng.choice([None, None, 0.3, 0.5]))
    if fit.success and not all(np.isfinite(value) for value in fit.coefficients.values()):
        raise Finding("a successful fit with a coefficient that is not finite")
    repr(fit), fit.message


def use_measured(rng: random.Random, path: Path) -> None:
    read_measured(path)


def use_command(rng: random.Random, path: Path) -> None:
    """The same file through the command line, which swallows no more than it says."""
    shown, errors = io.StringIO(), io.StringIO()
    if path.suffix == ".toml":
        arguments = rng.choice([["posture", str(path)], ["posture", str(path), "--tolerance", "1e-4"]])
    elif path.name in TENSILE:
        arguments = ["fit", str(path), "--law", rng.choice(["yeoh", "neo-hooke", "gent"])]
    else:
        arguments = ["compare", "elongation-proximal", str(path)]
    with contextlib.redirect_stdout(shown), contextlib.redirect_stderr(errors):
        code = command(arguments)
    if code not in (0, 1, 2):
        raise Finding(f"exit code {code} of {arguments}")
    if code == 2 and len(errors.getvalue().strip().splitlines()) != 1:
        raise Finding(f"an error of the command is not one line: {errors.getvalue()!r}")
    if code == 2 and path.name not in errors.getvalue():
        raise Finding(f"an error of the command does not name the file: {errors.getvalue()!r}")


# --- arguments ---------------------------------------------------------------------------------------------------

ODD: list[Any] = [
    float("nan"), float("inf"), -float("inf"), 0.0, -0.0, -1.0, 1e308, -1e308, 1e-308, 5e-324, 1e30, 10**400, 2**70, -1,
    1, True, False, None, "1", "", "x", b"x", 1j, Decimal("1.5"), Decimal("NaN"), np.float32(0.5), np.bool_(True),
    np.datetime64("2020-01-01"), np.array(1.0), np.array([1.0]), np.zeros(3), np.zeros((0, 3)), np.full(3, np.nan),
    np.zeros((3, 3)), np.array(["a"]), np.array([None]), np.eye(4), [], [[]], [1.0, True, 0.0], [1.0, [2.0]], (1, 2, 3),
    {}, {"x": 1}, object(), int, lambda: 0, np.zeros(9), np.full(9, 1e6), [[0.0] * 3] * 3, np.ma.masked, ["a"] * 9,
]  # fmt: skip


@dataclass(frozen=True)
class Call:
    """A function with good arguments, of which some are exchanged for odd ones."""

    name: str
    function: Callable[..., Any]
    good: dict[str, Any] = field(default_factory=dict)
    check: Callable[[Any], None] = lambda _: None


def calls() -> list[Call]:
    limb = presets.reference_limb(["proximal"])
    tube = limb.segments[0].actuators[0]
    section = sl.Section(axial=400.0, shear=130.0, bending=0.08, torsion=0.06)
    rod = sl.Rod(section, 0.2)
    column = sl.Limb([sl.Segment(rods=[rod], ring_radius=0.0)])
    law = sl.Yeoh(c1=86e3, c2=13e3)
    stretch = np.linspace(1.0, 1.5, 12)
    vector = (0.0, 0.1, 0.0)
    pose = np.eye(4)
    pose[2, 3] = 0.2

    def finite_state(state: Any) -> None:
        good = np.atleast_1d(state.success)
        if not np.isfinite(np.atleast_1d(state.stretch)[good]).all():
            raise Finding("a state's success is not finite")
        repr(state), state.message, state.warnings

    return [
        Call(
            "Limb.solve",
            limb.solve,
            {
                "pressures": [30e3, 20e3, 0.0], "gravity": (0.0, 0.0, 9.81), "tip_force": vector, "tip_moment": vector,
                "plate_wrenches": np.zeros((1, 6)), "frame": "base", "rod_forces": np.zeros((3, 3)),
                "rod_moments": None, "tolerance": 1e-6, "prefer_stable": True, "section": "tangent", "valve": "open",
                "start": None,
            },
            check_posture,
        ),
        Call(
            "Limb.solve held",
            limb.solve,
            {"pressures": np.zeros(3), "tip_pose": pose, "tip_held": [True, False] * 3},
            check_posture,
        ),
        Call(
            "Limb.solve plates",
            limb.solve,
            {"rest_lengths": [0.21, 0.2, 0.2], "plate_poses": pose[None], "plate_held": np.ones((1, 6), dtype=bool)},
            check_posture,
        ),
        Call(
            "Limb.follow",
            column.follow,
            {
                "arguments": lambda force: {"tip_force": (0.0, 0.01, -force)}, "start": 0.0, "stop": 0.5,
                "tolerance": 1e-6, "largest_step": 0.1, "max_points": 20, "through_events": True,
            },
        ),
        Call(
            "Limb.payload",
            column.payload,
            {"direction": (1.0, 0.0, 0.0), "max_force": 0.2, "max_deflection": 0.01, "gravity": (0.0, 0.0, 9.81)},
        ),
        Call(
            "Limb.sweep",
            limb.sweep,
            {
                "pressures": np.zeros((2, 3)), "progress": False, "tip_force": vector, "threads": 2, "ordered": True,
                "executor": None,
            },
        ),
        Call(
            "Rod.cantilever",
            rod.cantilever,
            {
                "tip_force": vector, "tip_moment": vector, "distributed_force": vector, "distributed_moment": vector,
                "gravity": vector, "tolerance": 1e-6, "start": None, "prefer_stable": True,
            },
            lambda found: check_posture(found.posture),
        ),
        Call("Rod", sl.Rod, {"section": section, "length": 0.2, "radius": 0.01}),
        Call(
            "Section",
            sl.Section,
            {
                "axial": 400.0, "shear": 130.0, "bending": 0.08, "torsion": 0.06, "mass_per_length": 0.1,
                "rest_twist": 0.0, "extension_twist": 0.0,
            },
        ),
        Call("Plate", sl.Plate, {"thickness": 0.02, "mass": 0.1}),
        Call("Segment", sl.Segment, {"actuators": [tube] * 3, "ring_radius": 0.03, "plate": sl.Plate()}),
        Call("Segment frames", sl.Segment, {"rods": [rod], "base_frames": pose[None], "end_frames": pose[None]}),
        Call("Limb", sl.Limb, {"segments": limb.segments}),
        Call("Layer", sl.Layer, {"inner": 0.01, "outer": 0.012, "law": law, "fibres": []}),
        Call("Fibres", sl.Fibres, {"angle": 0.1, "modulus": 1e9, "fraction": 0.01}),
        Call("Fibres.pair", sl.Fibres.pair, {"angle": 0.1, "stiffness": 1e8}),
        Call(
            "Tube",
            sl.Tube,
            {
                "length": 0.2, "layers": tube.layers, "tension_only": False, "ends": "free", "mass": None,
                "cap_length": 0.0,
            },
            lambda made: finite_state(made.inflate(20e3)),
        ),
        Call(
            "Tube.fibre_reinforced",
            sl.Tube.fibre_reinforced,
            {
                "length": 0.2, "radii": (0.009, 0.01025, 0.01075), "core": law, "skin": law,
                "thread_diameter": 0.18 * mm, "pitch": 3 * mm, "thread": "smeared", "angle": None, "modulus": 31e9,
            },
            lambda made: finite_state(made.inflate(20e3)),
        ),
        Call("Tube.inflate", tube.inflate, {"pressure": 30e3, "axial_force": 1.0, "torque": 0.0}, finite_state),
        Call("Tube.inflate reduced", tube.inflate, {"pressure": 30e3, "model": "paper_reduced"}, finite_state),
        Call("Tube.pressure_for", tube.pressure_for, {"stretch": 1.1}),
        Call("Tube.other_pressures", tube.other_pressures, {"stretch": 1.1}),
        Call("Tube.section", tube.section, {"pressure": 30e3, "model": "nonlinear", "valve": "open"}),
        Call("TubeState.stress", tube.inflate(30e3).stress, {"reference_radius": 0.02}),
        *[
            Call(kind.__name__, kind, good)
            for kind, good in (
                (sl.NeoHookean, {"c1": 1e5}),
                (sl.Yeoh, {"c1": 1e5, "c2": 1e3, "c3": 0.0, "density": 1e3, "max_strain": 0.5}),
                (sl.MooneyRivlin, {"c10": 1e5, "c01": 1e4}),
                (sl.Ogden, {"mu": [6e5, 1e3], "alpha": [1.3, 5.0]}),
                (sl.Gent, {"mu": 1e5, "jm": 30.0}),
            )
        ],
        Call("uniaxial_stress", law.uniaxial_stress, {"stretch": stretch}),
        Call("check_drucker", law.check_drucker, {"max_strain": 0.5}),
        Call(
            "fit_uniaxial",
            sl.fit_uniaxial,
            {"stretch": stretch, "nominal_stress": law.uniaxial_stress(stretch), "law": "yeoh", "max_strain": 0.5},
        ),
        Call("materials.get", sl.materials.get, {"name": "dragon-skin-30"}),
        Call("Posture.centreline", limb.solve([0.0] * 3).centreline, {"n": 5}),
    ]


def odd_like(rng: random.Random, good: Any) -> Any:
    """An odd value, or a good one in which a single number is odd."""
    if isinstance(good, tuple | list | np.ndarray) and len(good) and rng.random() < 0.5:
        changed = np.array(good, dtype=object)
        if all(isinstance(entry, float | int) for entry in changed.ravel().tolist()):
            changed.ravel()[rng.randrange(changed.size)] = rng.choice([v for v in ODD if not hasattr(v, "__len__")])
            return changed.tolist()
    if isinstance(good, float) and rng.random() < 0.3:
        return good * rng.choice([-1.0, 1e-12, 1e-3, 0.5, 2.0, 30.0, 1e3, 1e12])
    return rng.choice(ODD)


def use_arguments(rng: random.Random, call: Call) -> dict[str, Any]:
    arguments = dict(call.good)
    for name in rng.sample(sorted(arguments), rng.choice([1, 1, 1, 2]) if len(arguments) > 1 else 1):
        arguments[name] = odd_like(rng, call.good[name])
    return arguments


# --- the run -----------------------------------------------------------------------------------------------------


@dataclass
class Tally:
    cases: Counter[str] = field(default_factory=Counter)
    outcomes: Counter[str] = field(default_factory=Counter)
    findings: list[str] = field(default_factory=list)
    slowest: tuple[float, str] = (0.0, "")


def _alarm(*_: object) -> None:
    raise TookTooLong


def _judge(
    kind: str, run: Callable[[], Any], names: tuple[str, ...], tally: Tally, describe: Callable[[], str]
) -> None:
    """Run one case; `names` are what a refusal may name."""
    started = time.monotonic()
    problem = ""
    faulthandler.dump_traceback_later(4 * LONGEST, exit=True)  # not even the alarm gets through
    signal.setitimer(signal.ITIMER_REAL, LONGEST)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            run()
        outcome = "works"
    except ALLOWED as error:
        outcome, text = "refused", str(error)
        if not text or "incompatible" in text or "Invoked with" in text:
            problem = f"a message for no user: {text[:200]!r}"
        elif not any(name and name in text for name in names):
            problem = f"a message that names neither file nor argument {names}: {text[:300]!r}"
        elif isinstance(error, np.linalg.LinAlgError):
            problem = f"{type(error).__name__}: {text}"
        if problem:
            problem += "\n" + "".join(traceback.format_tb(error.__traceback__)[-2:])
    except Finding as error:
        outcome, problem = "broken", str(error)
    except TookTooLong:
        outcome, problem = "slow", f"longer than {LONGEST} s\n{traceback.format_exc()}"
    except Exception:
        outcome, problem = "broken", traceback.format_exc()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        faulthandler.cancel_dump_traceback_later()
    took = time.monotonic() - started
    tally.cases[kind] += 1
    tally.outcomes[outcome] += 1
    if took > tally.slowest[0]:
        tally.slowest = (took, describe())
    if problem:
        tally.findings.append(f"[{kind}] {problem}\n{describe()}")


def fuzz(seconds: float, seed: int, folder: Path, most: int | None = None) -> Tally:
    """Cases until the time is up (or `most` of them), each from its own seed."""
    tally = Tally()
    scenes, functions = scene_files(), calls()
    previous = signal.signal(signal.SIGALRM, _alarm)
    end = time.monotonic() + seconds
    number = 0
    try:
        while time.monotonic() < end and (most is None or number < most):
            rng = random.Random(f"{seed}/{number}")
            number += 1
            kind = rng.choice(["scene", "scene", "scene", "tensile", "measured", "arguments", "arguments"])
            if kind == "arguments":
                call = rng.choice(functions)
                arguments = use_arguments(rng, call)

                def run(call: Call = call, arguments: dict[str, Any] = arguments) -> None:
                    call.check(call.function(**arguments))

                # A rule may join arguments ("give either ..."), or speak of an argument in words.
                words = (*arguments, *(word for name in arguments for word in name.split("_") if len(word) > 3))
                (folder / "last.txt").write_text(f"seed {seed}/{number - 1}: {call.name}", encoding="utf-8")
                _judge(
                    call.name, run, words, tally,
                    lambda call=call, arguments=arguments, number=number: (  # type: ignore[misc]
                        f"  seed {seed}/{number - 1}: {call.name}("
                        + ", ".join(f"{k}={v!r}"[:160] for k, v in arguments.items())
                        + ")"
                    ),
                )  # fmt: skip
                continue
            corpus, use = {
                "scene": (scenes, use_scene),
                "tensile": (TENSILE, use_tensile),
                "measured": (MEASURED, use_measured),
            }[kind]
            name = rng.choice(sorted(corpus))
            # A file that reads well may still ask for what a solve refuses, by the solve's own arguments.
            solving = ("pressures", "rest_lengths", "tolerance", "section", "valve") if kind == "scene" else ()
            data = damaged(rng, corpus[name])
            path = folder / name
            path.write_bytes(data)
            if rng.random() < 0.15:
                use, kind = use_command, f"{kind} by command"
            _judge(
                kind, lambda use=use, path=path, rng=rng: use(rng, path), (path.name, *solving), tally,  # type: ignore[misc]
                lambda name=name, data=data, number=number: f"  seed {seed}/{number - 1}: {name}\n{data[:3000]!r}",  # type: ignore[misc]
            )  # fmt: skip
    finally:
        signal.signal(signal.SIGALRM, previous)
    return tally


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    folder = Path(tempfile.mkdtemp(prefix="softlimb-fuzz-"))
    print(f"the last case stands in {folder}", flush=True)
    tally = fuzz(options.seconds, options.seed, folder)
    for finding in tally.findings:
        print(finding, end="\n\n")
    print(f"{sum(tally.cases.values())} cases: {dict(tally.outcomes)}")
    print(f"by kind: {dict(tally.cases.most_common())}")
    print(f"slowest: {tally.slowest[0]:.1f} s\n{tally.slowest[1][:2000]}")
    print(f"{len(tally.findings)} findings")
    return 1 if tally.findings else 0


if __name__ == "__main__":
    sys.exit(main())
