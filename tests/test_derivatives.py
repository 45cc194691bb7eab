"""Derivatives of tubes and postures: against differences of tight solves, against each other, and their names."""

from __future__ import annotations

import pickle
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import perturbed
import softlimb as sl
from benchmarks import bench_derivatives
from frames import solved
from softlimb import _core, presets
from softlimb.derivatives import DESIGN, LOADS, columns
from softlimb.units import deg, kPa, mm
from tube_examples import plain, proximal, unequal

HANGING = (0.0, 0.0, 9.81)
PRESSURES = np.array([60, 20, 0, 40, 30, 10, 20, 50, 35]) * kPa
FIELDS = ("axial", "shear", "bending", "torsion", "mass_per_length", "rest_twist", "extension_twist", "stretch")


@pytest.fixture(scope="module")
def reference() -> sl.Limb:
    return presets.reference_limb()


@pytest.fixture(scope="module")
def posture(reference: sl.Limb) -> sl.Posture:
    return reference.solve(PRESSURES, gravity=HANGING, tip_force=(0.2, 0.0, 0.1), tolerance=1e-11)


def rods_limb() -> sl.Limb:
    section = sl.Section(
        axial=900.0, shear=300.0, bending=0.02, torsion=0.015, mass_per_length=0.2, rest_twist=0.4, extension_twist=0.02
    )
    plate = sl.Plate(thickness=12 * mm, mass=0.05)
    lengths = (0.2, 0.205, 0.195)
    return sl.Limb(
        [sl.Segment(rods=[sl.Rod(section, length) for length in lengths], ring_radius=20 * mm, plate=plate)] * 2
    )


# Tubes


FORCES = (-60.0, -5.0, 3.0, 10.0, 200.0)
"""Axial forces [N]; the outermost are beyond the range of a nonlinear law."""


def section_numbers(tube: sl.Tube, pressure: float, section: str, valve: str) -> np.ndarray:
    """Rest length, section, and strains of the axial law at a few forces."""
    at = tube.section_at(pressure, section, valve)  # type: ignore[arg-type]
    strains = [_core.axial_strain(at.section, force)[0] for force in FORCES]
    return np.array([at.rest_length, *(getattr(at.section, field) for field in FIELDS), *strains])


def odd_tube() -> sl.Tube:
    """Laws with exponents and a limit, fibres given both ways that make it twist, caps, a given mass."""
    ogden = sl.Ogden(mu=[1e5, -2e4], alpha=[2.5, -1.5])
    fibres = [sl.Fibres(angle=20 * deg, stiffness=2e6), sl.Fibres(angle=-35 * deg, modulus=1e9, fraction=0.003)]
    layers = [sl.Layer(8 * mm, 10 * mm, ogden, fibres=fibres), sl.Layer(10 * mm, 11 * mm, sl.Gent(mu=3e5, jm=20.0))]
    return sl.Tube(0.15, layers, mass=0.05, cap_length=5 * mm)


def slack_tube() -> sl.Tube:
    """Fibres of which a part is slack under pressure."""
    fibres = [sl.Fibres(angle=30 * deg, stiffness=3e6), sl.Fibres(angle=-50 * deg, stiffness=3e6)]
    law = sl.MooneyRivlin(c10=1e5, c01=5e4)
    layers = [sl.Layer(8 * mm, 10 * mm, law), sl.Layer(10 * mm, 11 * mm, law, fibres=fibres)]
    return sl.Tube(0.15, layers, tension_only=True, cap_length=4 * mm)


def uneven_tube() -> sl.Tube:
    """Fibres at one size of angle that differ in sign or stiffness, and one true pair, the negative one first."""
    fibres = [
        sl.Fibres(angle=20 * deg, stiffness=2e6),
        sl.Fibres(angle=-20 * deg, stiffness=5e6),
        sl.Fibres(angle=20 * deg, stiffness=2e6),
        sl.Fibres(angle=-40 * deg, modulus=1e9, fraction=0.002),
        sl.Fibres(angle=40 * deg, modulus=1e9, fraction=0.002),
    ]
    law = sl.NeoHookean(c1=1e5)
    layers = [sl.Layer(8 * mm, 10 * mm, law), sl.Layer(10 * mm, 11 * mm, law, fibres=fibres)]
    return sl.Tube(0.15, layers, cap_length=4 * mm)


