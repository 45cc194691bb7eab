from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import softlimb as sl
from tube_examples import DRAGON_SKIN, SMOOTHSIL, proximal, unequal

nan = float("nan")
core = sl.Layer(0.01, 0.012, DRAGON_SKIN)


def wound(**changes: Any) -> sl.Tube:
    given: dict[str, Any] = {"length": 0.2, "radii": (0.018, 0.0205, 0.0215), "core": DRAGON_SKIN, "skin": SMOOTHSIL,
                             "thread_diameter": 0.18e-3, "pitch": 3e-3}
    return sl.Tube.fibre_reinforced(**{**given, **changes})


BAD: list[tuple[Callable[[], Any], str]] = [
    (lambda: sl.Fibres(angle=88.67, stiffness=1e8), r"within \[-pi/2, pi/2\], got 88.67 \(was it given in degrees"),
    (lambda: sl.Fibres(angle=nan, stiffness=1e8), "fibre angle must be finite"),
    (lambda: sl.Fibres(angle=0.1, stiffness=-1.0), "fibre stiffness must be finite and not negative, got -1"),
    (lambda: sl.Fibres(angle=0.1), "either stiffness, or both modulus and fraction"),
    (lambda: sl.Fibres(angle=0.1, modulus=1e9), "both modulus and fraction"),
    (lambda: sl.Fibres(angle=0.1, stiffness=1e8, fraction=0.1), "not both"),
    (lambda: sl.Fibres(angle=0.1, modulus=1e9, fraction=1.2), r"fibre fraction must be within \[0, 1\], got 1.2"),
    (lambda: sl.Fibres(angle=0.1, modulus=0.0, fraction=0.2), "fibre modulus must be finite and positive"),
    (lambda: sl.Layer(0.012, 0.01, DRAGON_SKIN),
     "outer radius of a layer must be larger than its inner radius, got 0.01"),
    (lambda: sl.Layer(0.0, 0.01, DRAGON_SKIN), "inner radius of a layer must be finite and positive, got 0"),
    (lambda: sl.Layer(nan, 0.01, DRAGON_SKIN), "inner radius"),
    (lambda: sl.Layer(0.01, 0.012, DRAGON_SKIN, fibres=sl.Fibres.pair(angle=0.1, modulus=1e9, fraction=0.6)),
     "sum of the fibre fractions of a layer must be below 1, got 1.2"),
    (lambda: sl.Fibres(angle=None, stiffness=1e8), "^fibre angle must be a number or an array of numbers, got None"),
    (lambda: sl.Fibres(angle=0.1, stiffness="stiff"), "^fibre stiffness must be a number .* got 'stiff'"),
    (lambda: sl.Fibres(angle=0.1, modulus=1e9, fraction=True), "^fibre fraction must be a number .* got True"),
    (lambda: sl.Fibres.pair(angle=[0.1, 0.2], stiffness=1e8), r"^fibre angle must be one number, got shape \(2,\)"),
    (lambda: sl.Layer(None, 0.01, DRAGON_SKIN), "^inner radius of a layer must be a number .* got None"),
    (lambda: sl.Layer(0.01, 1j, DRAGON_SKIN), "^outer radius of a layer must be a number .* got 1j"),
    (lambda: sl.Layer(0.01, 10**400, DRAGON_SKIN), "^outer radius of a layer must be finite"),
    (lambda: sl.Layer(0.01, 0.012, "dragon-skin-30"), "^law of a layer must be a material law.* got 'dragon-skin-30'"),
    (lambda: sl.Layer(0.01, 0.012, None), "^law of a layer must be a material law.* got None"),
    (lambda: sl.Layer(0.01, 0.012, DRAGON_SKIN, fibres=None), "^fibres of a layer must be Fibres or .* got None"),
    (lambda: sl.Layer(0.01, 0.012, DRAGON_SKIN, fibres=[None]), r"^fibres of a layer must be Fibres or .* got \[None"),
    (lambda: sl.Layer(0.01, 0.012, DRAGON_SKIN, fibres=np.ma.masked), "^fibres of a layer must be Fibres or .* got"),
    (lambda: sl.Layer(0.01, 0.012, DRAGON_SKIN, fibres=0.1), "^fibres of a layer must be Fibres or .* got 0.1"),
    *[
        (lambda name=name: sl.Section(**({"axial": 1.0, "shear": 1.0, "bending": 1.0, "torsion": 1.0} | {name: None})),
         f"^{name} must be a number or an array of numbers, got None")
        for name in ("axial", "shear", "bending", "torsion", "mass_per_length", "rest_twist", "extension_twist")
    ],
    (lambda: sl.Tube(0.0, [core]), "length must be finite and positive, got 0"),
    (lambda: sl.Tube(-0.2, [core]), "length must be finite and positive, got -0.2"),
    (lambda: sl.Tube(nan, [core]), "length must be finite"),
    (lambda: sl.Tube(0.2, []), "at least one layer"),
    (lambda: sl.Tube(0.2, [core, sl.Layer(0.013, 0.014, DRAGON_SKIN)]), "layers must adjoin.*layer 1 begins at 0.013"),
    (lambda: sl.Tube(0.2, [core, sl.Layer(0.008, 0.01, DRAGON_SKIN)]), "layers must adjoin"),
    (lambda: sl.Tube(0.2, [core], mass=0.0), "mass must be finite and positive, got 0"),
    (lambda: sl.Tube(0.2, [core], mass=nan), "mass"),
    (lambda: sl.Tube(0.2, [core], ends="glued"), 'ends must be one of "free", "bonded", got "glued"'),
    (lambda: sl.Tube(0.2, [core], cap_length=0.1), "cap_length must be below half the length"),
    (lambda: sl.Tube(0.2, [core], cap_length=-0.1), "cap_length"),
    (lambda: wound(radii=(0.018, 0.0205)), "radii must be three numbers"),
    (lambda: wound(radii=(0.0205, 0.018, 0.0215)), "radii must be positive and ascending"),
    (lambda: wound(pitch=0.0), "pitch must be finite and positive"),
    (lambda: wound(pitch=1e-4), "thread_diameter must be at most the pitch"),
    (lambda: wound(thread_diameter=2e-3), "thread_diameter must be at most the thickness of the skin"),
    (lambda: wound(thread="wound"), 'thread must be "smeared" or "layer", got \'wound\''),
    (lambda: wound(angle=1.9), "was it given in degrees"),
    (lambda: proximal().inflate(nan), "pressure must be finite, got nan"),
    (lambda: proximal().inflate([1e3, np.inf]), "pressure must be finite, got inf at index 1"),
    (lambda: proximal().inflate("much"), "pressure must be a number"),
    (lambda: proximal().inflate([1e3, 2e3], [1.0, 2.0, 3.0]), "do not fit together"),
    (lambda: proximal().inflate(1e3, nan), "axial_force must be finite"),
    (lambda: proximal().inflate(1e3, model="thin"), 'model must be "thick" or "paper_reduced", got \'thin\''),
    (lambda: proximal().inflate(1e3, 1.0, model="paper_reduced"), "no axial force"),
    (lambda: unequal(ends="bonded").inflate(1e3, torque=1.0), "torque must be zero: bonded ends"),
    (lambda: proximal().pressure_for(-1.0), "stretch must be positive, got -1"),
    (lambda: proximal().pressure_for(nan), "stretch must be finite"),
    (lambda: proximal().inflate_volume(), "either volume or inner_radius"),
    (lambda: proximal().inflate_volume(0.0), "volume must be positive"),
    (lambda: proximal().section([1e3, 2e3]), "pressure must be one number"),  # type: ignore[arg-type]
    (lambda: proximal().section(1e3, model="secant"), 'section model must be one of "tangent"'),  # type: ignore[arg-type]
    (lambda: proximal().section(1e3, valve="shut"), 'valve must be one of "open", "locked"'),  # type: ignore[arg-type]
    (lambda: proximal().inflate(1e3).stress(0.03), "radius must be within the deformed wall"),
    (lambda: proximal().inflate([1e3, 2e3]).stress(), r"take state\[i\] first"),
    (lambda: proximal().inflate(1e3).flag("tired"), "flag name must be one of"),
]


