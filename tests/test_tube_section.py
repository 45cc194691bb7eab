from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import softlimb as sl
from softlimb._core import axial_strain, axial_strain_slope
from softlimb.units import deg, kPa
from tube_examples import MODULUS, plain, proximal, reference_file, tube_of, unequal

FIELDS = ("axial", "shear", "bending", "torsion", "mass_per_length", "rest_twist", "extension_twist", "stretch")


def test_bending_stiffness_agrees_with_finite_elements(shared: Path) -> None:
    data = reference_file(shared)
    tubes = {c["name"]: tube_of(c) for c in data["cases"]}
    # Slices in pure bending. The scaling of EI with EA is a model: the claim is 3 % proximal and plain, 5 % distal.
    for case, name, tolerance in (("prox_S950", "A1_prox_S950_a3", 0.03), ("dist_DS30", "A3_dist_DS30_a3", 0.05),
                                  ("nofibre_neo", "A13_no_fibres_S950", 0.03)):
        for item in data["bending_slices"]:
            if item["case"] == case:
                section = tubes[name].section(item["pressure"])
                per_rest_length = item["EI_per_reference_length"] * item["stretch"]
                assert_allclose(section.bending, per_rest_length, rtol=tolerance)
                assert_allclose(section.axial, item["EA_tangent_per_reference_length"] * item["stretch"], rtol=1e-8)


def test_sections_of_the_reference_limb(shared: Path) -> None:
    data = json.loads((shared / "reference" / "limb_postures.json").read_text())
    laws: dict[str, Any] = {"dragon-skin-30": sl.Yeoh(c1=86.1e3, c2=13.6e3), "smoothsil-950": sl.NeoHookean(c1=340e3)}
    for j, geometry in enumerate(data["geometry"]):
        fibres = [sl.Fibres(angle=a * deg, modulus=MODULUS, fraction=geometry["fibre_fraction_each"])
                  for a in geometry["fibre_angle_deg"]]
        tube = sl.Tube(0.2, [sl.Layer(geometry["R_i"], geometry["R_m"], laws[geometry["core"]]),
                             sl.Layer(geometry["R_m"], geometry["R_o"], laws[geometry["skin"]], fibres=fibres)],
                       mass=geometry["mass_of_one_actuator"])
        for case in data["cases"]:
            for i in range(3):
                rod = case["rods"][j][i]
                found = tube.section_at(case["pressures_kPa"][j][i] * kPa)
                # both sides solve to 1e-10
                assert_allclose(found.rest_length, rod["rest_length"], rtol=1e-9)
                for field in ("axial", "shear", "bending", "torsion", "mass_per_length", "stretch"):
                    assert_allclose(getattr(found.section, field), rod[field], rtol=1e-9)


@pytest.mark.parametrize("valve", ["open", "locked"])
@pytest.mark.parametrize("model", ["tangent", "nonlinear", "paper"])
@pytest.mark.parametrize("make", [proximal, unequal, lambda: proximal(tension_only=True),
                                  lambda: unequal(ends="bonded", cap_length=0.004)])
def test_derivatives_to_the_pressure(make: Any, model: Any, valve: Any) -> None:
    tube = make()
    pressure, h = 42 * kPa, 20.0
    at, above, below = (tube.section_at(p, model, valve) for p in (pressure, pressure + h, pressure - h))
    # central differences: truncation (h/P)^2 = 2e-7, rounding 1e-12/(h/P) = 2e-9
    assert_allclose(at.d_rest_length, (above.rest_length - below.rest_length) / (2 * h), rtol=1e-6)
    for field in FIELDS:
        slope = (getattr(above.section, field) - getattr(below.section, field)) / (2 * h)
        size = abs(getattr(at.section, field)) / pressure
        assert_allclose(getattr(at.d_section, field), slope, rtol=1e-5, atol=1e-6 * size)
    if model == "nonlinear" and valve == "open":
        for force in (-0.3, -0.08, -0.02, 0.05, 0.15, 0.4):  # the outermost beyond the law's range
            n = force * at.section.axial
            slope = (axial_strain(above.section, n)[0] - axial_strain(below.section, n)[0]) / (2 * h)
            found = axial_strain_slope(at.section, at.d_section, n)
            assert_allclose(found, slope, rtol=1e-3 if tube.tension_only else 1e-4)
            # interpolation error 1e-10 over h/P; of a curve with slack boundaries 1e-5


