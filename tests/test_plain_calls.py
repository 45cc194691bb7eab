"""Calls in plain numbers take a short way into the core: the same bits as the checked way, and nothing else."""

from __future__ import annotations

import gc
import pickle
import weakref
from decimal import Decimal
from typing import Any

import numpy as np
import pytest

import softlimb as sl
from frames import solved
from softlimb import presets
from softlimb.units import kPa, mm

HANGING = (0.0, 0.0, 9.81)
COMPLEX = np.array([90.0, 60.0, 30.0, 60.0, 40.0, 20.0, 50.0, 50.0, 50.0]) * kPa


@pytest.fixture(scope="module")
def reference() -> sl.Limb:
    return presets.reference_limb()


def plain(limb: sl.Limb, pressures: Any, **given: Any) -> Any:
    """What the short way alone says: a posture of the core, or None."""
    arguments = {
        "rest_lengths": None,
        "gravity": (0.0, 0.0, 0.0), "tip_force": (0.0, 0.0, 0.0), "tip_moment": (0.0, 0.0, 0.0), "frame": "base",
        "tolerance": 1e-6, "start": None, "prefer_stable": True, "section": "tangent", "valve": "open",
    } | given  # fmt: skip
    return limb._plain.solve(pressures, *arguments.values())


def checked(limb: sl.Limb, pressures: Any, **given: Any) -> sl.Posture:
    """By the checked way: wrenches on the plates are nothing for the short one."""
    return limb.solve(pressures, plate_wrenches=np.zeros((len(limb), 6)), **given)


SCENES: list[dict[str, Any]] = [
    {},
    {"gravity": (0, 0, 9.81), "tip_force": [0.1, -0.2, 0.0], "tolerance": 1e-9},
    {"gravity": np.array([1.0, 0.0, 3.0]), "section": "nonlinear", "valve": "locked"},
    {"tip_moment": (0.0, 0.01, 0.0), "frame": "plate", "section": "paper", "prefer_stable": False},
]


@pytest.mark.parametrize("scene", SCENES)
def test_a_plain_call_is_the_checked_call_bit_for_bit(reference: sl.Limb, scene: dict[str, Any]) -> None:
    pressures = 0.5 * COMPLEX
    assert plain(reference, pressures, **scene) is not None
    short, long = reference.solve(pressures, **scene), checked(reference, pressures, **scene)
    assert np.array_equal(short.plates, long.plates)
    for name in ("status", "message", "plan", "iterations", "residual", "stable", "unstable_modes", "tolerance"):
        assert getattr(short, name) == getattr(long, name), name
    assert np.array_equal(short.rest_lengths, long.rest_lengths)
    assert short.pressures is not None and np.array_equal(short.pressures, pressures)
    assert short.loads.keys() == long.loads.keys()
    for name, value in long.loads.items():
        assert np.array_equal(short.loads[name], value), name
    if short.success:
        assert np.array_equal(short.jacobian, long.jacobian)
    # Warm as well, from a posture of either way.
    again = reference.solve(1.01 * pressures, **scene, start=long)
    assert np.array_equal(again.tip, checked(reference, 1.01 * pressures, **scene, start=short).tip)


@pytest.mark.parametrize(
    "pressures",
    [
        COMPLEX, COMPLEX.tolist(), tuple(COMPLEX), COMPLEX.reshape(3, 3), COMPLEX.reshape(3, 3).tolist(),
        list(COMPLEX.reshape(3, 3)), np.repeat(COMPLEX, 2)[::2], np.asfortranarray(COMPLEX.reshape(3, 3)),
        [90000, 60000, 30000, 60000, 40000.0, 20000, 50000, 50000, np.float64(50000)],
    ],
)  # fmt: skip
def test_pressures_of_every_plain_kind_are_read_in_their_order(reference: sl.Limb, pressures: Any) -> None:
    found = plain(reference, pressures)
    assert found is not None and np.array_equal(found.pressures, COMPLEX)


