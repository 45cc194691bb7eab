"""What a scene does not need is left out, is named in the plan, and leaves the answer as it was."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import softlimb as sl
from frames import solved
from softlimb import presets
from softlimb.units import kPa, mm

HANGING = (0.0, 0.0, 9.81)
UNEQUAL = np.array([30.0, 20.0, 10.0, 20.0, 25.0, 15.0, 25.0, 20.0, 10.0]) * kPa
TRACE = 1e-13  # [N] and [m/s^2]: moves the tip by less than 1e-12 of the length, and nothing can be left out


@pytest.fixture(scope="module")
def limb() -> sl.Limb:
    return presets.reference_limb()


def words(found: sl.Posture) -> str:
    return "; ".join(found.plan)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-9])
@pytest.mark.parametrize("section", ["tangent", "nonlinear"])
def test_segments_without_loads_are_solved_one_by_one(limb: sl.Limb, tolerance: float, section: Any) -> None:
    apart = solved(limb, UNEQUAL, tolerance=tolerance, section=section)
    whole = solved(limb, UNEQUAL, tip_force=(TRACE, 0.0, 0.0), tolerance=tolerance, section=section)
    assert "one by one" in words(apart) and "one by one" not in words(whole)
    assert_allclose(apart.plates, whole.plates, rtol=0.0, atol=2.0 * tolerance)
    assert_allclose(apart.centreline(21), whole.centreline(21), rtol=0.0, atol=2.0 * tolerance * limb.length)
    assert apart.stable and apart.unstable_modes == whole.unstable_modes == 0
    # Forces are looser than positions: the rods' axial stiffness, 1e3 N, over their length times the error of a tip.
    assert_allclose(apart.base_wrench, 0.0, rtol=0.0, atol=1e4 * tolerance)
    slack = 10.0 * tolerance * np.abs(whole.compliance).max()
    assert_allclose(apart.compliance, whole.compliance, rtol=0.0, atol=slack)


def test_equal_segments_at_equal_pressures_are_solved_once(limb: sl.Limb) -> None:
    twice = sl.Limb([limb.segments[2]] * 3)
    equal = solved(twice, np.tile([30.0, 20.0, 10.0], 3) * kPa, tolerance=1e-9)
    other = solved(twice, np.concatenate([np.tile([30.0, 20.0, 10.0], 2), [30.0, 20.0, 10.001]]) * kPa)
    assert "solved once" in words(equal)
    assert "solved once" in words(other)  # the first two
    unequal = solved(twice, np.array([30.0, 20.0, 10.0, 29.0, 20.0, 10.0, 30.0, 20.0, 10.0]) * kPa)
    assert "solved once" not in words(unequal)
    steps = [np.linalg.inv(np.eye(4)) @ equal.plates[0]]
    lift = np.eye(4)
    lift[2, 3] = twice.segments[0].plate.thickness
    for below, above in zip(equal.plates[:-1], equal.plates[1:], strict=True):
        steps.append(np.linalg.inv(below @ lift) @ above)
    assert_allclose(steps[1:], [steps[0]] * 2, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("pull", [0.0, 3.0, -0.5])
def test_equal_pressures_and_axial_loads_give_the_straight_limb_in_closed_form(limb: sl.Limb, pull: float) -> None:
    pressures = np.repeat([40.0, 20.0, 30.0], 3) * kPa
    found = solved(limb, pressures, gravity=HANGING, tip_force=(0.0, 0.0, pull))
    assert "closed form" in words(found) and found.iterations == 1 and found.stable
    # By hand: every rod carries a third of what is beyond it, and a linear law stretches it by its mean force.
    height, beyond = 0.0, pull
    for segment, rods in zip(reversed(limb.segments), reversed(found.rods), strict=True):
        rod = rods[0]
        weight = 9.81 * rod.section.mass_per_length * rod.length
        beyond += 9.81 * segment.plate.mass
        mean = (beyond + 1.5 * weight) / 3.0
        height += rod.length * (1.0 + mean / rod.section.axial)
        beyond += 3.0 * weight
    height += sum(segment.plate.thickness for segment in limb.segments[:-1])
    assert_allclose(found.tip[:3, 3], (0.0, 0.0, height), rtol=0.0, atol=1e-12)
    assert_allclose(found.base_wrench[2], -beyond, rtol=1e-12)


def test_a_straight_limb_that_would_fall_over_is_not_given_for_stable(limb: sl.Limb) -> None:
    found = solved(limb, np.full(9, 40.0 * kPa), gravity=(0.0, 0.0, -9.81))
    assert found.stable and "closed form" not in words(found)
    assert np.hypot(*found.tip[:2, 3]) > 100 * mm


@pytest.mark.parametrize(
    "change",
    [
        {"tip_force": (0.01, 0.0, 0.0)},
        {"gravity": (0.1, 0.0, 9.81)},
        {"tip_moment": (0.0, 0.0, 1e-3)},
        {"rod_forces": np.r_[np.zeros(26), 0.01]},
        {"frame": "plate", "tip_force": (0.0, 0.0, 0.1)},
    ],
)
def test_a_scene_that_bends_or_twists_is_not_taken_for_straight(limb: sl.Limb, change: dict[str, Any]) -> None:
    found = limb.solve(np.full(9, 30.0 * kPa), **{"gravity": HANGING, **change})
    assert found.success and "closed form" not in words(found)


def test_rods_without_load_along_them_say_so(limb: sl.Limb) -> None:
    assert "six columns" in words(solved(limb, UNEQUAL, tip_force=(0.1, 0.0, 0.0)))
    assert "six columns" not in words(solved(limb, UNEQUAL, tip_force=(0.1, 0.0, 0.0), gravity=HANGING))