@pytest.mark.parametrize("number", range(len(BAD)))
def test_bad_input_is_named(number: int) -> None:
    call, words = BAD[number]
    with pytest.raises(ValueError, match=words):
        call()


# What numpy would convert, and what belongs to no number at all.
NOT_REAL: list[Any] = [
    "55e3", b"1", True, np.True_, None, 1.0 + 0.0j, np.datetime64(1, "s"), np.timedelta64(1, "s"), {}, object(),
    ["55e3"], [1.0, True], np.array([1.0 + 1.0j]), np.array(["1"], dtype=object), np.array([True]),
    np.array([1], dtype="datetime64[s]"), [[1.0], [1.0, 2.0]], 10**400, [1.0, 10**400], 10**5000,
    np.longdouble("1e400"),
]  # fmt: skip
TAKES_NUMBERS: dict[str, Callable[[Any], Any]] = {
    "pressure of inflate": lambda x: proximal().inflate(x),
    "axial_force of inflate": lambda x: proximal().inflate(1e3, x),
    "torque of inflate": lambda x: proximal().inflate(1e3, torque=x),
    "volume": lambda x: proximal().inflate_volume(x),
    "inner_radius": lambda x: proximal().inflate_volume(inner_radius=x),
    "axial_force of inflate_volume": lambda x: proximal().inflate_volume(3e-4, axial_force=x),
    "torque of inflate_volume": lambda x: proximal().inflate_volume(3e-4, torque=x),
    "stretch of inflate_to": lambda x: proximal().inflate_to(x),
    "stretch of pressure_for": lambda x: proximal().pressure_for(x),
    "stretch of other_pressures": lambda x: proximal().other_pressures(x),
    "pressure of section": lambda x: proximal().section(x),
    "pressure of section_at": lambda x: proximal().section_at(x),
    "pressure of rest_length": lambda x: proximal().rest_length(x),
    "pressure of rod": lambda x: proximal().rod(x),
    "radius of stress": lambda x: proximal().inflate(1e3).stress(x),
    "reference_radius of stress": lambda x: proximal().inflate(1e3).stress(reference_radius=x),
    "length": lambda x: sl.Tube(x, [core]),
    "mass": lambda x: sl.Tube(0.2, [core], mass=x),
    "cap_length": lambda x: sl.Tube(0.2, [core], cap_length=x),
    "length of fibre_reinforced": lambda x: wound(length=x),
    "radii": lambda x: wound(radii=x),
    "thread_diameter": lambda x: wound(thread_diameter=x),
    "pitch": lambda x: wound(pitch=x),
    "angle": lambda x: wound(angle=x),
    "modulus": lambda x: wound(modulus=x),
}
NONE_IS_A_VALUE = {"mass", "angle", "volume", "inner_radius", "radius of stress", "reference_radius of stress"}