def test_tangents_are_derivatives_of_the_tube() -> None:
    tube = unequal()
    pressure = 35 * kPa
    rest, section = tube.inflate(pressure), tube.section(pressure)
    f, m = 1e-3, 1e-5  # strains of 2e-6: truncation and rounding both below 1e-8
    plus, minus = tube.inflate(pressure, [f, 0.0], [0.0, m]), tube.inflate(pressure, [-f, 0.0], [0.0, -m])
    strain = (plus.stretch - minus.stretch) / (2 * rest.stretch)
    twist = (plus.twist_rate - minus.twist_rate) / (2 * rest.stretch)
    assert_allclose(strain[0] / f, 1 / section.axial, rtol=1e-7)
    assert_allclose(twist[1] / m, 1 / section.torsion, rtol=1e-7)
    assert_allclose(strain[1] / m, section.extension_twist, rtol=1e-6)
    assert_allclose(twist[0] / f, section.extension_twist, rtol=1e-6)
    assert_allclose(section.rest_twist, rest.twist_rate / rest.stretch, rtol=1e-12)


def test_locked_valve_keeps_the_volume() -> None:
    tube = unequal()
    rest = tube.inflate(35 * kPa)
    section = tube.section(35 * kPa, valve="locked")
    f = 1e-3
    plus, minus = (tube.inflate_volume(rest.volume, axial_force=x) for x in (f, -f))
    assert_allclose((plus.stretch - minus.stretch) / (2 * f * rest.stretch), 1 / section.axial, rtol=1e-6)
    open_valve = tube.section(35 * kPa)
    assert section.axial > open_valve.axial
    assert (section.bending, section.shear) == (open_valve.bending, open_valve.shear)


def test_unequal_families_couple_extension_and_twist_within_bounds() -> None:
    section = unequal().section(0.0)
    # 0.57 is the design's figure for the square of the correlation of the two compliances (+20/-35 degrees)
    assert_allclose(section.extension_twist**2 * section.axial * section.torsion, 0.57, atol=0.01)
    assert proximal().section(55 * kPa).extension_twist == 0.0


def test_bonded_ends_hand_over_an_uncoupled_section() -> None:
    section = unequal(ends="bonded").section(40 * kPa)
    assert section.extension_twist == 0.0 and section.rest_twist == 0.0
    assert section.axial > unequal().section(40 * kPa).axial


def test_the_papers_constants() -> None:
    tube = proximal()
    section = tube.section(55 * kPa, model="paper")
    core, skin = 6 * 86.1e3, 6 * 340e3 * (1 - 2 * 0.0083)
    area = np.pi * (core * (0.0205**2 - 0.018**2) + skin * (0.0215**2 - 0.0205**2))
    inertia = np.pi / 4 * (core * (0.0205**4 - 0.018**4) + skin * (0.0215**4 - 0.0205**4))
    assert_allclose((section.axial, section.bending), (area, inertia), rtol=1e-12)
    assert_allclose((section.shear, section.torsion), (area / 3, 2 * inertia / 3), rtol=1e-12)
    assert_allclose(tube.section_at(55 * kPa, "paper").rest_length, 0.2 * tube.inflate(55 * kPa).stretch, rtol=1e-14)


@pytest.mark.parametrize("make", [proximal, unequal, lambda: proximal(tension_only=True)])
def test_nonlinear_axial_law_is_the_tubes_own(make: Any) -> None:
    tube = make()
    for pressure in (0.0, 20 * kPa, 90 * kPa):
        if pressure == 0.0 and tube.tension_only:
            continue  # the tangent at rest is one-sided there, the curve has a corner
        section = tube.section(pressure, model="nonlinear")
        assert section.nonlinear
        force = section.axial * np.linspace(-0.12, 0.2, 33)
        stretch = tube.inflate(pressure, force).stretch
        strain = np.array([axial_strain(section, n)[0] for n in force])
        # degree 12 on a curve that is analytic well beyond the range; slack boundaries make it less smooth
        expected = stretch / tube.inflate(pressure).stretch - 1
        assert_allclose(strain, expected, rtol=0, atol=5e-5 if tube.tension_only else 2e-9)
        assert_allclose(axial_strain(section, 0.0), (0.0, 1 / section.axial), rtol=1e-10)