def capped_tube() -> sl.Tube:
    return proximal(cap_length=5 * mm)


def twisting_tube() -> sl.Tube:
    return unequal(cap_length=5 * mm)


CASES = [
    (capped_tube, "tangent", "open"),
    (capped_tube, "paper", "open"),
    (twisting_tube, "nonlinear", "locked"),
    (odd_tube, "tangent", "locked"),
    (odd_tube, "nonlinear", "open"),
    (slack_tube, "tangent", "open"),
    (uneven_tube, "tangent", "open"),
]


@pytest.mark.parametrize(("make", "section", "valve"), CASES)
def test_the_section_of_a_tube_has_the_slopes_that_differences_have(make: Any, section: str, valve: str) -> None:
    tube, pressure = make(), 30 * kPa
    numbers = section_numbers(tube, pressure, section, valve)
    rod = tube.section_at(pressure, section, valve).section
    # Twist and coupling may be zero: measured by what a tube of this stiffness could have.
    size = np.maximum(np.abs(numbers), 1e-12)
    size[6:8] = np.maximum(size[6:8], [1.0, 1.0 / np.sqrt(numbers[1] * numbers[4])])
    limb = sl.Limb([sl.Segment([tube], ring_radius=0.0)])
    alone = limb.solve([pressure])
    names = ["length", "radii", "cap_length", "law", "density", "fibre_angle"]
    names += ["fibre_fraction", "fibre_modulus"] if any(f.modulus for _, f in families(tube)) else []
    names += ["fibre_stiffness"] if any(not f.modulus for _, f in families(tube)) else []
    names += ["mass"] if tube._given_mass is not None else []
    for name in names:
        made = columns(limb, name, "actuator")
        for label, parts in zip(made.labels.columns, made.parts, strict=True):
            what = label.partition("actuators[0].")[2]
            value = bench_derivatives.value_of(alone, label.replace("actuators[0].", ""))
            exact = np.zeros(len(numbers))
            for part in parts:
                kind = part.kind.removeprefix("tube ")
                slope = tube._section_slope(pressure, section, valve, kind, part.layer, part.number, part.twin)
                strains = [_core.axial_strain_slope(rod, slope[1], force) for force in FORCES]
                exact += part.factor * np.array([slope[0], *(getattr(slope[1], f) for f in FIELDS), *strains])
            quotients = []
            for k in range(5):
                # Slack parts grow by a corner's third derivative: small steps.
                h = 0.02 * value / 2.0**k
                ends = [
                    section_numbers(perturbed.changed_tube(tube, what, side), pressure, section, valve)
                    for side in (h, -h)
                ]
                quotients.append((ends[0] - ends[1]) / (2.0 * h) / size)
            expected = perturbed.extrapolated(quotients)
            # Sections to 1e-13 over a change of 2e-2 leave 1e-11; slack parts cost two digits. Beyond the law's range,
            # where a parabola goes on with the slopes of a polynomial of degree 12 at its end, two more.
            digits = np.ones(len(numbers))
            digits[[-len(FORCES), -1]] = 100.0
            allowed = 1e-9 * max(1.0 / value, np.abs(expected).max())
            assert_allclose(exact / size / digits, expected / digits, rtol=0.0, atol=allowed)


def families(tube: sl.Tube) -> list[tuple[int, Any]]:
    return [(n, family) for n, layer in enumerate(tube.layers) for family in layer.fibres]


# Postures


# Seeded: a sample of the benchmark's scenes, among them limbs of rods, following loads, held tips, nonlinear sections
# and tension-only tubes.
@pytest.mark.parametrize("number", [*range(0, 12), 37, 47, 98, 114])
def test_derivatives_are_slopes_of_tight_solves(number: int) -> None:
    outcomes = bench_derivatives.measure(number, 3)
    assert outcomes is not None, number
    for label, *errors in outcomes:
        # The bound asked for; the largest of 2000 columns in the benchmark is below it too.
        assert np.nanmax(errors) < 1e-7, (number, label, errors)