@pytest.mark.parametrize("name", TAKES_NUMBERS)
def test_what_is_no_real_number_is_refused_by_name(name: str) -> None:
    argument = name.split(maxsplit=1)[0].replace("_", "[_ ]")  # the core writes "reference radius", "fibre angle"
    for value in NOT_REAL:
        if value is None and name in NONE_IS_A_VALUE:
            continue
        with pytest.raises(ValueError, match=rf"^(fibre )?{argument} must be"):
            TAKES_NUMBERS[name](value)


def test_numbers_of_every_kind_are_taken() -> None:
    tube, expected = proximal(), proximal().inflate(55000.0)
    for value in (55000, np.int64(55000), np.float32(55000), np.array(55000.0), Fraction(55000), Decimal(55000)):
        assert tube.inflate(value).stretch == expected.stretch  # type: ignore[arg-type]
    for values in ([55000], (55000.0,), [Fraction(55000)], [np.float32(55000)], [np.array(55000)]):
        assert tube.inflate(values).stretch.tolist() == [expected.stretch]  # type: ignore[arg-type]
    assert tube.inflate([np.array([55000.0, 0.0]), np.array([0.0, 55000.0])]).shape == (2, 2)
    assert tube.inflate([]).shape == (0,)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: sl.Tube(0.2, [core], tension_only=nan), "tension_only must be True or False, got nan"),  # type: ignore[arg-type]
        (lambda: sl.Tube(0.2, [core], tension_only=None), "tension_only must be True or False, got None"),  # type: ignore[arg-type]
        (lambda: sl.Tube(0.2, [core], tension_only=1), "tension_only must be True or False, got 1"),  # type: ignore[arg-type]
        (lambda: sl.Tube(0.2, [core], ends=None), 'ends must be one of "free", "bonded", got None'),  # type: ignore[arg-type]
        (lambda: sl.Tube(0.2, None), "layers must be a sequence of Layer, got None"),  # type: ignore[arg-type]
        (lambda: sl.Tube(0.2, [core, 0.012]), r"layers\[1\] must be a Layer, got 0.012"),  # type: ignore[list-item]
        (lambda: wound(core=None), "core must be a material law, got None"),
        (lambda: wound(skin="smoothsil-950"), "skin must be a material law, got 'smoothsil-950'"),
        (lambda: wound(thread=None), 'thread must be "smeared" or "layer", got None'),
        (lambda: wound(tension_only="no"), "tension_only must be True or False, got 'no'"),
        (lambda: proximal().inflate(1e3, model=None), 'model must be "thick" or "paper_reduced", got None'),  # type: ignore[arg-type]
        (lambda: proximal().section(1e3, model=None), "section model must be one of .*, got None"),  # type: ignore[arg-type]
        (lambda: proximal().section(1e3, valve=1), "valve must be one of .*, got 1"),  # type: ignore[arg-type]
        (lambda: proximal().inflate(1e3).flag(["locking"]), "flag name must be one of"),  # type: ignore[arg-type]
        (lambda: proximal().inflate_volume(3e-4, axial_force=nan), "axial_force must be finite, got nan"),
    ],
)  # fmt: skip
def test_options_are_refused_by_name(call: Callable[[], Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        call()


def test_states_are_taken_by_an_integer() -> None:
    states = proximal().inflate([1e3, 2e3])
    assert states[np.int64(1)] == states[1] == states[-1]
    for index in ("0", 0.0, None, slice(0, 1)):
        with pytest.raises(TypeError, match="index of a state must be an integer"):
            states[index]  # type: ignore[index]


def test_a_tube_does_not_change() -> None:
    tube = proximal()
    with pytest.raises(AttributeError):
        tube.length = 0.3  # type: ignore[misc]
    with pytest.raises(AttributeError):
        core.inner = 0.02  # type: ignore[misc]


def test_layers_that_adjoin_to_rounding_are_accepted() -> None:
    sl.Tube(0.2, [sl.Layer(0.01, 0.1 + 0.2, DRAGON_SKIN), sl.Layer(0.3, 0.31, DRAGON_SKIN)])


def test_texts_are_useful() -> None:
    tube = proximal()
    assert "Tube(length=0.2" in repr(tube) and "Fibres(angle=0.0232" in repr(tube)
    assert "stretch=1.157" in repr(tube.inflate(55e3))
    assert "all succeeded" in repr(tube.inflate([1e3, 2e3]))