@pytest.mark.parametrize("make", [proximal, unequal, lambda: proximal(tension_only=True)])
def test_nonlinear_axial_law_with_a_locked_valve(make: Any) -> None:
    tube = make()
    rest = tube.inflate(20 * kPa)
    section = tube.section(20 * kPa, model="nonlinear", valve="locked")
    force = tube.section(20 * kPa).axial * np.linspace(-0.02, 0.02, 9)
    stretch = np.array([tube.inflate_volume(rest.volume, axial_force=n).stretch for n in force])
    strain = np.array([axial_strain(section, n)[0] for n in force])
    # the range shrinks until the curve is met to 1e-3 of the strain; beyond it goes on as a parabola
    assert_allclose(strain, stretch / rest.stretch - 1, rtol=0.05 if tube.tension_only else 1e-4, atol=1e-12)


def test_nonlinear_law_gets_a_shorter_range_where_the_tube_folds() -> None:
    tube = plain()
    pressure = 0.97 * tube.limit_pressure
    section = tube.section(pressure, model="nonlinear")
    assert section.nonlinear
    n = 0.01 * section.axial
    rest = tube.inflate(pressure).stretch
    assert_allclose(axial_strain(section, n)[0], tube.inflate(pressure, n).stretch / rest - 1, rtol=1e-6)


def test_rest_and_smallest_pressure_agree_for_tension_only_fibres() -> None:
    tube = proximal(tension_only=True)
    rest, first = tube.section(0.0), tube.section(1.0)
    # one pascal strains the tube by 2e-6
    for field in ("axial", "bending", "torsion"):
        assert_allclose(getattr(rest, field), getattr(first, field), rtol=2e-5)


def test_caps_shorten_the_gain_and_stiffen_the_rod() -> None:
    bare, capped = proximal(), proximal(cap_length=0.002)
    a, b = bare.section_at(55 * kPa), capped.section_at(55 * kPa)
    strain = bare.inflate(55 * kPa).stretch - 1
    assert_allclose(a.rest_length - b.rest_length, 0.004 * strain, rtol=1e-12)
    assert_allclose(b.rest_length / b.section.axial, a.rest_length * 0.98 / a.section.axial, rtol=1e-12)


def test_no_section_past_ballooning() -> None:
    with pytest.raises(ValueError, match=r"ballooning at about 90\.59 kPa"):
        plain().section(95 * kPa)


def test_fit_range_of_the_laws_reaches_the_rod() -> None:
    law = sl.Yeoh(c1=86.1e3, c2=13.6e3, max_strain=0.5)
    tube = sl.Tube(0.2, [sl.Layer(0.018, 0.0205, law), proximal().layers[1]])
    assert tube.section(20 * kPa).largest_stretch == 1.5
    assert proximal().section(20 * kPa).largest_stretch == 0.0


@pytest.mark.parametrize("angle", [84.2, 89.4])
def test_the_section_at_rest_is_the_limit_of_small_pressures_also_where_stiff_fibres_run_along_the_tube(angle) -> None:
    fibres = sl.Fibres.pair(angle=angle * deg, stiffness=1e9)
    core, skin = sl.Yeoh(c1=86.1 * kPa, c2=13.6 * kPa), sl.NeoHookean(c1=340 * kPa)
    layers = [sl.Layer(0.018, 0.0205, core), sl.Layer(0.0205, 0.0215, skin, fibres=fibres)]
    tube = sl.Tube(0.2, layers, tension_only=True)
    rest = tube.section(0.0).axial
    # A pascal strains the tube by 1e-10 to 1e-8; fibres of 10 000 shear moduli turn that into per cents.
    for pressure in (1e-9, 1e-4, 1e-2, 1.0):
        assert tube.section(pressure).axial == pytest.approx(rest, rel=2e-2)
    # Extrapolated from where the strain has enough digits.
    first, second = (tube.section(pressure).axial for pressure in (0.5, 1.0))
    assert rest == pytest.approx(2.0 * first - second, rel=5e-3)