def test_forward_and_adjoint_are_one_matrix(posture: sl.Posture) -> None:
    to = ("pressures", *LOADS, *DESIGN)
    all_of = posture.derivative(("tip", "plates", "centreline", "energy"), ("pressures", "gravity", *DESIGN), n=7)
    made = posture.derivative("tip", to)
    assert made.matrix.shape == (6, len(made.columns)) and len(made.columns) > 12  # by the adjoint
    pieces = [posture.derivative("tip", name) for name in to]
    few = np.concatenate([piece.matrix for piece in pieces], axis=1)
    # The same numbers by other sums: rounding, grown by the stiffness's condition.
    scale = np.abs(few).max(axis=0)
    assert_allclose(made.matrix / scale, few / scale, rtol=0.0, atol=1e-10)
    rng = np.random.default_rng(6)
    weights = {"tip": rng.normal(size=6), "plates": rng.normal(size=(3, 6)), "centreline": rng.normal(size=(7, 3))}
    row = np.concatenate([weights["tip"], weights["plates"].ravel(), weights["centreline"].ravel(), [0.3]])
    gradient = posture.gradient(("pressures", "gravity", *DESIGN), **weights, energy=0.3)
    expected = row @ all_of.matrix
    assert_allclose(gradient.values, expected, rtol=0.0, atol=1e-10 * (np.abs(row) @ np.abs(all_of.matrix)).max())
    assert gradient.columns == all_of.columns


def test_the_jacobian_and_the_compliance_are_among_the_derivatives(posture: sl.Posture) -> None:
    by_pressures = posture.derivative("tip", "pressures").matrix
    assert_allclose(posture.jacobian, by_pressures, rtol=0.0, atol=1e-11 * np.abs(by_pressures).max())
    loads = posture.derivative("tip", ("tip_force", "tip_moment"))
    assert_allclose(loads.matrix, posture.compliance, rtol=0.0, atol=1e-11 * np.abs(posture.compliance).max())
    assert np.array_equal(posture.derivative("plates", "pressures").matrix[-6:].shape, (6, 9))


def test_groups_of_columns_are_sums(posture: sl.Posture) -> None:
    for name in ("length", "radii", "fibre_angle", "fibre_fraction", "law"):
        each = posture.derivative("tip", name, each="actuator")
        segments, limb = posture.derivative("tip", name), posture.derivative("tip", name, each="limb")
        for labels, coarse in ((each, segments), (segments, limb)):
            for k, label in enumerate(coarse.columns):
                end = label.split(".", 1)[1] if label.startswith("segments") else label
                start = label.split(".")[0] if label.startswith("segments") else ""
                of_it = [i for i, fine in enumerate(labels.columns) if fine.startswith(start) and fine.endswith(end)]
                total = labels.matrix[:, of_it].sum(axis=1)
                largest = np.abs(labels.matrix[:, of_it]).max()
                assert_allclose(coarse.matrix[:, k], total, rtol=0.0, atol=1e-10 * largest)


def test_labels_units_and_parts(posture: sl.Posture) -> None:
    found = posture.derivative(("tip", "energy"), ("pressures", "radii", "fibre_angle", "law", "plate_mass"))
    assert found.rows == ("tip.x", "tip.y", "tip.z", "tip.rx", "tip.ry", "tip.rz", "energy")
    assert found.row_units == ("m", "m", "m", "rad", "rad", "rad", "J")
    units = dict(zip(found.columns, found.column_units, strict=True))
    assert units["pressures[8]"] == "Pa" and units["segments[0].radii[2]"] == "m"
    assert units["segments[1].layers[1].fibre_angle"] == "rad" and units["segments[0].layers[0].c2"] == "Pa"
    assert found["radii"].shape == (7, 9) and found["segments[2].radii[0]"].shape == (7,)
    assert np.array_equal(found["radii"][:, 6], found["segments[2].radii[0]"])
    with pytest.raises(KeyError, match="no column of 'gravity'"):
        found["gravity"]
    gradient = posture.gradient("plate_mass", tip=[0, 0, 1, 0, 0, 0])
    assert gradient["segments[0].plate_mass"] == gradient["plate_mass"][0]
    assert repr(gradient).startswith("Gradient(segments[0].plate_mass=") and "columns" in repr(found)