@pytest.mark.parametrize(
    "change",
    [
        {"pressures": COMPLEX.astype(np.float32)}, {"pressures": COMPLEX.astype(">f8")}, {"pressures": range(9)},
        {"pressures": [True] + [0.0] * 8}, {"pressures": [Decimal(1)] + [0.0] * 8}, {"pressures": [10**400] + [0] * 8},
        {"pressures": np.full(9, np.nan)}, {"pressures": np.zeros(8)}, {"pressures": np.zeros((3, 4))[:, :2]},
        {"pressures": np.ma.masked_array(COMPLEX)}, {"pressures": None}, {"pressures": [[0.0] * 3] * 2},
        {"gravity": 9.81}, {"gravity": (0.0, 0.0)}, {"tip_force": None}, {"frame": "tip"}, {"tolerance": 1},
        {"tolerance": np.float64(0.5)}, {"tolerance": 1e-15}, {"prefer_stable": 1}, {"prefer_stable": np.True_},
        {"section": "linear"}, {"valve": b"open"}, {"start": np.eye(4)}, {"start": "x"},
        {"pressures": np.full(9, 1e9)},
    ],
)  # fmt: skip
def test_what_is_not_plain_is_left_to_the_checks(reference: sl.Limb, change: dict[str, Any]) -> None:
    given = {"pressures": COMPLEX} | change
    assert plain(reference, given.pop("pressures"), **given) is None


def test_unaligned_pressures_are_read_as_they_are(reference: sl.Limb) -> None:
    record = np.zeros(9, dtype=[("flag", "i1"), ("pressure", "f8")])
    record["pressure"] = COMPLEX
    found = reference.solve(record["pressure"])
    assert found.pressures is not None and np.array_equal(found.pressures, COMPLEX)


def test_a_start_from_a_limb_of_other_numbers_is_refused_by_both_ways(reference: sl.Limb) -> None:
    short = solved(presets.reference_limb(["proximal"]), [0.0, 0.0, 0.0])
    assert plain(reference, COMPLEX, start=short._solved) is None
    with pytest.raises(ValueError, match="start is the posture of another limb"):
        reference.solve(COMPLEX, start=short)


def test_what_is_done_to_arguments_afterwards_does_not_reach_the_posture(reference: sl.Limb) -> None:
    pressures, gravity = COMPLEX.copy(), np.array(HANGING)
    found = reference.solve(pressures, gravity=gravity)
    pressures[:], gravity[:] = 0.0, 0.0
    assert found.pressures is not None and np.array_equal(found.pressures, COMPLEX)
    assert np.array_equal(found.loads["gravity"], HANGING)


def test_a_posture_pickles_before_and_after_it_was_asked_for_its_arguments(reference: sl.Limb) -> None:
    found = reference.solve(COMPLEX, gravity=HANGING, tip_force=(0.1, 0.0, 0.0))
    fresh = pickle.loads(pickle.dumps(found))
    assert np.array_equal(fresh.pressures, COMPLEX)
    assert np.array_equal(fresh.loads["tip_force"], [0.1, 0.0, 0.0])
    asked = pickle.loads(pickle.dumps(found))
    assert np.array_equal(asked.rest_lengths, found.rest_lengths)


def test_a_limb_of_rods_needs_no_pressures() -> None:
    section = sl.Section(axial=400.0, shear=130.0, bending=0.08, torsion=0.06, mass_per_length=0.4)
    limb = sl.Limb([sl.Segment(rods=[sl.Rod(section, 0.2, radius=4 * mm)] * 3, ring_radius=0.03)])
    found = solved(limb, gravity=HANGING)
    assert found.pressures is None and plain(limb, None) is not None and plain(limb, []) is None
    # Three rods on a ring: sqrt(3) radii between centres.
    assert found.clearance == pytest.approx(np.sqrt(3.0) * 0.03 - 8 * mm, rel=1e-9)


