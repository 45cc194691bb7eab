"""Paths through folds, and payloads: closed forms, symmetry, and folds found by another method."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

import softlimb as sl
from softlimb.units import kPa, mm

Array = NDArray[np.float64]

DOWN = (0.0, 0.0, -9.81)


def tower() -> sl.Limb:
    """Four distal tubes of the reference limb on a narrow rectangle: soft to one side, stiff to the other."""
    tube = sl.presets.reference_limb().segments[2].actuators[0]
    frames = np.tile(np.eye(4), (4, 1, 1))
    frames[:, 0, 3] = np.array([1, 1, -1, -1]) * 30 * mm
    frames[:, 1, 3] = np.array([1, -1, 1, -1]) * 12 * mm
    plate = sl.Plate(thickness=10 * mm, mass=0.02)
    return sl.Limb([sl.Segment(actuators=[tube] * 4, base_frames=frames, end_frames=frames, plate=plate)])


def leaning(difference: float) -> Array:
    """40 kPa in the mean, more on one of the long sides."""
    return 40 * kPa + 0.5 * difference * np.array([1.0, -1.0, 1.0, -1.0])


def column(axial: float = 1e5) -> sl.Limb:
    section = sl.Section(axial=axial, shear=axial, bending=1.0, torsion=0.8, mass_per_length=1.0)
    return sl.Limb([sl.Segment(rods=[sl.Rod(section, 1.0)], ring_radius=0.0)])


def down(force: float) -> dict[str, Any]:
    return {"tip_force": (0.0, 0.0, -force)}


@pytest.fixture(scope="module")
def snap() -> sl.Path:
    """The tower leans a little and is loaded until it collapses."""
    return tower().follow(down, 0.0, 1.0, pressures=leaning(1 * kPa), gravity=DOWN)


def test_a_straight_column_meets_eulers_load_as_a_bifurcation() -> None:
    path = column().follow(down, 0.0, 4.0)
    assert path.success and not path.folds
    # Equal axial and shear stiffness leave the critical load as it is: P (1 - P/EA + P/GA) = pi^2 EI/(4 l^2). The count
    # of modes changes within 1e-9 of the bending stiffness of there.
    assert [event.parameter for event in path.bifurcations] == [pytest.approx(0.25 * np.pi**2, rel=1e-7)]
    assert path.stable[0] and not path.stable[-1]


def test_a_heavy_column_meets_greenhills_weight() -> None:
    path = column().follow(lambda weight: {"gravity": (0.0, 0.0, -weight)}, 0.0, 12.0)
    # (9/4) j^2 with j = 1.86635 the first zero of J_(-1/3): 7.83735.
    from scipy.optimize import brentq
    from scipy.special import jv

    zero = brentq(lambda x: jv(-1.0 / 3.0, x), 1.5, 2.2, xtol=1e-15)
    assert [event.parameter for event in path.bifurcations] == [pytest.approx(2.25 * zero**2, rel=1e-7)]


def test_a_parallel_segment_snaps_and_keeps_two_stable_postures(snap: sl.Path) -> None:
    first, second = snap.folds
    assert snap.end == "stop" and not snap.bifurcations
    assert second.parameter < first.parameter
    middle = 0.5 * (first.parameter + second.parameter)
    upright, ridge, collapsed = snap.at(middle)
    assert upright.stable and collapsed.stable
    assert ridge.unstable_modes == 1
    assert upright.tip[2, 3] > ridge.tip[2, 3] > collapsed.tip[2, 3]
    for posture in (upright, ridge, collapsed):
        assert posture.verify().success
    assert len(snap.at(0.5 * second.parameter)) == 1


def test_between_folds_the_path_is_unstable_and_outside_it_is_stable(snap: sl.Path) -> None:
    first, second = (fold.after for fold in snap.folds)
    expected = np.ones(len(snap), dtype=bool)
    expected[first + 1 : second + 1] = False
    assert np.array_equal(snap.stable, expected)


def test_every_point_of_a_path_is_what_solve_finds_there(snap: sl.Path) -> None:
    limb = tower()
    for posture, force in zip(snap.postures[::7], snap.parameters[::7], strict=True):
        again = limb.solve(leaning(1 * kPa), gravity=DOWN, **down(force), start=posture, prefer_stable=False)
        # Both are within 1e-6 of the limb's length of the same equilibrium.
        assert_allclose(again.tip, posture.tip, rtol=0.0, atol=4e-7)


def test_a_fold_is_where_the_reaction_of_a_moved_tip_is_largest(snap: sl.Path) -> None:
    # The tip held at a height carries what the load was, and as a function of the height it has no fold: its largest
    # value is the fold's load. Value of a maximum: second order in where it is sought.
    limb = tower()
    options: dict[str, Any] = {"gravity": DOWN, "tip_held": [False, False, True, False, False, False]}

    def carried(height: float, start: sl.Posture) -> float:
        pose = start.tip.copy()
        pose[2, 3] = height
        found = limb.solve(leaning(1 * kPa), tip_pose=pose, start=start, tolerance=1e-11, **options)
        assert found.success
        return -float(found.tip_reaction[2])

    for fold, sign in zip(snap.folds, (1.0, -1.0), strict=True):
        centre, step = float(fold.posture.tip[2, 3]), 2e-5
        left, middle, right = (sign * carried(centre + k * step, fold.posture) for k in (-1, 0, 1))
        # The parabola through three points 20 micrometres apart, on a curve whose load changes by 1e-6 N between them:
        # its top errs by a thousandth of that.
        top = middle + (right - left) ** 2 / (8.0 * (2.0 * middle - left - right))
        assert fold.parameter == pytest.approx(sign * top, abs=1e-8)


@pytest.mark.parametrize("largest_step", [0.03, 0.3])
def test_a_fold_does_not_depend_on_the_steps(snap: sl.Path, largest_step: float) -> None:
    path = tower().follow(down, 0.0, 1.0, pressures=leaning(1 * kPa), gravity=DOWN, largest_step=largest_step)
    # Located to 1e-8 of the range, which is 1 N here.
    assert_allclose([e.parameter for e in path.folds], [e.parameter for e in snap.folds], rtol=0.0, atol=1e-8)


def test_a_mirrored_path_has_the_mirrored_postures(snap: sl.Path) -> None:
    mirrored = tower().follow(down, 0.0, 1.0, pressures=leaning(-1 * kPa), gravity=DOWN)
    assert_allclose([e.parameter for e in mirrored.folds], [e.parameter for e in snap.folds], rtol=0.0, atol=1e-8)
    here, there = snap.at(0.9)[0], mirrored.at(0.9)[0]
    assert_allclose(there.tip[:3, 3] * [1.0, -1.0, 1.0], here.tip[:3, 3], rtol=0.0, atol=4e-7)


def test_a_path_in_pressure_turns_where_no_posture_is_near() -> None:
    # Upright under a load, the pressure difference grows: past the fold the tower collapses, and the path comes back.
    limb = tower()
    upright = limb.follow(down, 0.0, 0.4, pressures=leaning(1 * kPa), gravity=DOWN).postures[-1]

    def at(difference: float) -> dict[str, Any]:
        return {"pressures": leaning(difference)}

    path = limb.follow(at, 1 * kPa, 30 * kPa, posture=upright, gravity=DOWN, **down(0.4))
    assert path.end == "start" and len(path.folds) == 1
    assert path.postures[0].stable and not path.postures[-1].stable
    # The same fold from the other side: this difference, followed in the load, folds at this load.
    other = limb.follow(down, 0.0, 0.5, pressures=leaning(path.folds[0].parameter), gravity=DOWN, through_events=False)
    assert other.end == "event" and other.folds[0].parameter == pytest.approx(0.4, abs=1e-7)


def test_a_moved_hold_is_followed_as_a_parameter() -> None:
    # A column shortened by its plate, kept upright there: its force is nothing but the shortening times EA.
    limb = column(axial=100.0)

    def shortened(by: float) -> dict[str, Any]:
        pose = np.eye(4)
        pose[2, 3] = 1.0 - by
        return {"tip_pose": pose}

    path = limb.follow(shortened, 0.0, 0.2)
    assert path.success
    assert_allclose([p.tip_reaction[2] for p in path.postures], -100.0 * path.parameters, rtol=1e-9, atol=1e-9)


def test_a_path_backwards_is_the_same_path() -> None:
    limb = tower()
    forth = limb.follow(down, 0.0, 0.3, pressures=leaning(5 * kPa), gravity=DOWN, through_events=False)
    back = limb.follow(down, 0.3, 0.0, pressures=leaning(5 * kPa), gravity=DOWN, posture=forth.postures[-1])
    assert back.end == "stop"
    assert_allclose(back.postures[-1].tip, forth.postures[0].tip, rtol=0.0, atol=4e-7)


def test_a_path_ends_where_a_tube_has_no_state() -> None:
    # Without fibres this tube balloons near 22.9 kPa.
    tube = sl.Tube(length=0.2, layers=[sl.Layer(18 * mm, 21.5 * mm, sl.NeoHookean(c1=86100.0))])
    limb = sl.Limb([sl.Segment(actuators=[tube] * 3, ring_radius=0.03)])
    path = limb.follow(lambda pressure: {"pressures": [pressure] * 3}, 5 * kPa, 60 * kPa)
    assert path.end == "no_scene" and not path.success
    assert 22 * kPa < path.parameters[-1] < 23 * kPa
    assert "no stable state" in path.message


def test_a_first_posture_that_is_no_equilibrium_gives_an_empty_path() -> None:
    path = column().follow(lambda moment: {"tip_moment": (0.0, moment, 0.0)}, 1e6, 2e6)
    assert len(path) == 0 and not path.success and path.postures == () and "no equilibrium" in path.message
    assert column().solve(tip_moment=(0.0, 1e6, 0.0)).message in path.message


def test_a_path_pickles_as_its_points_and_events(snap: sl.Path) -> None:
    again = pickle.loads(pickle.dumps(snap))
    for name in ("parameters", "arclengths", "tips", "stable"):
        assert_array_equal(getattr(again, name), getattr(snap, name))
    assert again.end == snap.end and again.message == snap.message
    assert [(e.kind, e.parameter, e.after) for e in again.events] == [
        (e.kind, e.parameter, e.after) for e in snap.events
    ]
    assert_array_equal(again.folds[0].posture.plates, snap.folds[0].posture.plates)
    with pytest.raises(RuntimeError, match="follow it again"):
        again.at(0.5 * float(snap.parameters[0] + snap.parameters[1]))


def test_a_cold_start_that_meets_a_ridge_names_the_posture_beyond() -> None:
    # The straight tower is the ridge between two mirrored collapses.
    found = tower().solve(leaning(0.0), gravity=DOWN, **down(0.9))
    assert found.stable
    assert "another stable posture exists" in found.message
    away = float(found.message.split("its tip ")[1].split(" mm")[0])
    # Three digits are written.
    assert away == pytest.approx(2.0 * abs(found.tip[1, 3]) / mm, rel=1e-2)


@pytest.mark.parametrize("beyond", [1e-9, 1e-6, 1e-4])
def test_a_cold_start_just_past_a_fold_finds_the_posture_that_is_left(snap: sl.Path, beyond: float) -> None:
    # The mesh of the descent still has the minimum that the exact rods have lost.
    force = snap.folds[0].parameter + beyond
    found = tower().solve(leaning(1 * kPa), gravity=DOWN, **down(force))
    assert found.success and found.stable and found.verify().success
    assert found.tip[2, 3] < snap.folds[1].posture.tip[2, 3]


def test_two_postures_beside_a_fold_are_both_on_the_path(snap: sl.Path) -> None:
    upright, ridge, _ = snap.at(snap.folds[0].parameter - 1e-4)
    assert upright.stable and ridge.unstable_modes == 1


def test_a_posture_at_a_fold_counts_as_unstable(snap: sl.Path) -> None:
    assert [fold.posture.stable for fold in snap.folds] == [False, False]


def test_a_pitchfork_met_on_its_bent_branch_is_no_fold() -> None:
    even = np.full(4, 40 * kPa)
    straight = tower().follow(down, 0.0, 1.0, pressures=even, gravity=DOWN)
    bent = tower().follow(down, 1.0, 0.0, pressures=even, gravity=DOWN)
    assert [event.kind for event in bent.events] == ["fold", "bifurcation", "fold"]
    assert bent.bifurcations[0].parameter == pytest.approx(straight.bifurcations[0].parameter, abs=1e-7)


# --- payload -----------------------------------------------------------------------------------------------------


def test_the_payload_of_a_column_is_eulers_load() -> None:
    found = column().payload((0.0, 0.0, -3.0))
    assert found.limit == "bifurcation" and found.force == pytest.approx(0.25 * np.pi**2, rel=1e-7)


def test_the_payload_before_a_fold_is_the_folds_load(snap: sl.Path) -> None:
    found = tower().payload((0.0, 0.0, -1.0), pressures=leaning(1 * kPa), gravity=DOWN, max_force=2.0)
    assert found.limit == "fold" and "snaps" in found.message
    assert found.force == pytest.approx(snap.folds[0].parameter, abs=1e-8)


def test_a_small_deflection_is_reached_at_three_ei_over_length_cubed() -> None:
    found = column().payload((1.0, 0.0, 0.0), max_deflection=1e-4, tolerance=1e-10)
    # l^3/(3 EI) and the shear's l/GA; linear theory errs by the square of the deflection over the length.
    assert found.limit == "deflection" and found.force == pytest.approx(1e-4 / (1.0 / 3.0 + 1e-5), rel=1e-7)
    assert found.deflection == pytest.approx(1e-4, rel=1e-7)


def test_a_deflection_beyond_the_fold_leaves_the_fold_as_the_limit() -> None:
    found = tower().payload(
        (0.0, 0.0, -1.0), pressures=leaning(1 * kPa), gravity=DOWN, max_force=2.0, max_deflection=0.3
    )
    assert found.limit == "fold"


def test_pressures_hold_the_tip_in_place_up_to_their_limit() -> None:
    limb = sl.presets.reference_limb()
    pressures = np.array([60, 40, 40, 40, 30, 30, 30, 30, 30]) * kPa
    found = limb.payload((0.0, 0.0, 1.0), pressures=pressures, gravity=(0.0, 0.0, 9.81), max_pressure=80 * kPa)
    still = limb.payload((0.0, 0.0, 1.0), pressures=pressures, gravity=(0.0, 0.0, 9.81), max_deflection=1e-3)
    assert found.limit == "pressure" and found.force > still.force
    # Held to ten times the tolerance of 1e-6 of 0.65 m.
    assert found.deflection < 1e-5
    assert found.posture.stable and found.posture.verify().success
    held = found.posture.pressures
    assert held is not None and (held >= 0.0).all() and (held <= 80 * kPa).all()
    assert (np.isclose(held, 80 * kPa) | np.isclose(held, 0.0)).any()
    # Near the limit of stability the count belongs to the posture itself, not to the step before it.
    assert found.posture.smallest_stiffness > 0.0


def test_a_limb_that_carries_all_that_was_asked_says_so() -> None:
    found = column().payload((0.0, 0.0, 1.0), max_force=5.0)
    assert found.limit == "force" and found.force == 5.0 and found.posture.stable


# --- bad input ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "error", "name"),
    [
        ({"arguments": {"tip_force": 1}}, TypeError, "callable"),
        ({"arguments": lambda t: 3.0}, TypeError, "mapping"),
        ({"arguments": lambda t: {"tip_forse": (0, 0, t)}}, TypeError, "tip_forse"),
        ({"arguments": lambda t: {"tolerance": t}}, TypeError, "tolerance"),
        ({"arguments": lambda t: {"tip_force": (0, 0, np.nan)}}, ValueError, "tip_force"),
        ({"gravity": (0, 0, 1), "arguments": lambda t: {"gravity": (0, 0, t)}}, TypeError, "gravity"),
        ({"start": np.nan}, ValueError, "start"),
        ({"stop": 0.0}, ValueError, "differ"),
        ({"stop": "1"}, ValueError, "stop"),
        ({"largest_step": 0.0}, ValueError, "largest_step"),
        ({"max_points": 1}, ValueError, "max_points"),
        ({"max_points": 2.5}, ValueError, "max_points"),
        ({"posture": np.eye(4)}, TypeError, "posture"),
        ({"tolerance": 1.0}, ValueError, "tolerance"),
    ],
)
def test_a_bad_argument_of_follow_is_refused_by_name(change: dict[str, Any], error: Any, name: str) -> None:
    given: dict[str, Any] = {"arguments": down, "start": 0.0, "stop": 1.0, **change}
    with pytest.raises(error, match=name):
        column().follow(given.pop("arguments"), given.pop("start"), given.pop("stop"), **given)


@pytest.mark.parametrize(
    ("change", "error", "name"),
    [
        ({"direction": (0, 0, 0)}, ValueError, "direction"),
        ({"direction": (0, 0)}, ValueError, "direction"),
        ({"max_force": -1.0}, ValueError, "max_force"),
        ({"max_deflection": 0.0}, ValueError, "max_deflection"),
        ({"max_deflection": 1.0, "max_pressure": 1.0}, ValueError, "both"),
        ({"max_pressure": 1e5}, ValueError, "max_pressure"),
        ({"start": None}, TypeError, "start"),
    ],
)
def test_a_bad_argument_of_payload_is_refused_by_name(change: dict[str, Any], error: Any, name: str) -> None:
    given: dict[str, Any] = {"direction": (0.0, 0.0, 1.0), **change}
    with pytest.raises(error, match=name):
        column().payload(given.pop("direction"), **given)


def test_a_path_refuses_a_value_that_is_no_number(snap: sl.Path) -> None:
    with pytest.raises(ValueError, match="parameter"):
        snap.at(np.nan)