def test_heavier_hanging_plates_pull_the_tip_down(reference: sl.Limb) -> None:
    straight = reference.solve(np.full(9, 30 * kPa), gravity=HANGING)
    down = straight.gradient("plate_mass", tip=[0, 0, 1, 0, 0, 0]).values
    # Each plate stretches what is above it, g over the sum of EA/l: no plate stretches less than the one above it.
    assert 0.0 < down[0] < down[1] < down[2]
    stretch = [9.81 * rods[0].length / (3.0 * rods[0].section.axial) for rods in straight.rods]
    assert_allclose(down, np.cumsum(stretch), rtol=1e-6)


def test_rods_given_directly_have_their_section_differentiated() -> None:
    limb = rods_limb()
    found = limb.solve(gravity=HANGING, tip_force=(0.1, 0.05, 0.0), tolerance=1e-12)
    names = ("length", "section", "ring_radius", "plate_thickness", "rod_forces")
    exact = found.derivative(("plates", "centreline"), names, n=5)
    for label in ("segments[0].length", "segments[1].section.rest_twist", "segments[0].section.extension_twist"):
        value = bench_derivatives.value_of(found, label)
        loads = {"gravity": HANGING, "tip_force": (0.1, 0.05, 0.0), "tolerance": 1e-12}
        expected = perturbed.slope(found, loads, label, 0.04 * value, 5, False)[:-1]
        assert_allclose(exact[label], expected, rtol=0.0, atol=1e-7 * np.linalg.norm(expected))


def test_points_of_the_centreline_stand_where_they_are_asked_for(posture: sl.Posture) -> None:
    shares = np.linspace(0.0, 1.0, 7)
    assert_allclose(posture.centreline(at=shares), posture.centreline(7), rtol=0.0, atol=1e-15)
    few = posture.derivative("centreline", "pressures", at=shares[[1, 4]])
    every = posture.derivative("centreline", "pressures", n=7).matrix.reshape(7, 3, 9)
    assert few.rows == tuple(f"centreline[{k}].{along}" for k in range(2) for along in "xyz")
    scale = np.abs(every).max()
    assert_allclose(few.matrix.reshape(2, 3, 9), every[[1, 4]], rtol=0.0, atol=1e-12 * scale)
    for wrong in ([-0.1], [1.1], [np.nan], 0.5, []):
        with pytest.raises(ValueError, match="at must be"):
            posture.centreline(at=wrong)


# A posture that was followed has its Jacobian from the linearisation that its solve ended with.


def walk(limb: sl.Limb, steps: int, seed: int, **options: Any) -> list[sl.Posture]:
    rng = np.random.default_rng(seed)
    pressures = rng.uniform(5, 60, 9) * kPa
    posture = limb.solve(pressures, **options)
    posture = limb.solve(pressures, start=posture, **options)
    found = []
    for _ in range(steps):
        pressures = pressures * (1.0 + 0.01 * rng.uniform(-1.0, 1.0, 9))
        posture = limb.solve(pressures, start=posture, **options)
        found.append(posture)
    return found


@pytest.mark.parametrize("section", ["tangent", "nonlinear", "paper"])
@pytest.mark.parametrize("valve", ["open", "locked"])
def test_the_jacobian_along_a_walk_is_the_slope_of_its_tips(reference: sl.Limb, section: Any, valve: Any) -> None:
    options: dict[str, Any] = {"gravity": HANGING, "tip_force": (0.1, 0.0, 0.0), "section": section, "valve": valve}
    followed = [posture for posture in walk(reference, 6, seed=8, **options) if posture._solved.followed]
    assert len(followed) >= 3
    for posture in followed:
        tight = reference.solve(posture.pressures, start=posture, tolerance=1e-11, **options)
        expected = tight.derivative("tip", to="pressures").matrix
        for rows in (slice(3), slice(3, 6)):
            # The posture's own error is within its tolerance; its slope may err by a few times that.
            assert_allclose(posture.jacobian[rows], expected[rows], rtol=0.0, atol=5e-6 * np.abs(expected[rows]).max())