def test_rest_lengths_of_rods_are_plain_and_those_of_tubes_are_not(reference: sl.Limb) -> None:
    section = sl.Section(axial=400.0, shear=130.0, bending=0.08, torsion=0.06, mass_per_length=0.4)
    limb = sl.Limb([sl.Segment(rods=[sl.Rod(section, 0.2)] * 3, ring_radius=0.03)] * 2)
    lengths = np.array([[0.2, 0.21, 0.22], [0.19, 0.2, 0.2]])
    assert plain(limb, None, rest_lengths=lengths) is not None
    short = limb.solve(rest_lengths=lengths, gravity=HANGING)
    long = checked(limb, None, rest_lengths=lengths, gravity=HANGING)
    assert np.array_equal(short.plates, long.plates) and np.array_equal(short.rest_lengths, lengths.ravel())
    for wrong in (lengths[0], -lengths, 0.0 * lengths, lengths.astype(np.float32), [0.2] * 5, np.nan * lengths):
        assert plain(limb, None, rest_lengths=wrong) is None
    assert plain(reference, None, rest_lengths=np.full(9, 0.2)) is None
    assert plain(reference, COMPLEX, rest_lengths=np.full(9, 0.2)) is None
    with pytest.raises(ValueError, match="either pressures or rest_lengths"):
        reference.solve(COMPLEX, rest_lengths=np.full(9, 0.2))


def test_a_rod_that_was_solved_still_pickles_and_equals_its_copy() -> None:
    rod = sl.Rod(sl.Section(axial=400.0, shear=130.0, bending=0.08, torsion=0.06), 0.2)
    tip = rod.cantilever(tip_force=(0.1, 0.0, 0.0)).tip
    copy = pickle.loads(pickle.dumps(rod))
    assert copy == rod and np.array_equal(copy.cantilever(tip_force=(0.1, 0.0, 0.0)).tip, tip)


def test_the_tubes_of_the_straight_reference_limb_are_as_far_apart_as_their_rings_say(reference: sl.Limb) -> None:
    found = solved(reference, np.zeros(9))
    # Distal: ring of 14 mm, tubes of 10.75 mm. Where segments meet the plates keep their tubes apart.
    assert found.clearance == pytest.approx(np.sqrt(3.0) * 14 * mm - 2 * 10.75 * mm, rel=1e-9)


def test_clearance_does_not_depend_on_how_finely_the_tubes_are_cut(reference: sl.Limb) -> None:
    found = solved(reference, COMPLEX, gravity=HANGING)
    radii = [member.outer_radius or 0.0 for segment in reference for member in segment.members]
    coarse, fine = (found._solved.clearance(radii, n)[0] for n in (25, 1000))
    assert coarse == pytest.approx(fine, abs=1e-3 * 0.2)  # a thousandth of a rod


def test_a_pressure_beyond_balloon_and_an_equal_tube_say_who_has_no_state() -> None:
    balloon = sl.Tube(0.2, [sl.Layer(0.018, 0.0215, sl.NeoHookean(c1=340 * kPa))])
    limb = sl.Limb([sl.Segment(actuators=[balloon] * 3, ring_radius=0.03)])
    found = limb.solve([95 * kPa, 20 * kPa, 95 * kPa])
    assert found.status == "limit_point" and not found.success
    assert found.message.startswith("actuator 2 has no stable state at 95 kPa: ")
    assert found.rest_lengths[0] == found.rest_lengths[2] == 0.2 < found.rest_lengths[1]


def test_a_cantilever_goes_with_its_last_user_and_not_by_collection() -> None:
    rod = sl.Rod(sl.Section(axial=400.0, shear=130.0, bending=0.08, torsion=0.06, mass_per_length=0.4), 0.25)
    gc.disable()
    try:
        found = rod.cantilever(tip_force=(0.1, 0.0, 0.2), gravity=HANGING)
        assert found.success
        posture = weakref.ref(found.posture)
        del found
        assert posture() is None
    finally:
        gc.enable()


@pytest.mark.parametrize("way", ["plain", "checked", "followed"])
def test_what_is_written_into_the_pressures_of_a_posture_changes_no_derivative(reference: sl.Limb, way: str) -> None:
    start = solved(reference, COMPLEX, gravity=HANGING)
    near = 1.005 * COMPLEX

    def posture() -> sl.Posture:
        if way == "checked":
            return checked(reference, near, gravity=HANGING)
        return solved(reference, near, gravity=HANGING, start=start if way == "followed" else None)

    untouched, written = posture(), posture()
    assert untouched._solved.followed == (way == "followed")
    assert written.pressures is not None
    written.pressures[:] = np.nan
    np.testing.assert_array_equal(written.jacobian, untouched.jacobian)
    np.testing.assert_array_equal(written.derivative("tip").matrix, untouched.derivative("tip").matrix)