@pytest.mark.parametrize("share", [-0.3, 0.1, 0.3, 0.8])
def test_derivatives_hold_where_forces_leave_the_axial_law(share: float) -> None:
    # The law goes on as a parabola from the end of its range, -0.12 and 0.2 of EA, which moves with the pressure.
    limb, pressures = presets.reference_limb(["middle"]), np.array([30.0, 50.0, 40.0]) * kPa
    stiffness = 3.0 * limb.segments[0].actuators[0].section(40 * kPa, "nonlinear").axial
    options: dict[str, Any] = {"tip_force": (0.01 * stiffness, 0.0, share * stiffness), "section": "nonlinear"}
    posture = solved(limb, pressures, **options, tolerance=1e-11)
    assert ("axial force leaves" in posture.message) == (share != 0.1)
    followed = solved(limb, pressures * (1.0 + 1e-7), start=posture, **options, tolerance=1e-11)
    assert followed._solved.followed == (share > 0.0)  # turned over by its push, it is left to Newton
    step, slopes, energies = 10.0, np.zeros((3, 3)), np.zeros(3)
    for number, change in enumerate(step * np.eye(3)):
        ends = [solved(limb, pressures + side * change, start=posture, **options, tolerance=1e-12) for side in (1, -1)]
        slopes[:, number] = (ends[0].tip[:3, 3] - ends[1].tip[:3, 3]) / (2.0 * step)
        energies[number] = (ends[0].energy - ends[1].energy) / (2.0 * step)
    # Solves to 1e-12 over a change of the tip by 1e-5 of the length leave 1e-7, and the third derivative less.
    allowed = 5e-7 * np.abs(slopes).max()
    assert_allclose(posture.jacobian[:3], slopes, rtol=0.0, atol=allowed)
    assert_allclose(followed.jacobian[:3], slopes, rtol=0.0, atol=2.0 * allowed)
    assert_allclose(posture.derivative("tip").matrix[:3], slopes, rtol=0.0, atol=allowed)
    of_energy = posture.derivative("energy").matrix[0]
    assert_allclose(of_energy, energies, rtol=0.0, atol=5e-7 * np.abs(energies).max())


def test_the_jacobian_along_a_walk_is_the_same_wherever_it_is_asked_for(reference: sl.Limb) -> None:
    postures = walk(reference, 8, seed=8, gravity=HANGING)
    assert sum(posture._solved.followed for posture in postures) > 4  # more than a thread keeps
    read = [pickle.loads(pickle.dumps(posture)) for posture in postures]
    at_once = []
    for posture, again in zip(walk(reference, 8, seed=8, gravity=HANGING), postures, strict=True):
        assert np.array_equal(posture.plates, again.plates)
        at_once.append(posture.jacobian)
    with ThreadPoolExecutor(1) as pool:
        elsewhere = list(pool.map(lambda posture: posture.jacobian, postures))
    for one, other, third in zip(at_once, elsewhere, read, strict=True):
        assert np.array_equal(one, other) and np.array_equal(one, third.jacobian)


def test_a_posture_that_is_followed_from_a_file_has_the_same_bits(reference: sl.Limb) -> None:
    postures = walk(reference, 3, seed=9, gravity=HANGING)
    again = reference.solve(postures[2].pressures, start=pickle.loads(pickle.dumps(postures[1])), gravity=HANGING)
    assert np.array_equal(again.plates, postures[2].plates)
    assert again.error_estimate == postures[2].error_estimate <= postures[2].tolerance


def test_rods_without_pressures_have_no_jacobian_to_them_though_followed() -> None:
    limb = rods_limb()
    posture = limb.solve(gravity=HANGING)
    for step in range(3):
        posture = limb.solve(gravity=HANGING, tip_force=(1e-3 * step, 0.0, 0.0), start=posture)
    assert posture._solved.followed
    with pytest.raises(RuntimeError, match="needs a posture that was solved from pressures"):
        posture.jacobian  # noqa: B018


# Energy


def test_the_energy_of_a_stretched_rod_is_a_triangle() -> None:
    section = sl.Section(axial=200.0, shear=100.0, bending=0.02, torsion=0.015)
    limb = sl.Limb([sl.Segment(rods=[sl.Rod(section, 0.3)], ring_radius=0.0)])
    force = 5.0
    found = limb.solve(tip_force=(0.0, 0.0, force), tolerance=1e-12)
    strain = force / 200.0
    # F e l / 2 stored, F (l + e l) done: the rest is exact but for rounding.
    assert_allclose(found.energy, 0.5 * force * strain * 0.3 - force * 0.3 * (1.0 + strain), rtol=1e-12)
    slopes = found.gradient(("tip_force", "length"), energy=1.0)
    assert_allclose(slopes["tip_force.z"], -found.tip[2, 3], rtol=1e-12)  # Castigliano
    assert_allclose(slopes["length"][0], -force - 0.5 * force * strain, rtol=1e-12)


def test_loads_without_a_potential_have_no_energy(reference: sl.Limb) -> None:
    found = reference.solve(PRESSURES, tip_moment=(0.01, 0.0, 0.0))
    with pytest.raises(RuntimeError, match="no potential"):
        found.energy  # noqa: B018
    with pytest.raises(RuntimeError, match="no potential"):
        found.derivative("energy", "pressures")
    plain = reference.solve(PRESSURES, tip_force=(0.1, 0.0, 0.0))
    with pytest.raises(RuntimeError, match=r"to names a load that has no potential .*, among tip_force, tip_moment"):
        plain.derivative("energy", ("tip_force", "tip_moment"))
    assert np.isfinite(plain.derivative("energy", "tip_force").matrix).all()


# What is refused, and what is kept


def test_what_is_wrong_is_named(reference: sl.Limb, posture: sl.Posture) -> None:
    with pytest.raises(ValueError, match=r"to must be names among .*, got 'presures'"):
        posture.derivative("tip", "presures")
    for wrong in (3, None, b"length"):
        with pytest.raises(ValueError, match=f"to must be a name or a sequence of names, got {wrong!r}"):
            posture.derivative("tip", wrong)  # type: ignore[arg-type]
        with pytest.raises(ValueError, match=f"of must be a name or a sequence of names, got {wrong!r}"):
            posture.derivative(wrong, "gravity")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="no part of the limb has it"):
        posture.derivative("tip", "fibre_stiffness")
    with pytest.raises(ValueError, match="to must name each kind of parameter once"):
        posture.derivative("tip", ("gravity", "gravity"))
    with pytest.raises(ValueError, match=r"of must be one of .*, got \"tipp\""):
        posture.derivative("tipp", "gravity")
    with pytest.raises(ValueError, match="of must name each answer once"):
        posture.derivative((), "gravity")
    with pytest.raises(ValueError, match="each must be one of"):
        posture.derivative("tip", "gravity", each="tube")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="a curve needs a whole number of points"):
        posture.derivative("centreline", "gravity", n=1)
    with pytest.raises(ValueError, match="a gradient needs weights"):
        posture.gradient("gravity")
    with pytest.raises(ValueError, match=r"tip has shape \(3,\): expected \(6,\)"):
        posture.gradient("gravity", tip=[0, 0, 1])
    with pytest.raises(ValueError, match="centreline"):
        posture.gradient("gravity", centreline=[[0, 0, np.nan], [0, 0, 1]])
    burst = sl.Limb([sl.Segment([plain()], ring_radius=0.0)]).solve([200 * kPa])  # it balloons at 90 kPa
    with pytest.raises(RuntimeError, match="exists at an equilibrium only"):
        burst.derivative()


def test_a_posture_that_was_differentiated_pickles(posture: sl.Posture) -> None:
    posture.derivative("tip", "radii")
    again = pickle.loads(pickle.dumps(posture))
    assert np.array_equal(again.derivative("tip", "radii").matrix, posture.derivative("tip", "radii").matrix)


def test_pressures_stay_where_rest_lengths_were_given(reference: sl.Limb) -> None:
    by_pressures = reference.solve(PRESSURES, gravity=HANGING, tolerance=1e-10)
    by_lengths = reference.solve(rest_lengths=by_pressures.rest_lengths, gravity=HANGING, tolerance=1e-10)
    for name in ("pressures", "radii"):
        first, second = (p.derivative("tip", name).matrix for p in (by_pressures, by_lengths))
        # The pressures come back from lengths to 1e-13; the postures to their tolerance.
        assert_allclose(second, first, rtol=0.0, atol=1e-7 * np.abs(first).max())
