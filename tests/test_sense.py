"""Sensed force: exact and noisy synthetic measurements, what cannot be seen, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import softlimb as sl
from frames import pose, turn
from softlimb import presets
from softlimb.units import kPa
from tube_examples import plain

HANGING = (0.0, 0.0, 9.81)
PRESSURES = np.array([60, 20, 0, 40, 30, 10, 20, 50, 35]) * kPa
WRENCH = np.array([0.15, -0.1, 0.2, 0.004, -0.003, 0.002])
TIP_COVARIANCE = np.diag([1e-4**2] * 3 + [1e-3**2] * 3)  # a tenth of a millimetre, a milliradian
AT = (0.3, 0.55, 0.8, 1.0)
POINT_COVARIANCE = 1e-4**2 * np.eye(3)


@pytest.fixture(scope="module")
def reference() -> sl.Limb:
    return presets.reference_limb()


@pytest.fixture(scope="module")
def loaded(reference: sl.Limb) -> sl.Posture:
    return under(reference, WRENCH)


def under(limb: sl.Limb, wrench: np.ndarray, pressures: Any = PRESSURES, **options: Any) -> sl.Posture:
    found = limb.solve(
        pressures, gravity=HANGING, tip_force=wrench[:3], tip_moment=wrench[3:], tolerance=1e-10, **options
    )
    assert found.success and found.stable
    return found


def of_tip(posture: sl.Posture) -> dict[str, Any]:
    return {"tip_pose": posture.tip, "covariance": TIP_COVARIANCE}


def of_points(posture: sl.Posture, at: Any = AT) -> dict[str, Any]:
    return {"points": posture.centreline(at=at), "at": at, "points_covariance": POINT_COVARIANCE}


def relative_error(found: sl.Sensed, wrench: np.ndarray) -> float:
    """Forces and moments over the largest of each, moments by the limb's length."""
    length = found.posture.limb.length
    size = np.linalg.norm(wrench * [1.0, 1.0, 1.0, *[1.0 / length] * 3])
    return float(np.linalg.norm((found.wrench - wrench) * [1.0, 1.0, 1.0, *[1.0 / length] * 3]) / size)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("measure", [of_tip, of_points, lambda p: of_tip(p) | of_points(p)])
def test_exact_measurements_give_the_wrench_back(reference: sl.Limb, measure: Any, seed: int) -> None:
    rng = np.random.default_rng([6, seed])
    pressures = rng.uniform(5.0, 60.0, 9) * kPa
    wrench = np.concatenate([0.2 * rng.normal(size=3), 0.005 * rng.normal(size=3)])
    truth = under(reference, wrench, pressures)
    found = reference.sense(pressures, **measure(truth), gravity=HANGING)
    assert found.success and found.message == "converged" and len(found.unseen) == 0
    # Asked for: 1e-6. The search ends at 1e-7 standard deviations, of which the wrench is hundreds.
    assert relative_error(found, wrench) < 1e-6
    assert found.chi_square < 1e-8 and found.posture.stable
    assert_allclose(found.posture.tip, truth.tip, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("frame", ["base", "plate"])
def test_known_loads_and_following_ones_are_beside_what_is_sensed(reference: sl.Limb, frame: Any) -> None:
    known = np.array([0.1, 0.0, -0.05])
    truth = under(reference, WRENCH + np.pad(known, (0, 3)), frame=frame)
    for measure in (of_tip, of_points):
        found = reference.sense(PRESSURES, **measure(truth), gravity=HANGING, tip_force=known, frame=frame)
        assert found.success and relative_error(found, WRENCH) < 1e-6


def test_rods_and_a_force_alone() -> None:
    section = sl.Section(axial=900.0, shear=300.0, bending=0.02, torsion=0.015, mass_per_length=0.1)
    limb = sl.Limb([sl.Segment(rods=[sl.Rod(section, 0.3)] * 3, ring_radius=0.02)])
    force = np.array([0.3, 0.1, -0.2])
    truth = limb.solve(tip_force=force, tolerance=1e-10)
    found = limb.sense(points=truth.centreline(at=[1.0]), at=[1.0], points_covariance=POINT_COVARIANCE, unknown="force")
    assert found.success and found.singular_values.shape == (3,)
    assert_allclose(found.force, force, rtol=0.0, atol=1e-6 * np.linalg.norm(force))
    assert not found.moment.any() and not found.covariance[3:].any()
    assert found.degrees_of_freedom == 0


@pytest.mark.parametrize("measure", ["tip", "points"])
def test_noise_moves_the_wrench_by_its_covariance(reference: sl.Limb, loaded: sl.Posture, measure: str) -> None:
    # 60 draws, seeded. (found - true)^T covariance^-1 (found - true) has a chi-square of 6 degrees, so the sum has a
    # mean of 360 and a standard deviation of sqrt(720) = 27: five of these, and as much in each direction
    # (60 +- 5 sqrt(120)).
    rng = np.random.default_rng(6)
    draws, squares, parts, fits = 60, 0.0, np.zeros(6), 0.0
    for _ in range(draws):
        if measure == "tip":
            noise = np.linalg.cholesky(TIP_COVARIANCE) @ rng.normal(size=6)
            seen = pose(loaded.tip[:3, 3] + noise[:3], turn(noise[3:]) @ loaded.tip[:3, :3])
            given = {"tip_pose": seen, "covariance": TIP_COVARIANCE}
        else:
            given = of_points(loaded)
            given["points"] = given["points"] + 1e-4 * rng.normal(size=(len(AT), 3))
        found = reference.sense(PRESSURES, **given, gravity=HANGING, tolerance=1e-8)
        assert found.success and len(found.unseen) == 0
        values, axes = np.linalg.eigh(found.covariance * np.outer(*[1.0 / found.standard_deviations] * 2))
        shares = axes.T @ ((found.wrench - WRENCH) / found.standard_deviations) / np.sqrt(values)
        squares += shares @ shares
        parts += shares**2
        fits += found.chi_square
    assert abs(squares - 6 * draws) < 5 * np.sqrt(2 * 6 * draws)
    assert (np.abs(parts - draws) < 5 * np.sqrt(2 * draws)).all()
    # What is left of the measurement has the other degrees: none of a pose, six of four points.
    degrees = found.degrees_of_freedom
    assert degrees == (0 if measure == "tip" else 6)
    if measure == "points":
        assert abs(fits - degrees * draws) < 5 * np.sqrt(2 * degrees * draws)
    else:
        assert fits < 1e-6


def test_a_point_near_the_base_sees_few_directions(reference: sl.Limb, loaded: sl.Posture) -> None:
    at = (0.1,)
    found = reference.sense(PRESSURES, **of_points(loaded, at), gravity=HANGING)
    # Three numbers see three directions at most; the others are named.
    assert found.success and len(found.unseen) == 3 and "not seen: " in found.message
    scale = np.array([1.0] * 3 + [reference.length] * 3)
    assert_allclose((found.unseen / scale) @ (found.unseen / scale).T, np.eye(3), rtol=0.0, atol=1e-12)
    # A wrench along one of them is not noticed: less than a standard deviation for the largest force.
    small = 1e-3
    for direction in found.unseen:
        moved = under(reference, found.wrench + small * found.largest_force * direction)
        shift = (moved.centreline(at=at) - found.posture.centreline(at=at)) / 1e-4
        assert np.linalg.norm(shift) < 2.0 * small  # to first order, and the posture's own digits
    # The covariance speaks of the seen ones alone.
    assert np.linalg.matrix_rank(found.covariance / np.outer(scale, scale), tol=1e-12, hermitian=True) == 3
    far = reference.sense(PRESSURES, **of_points(loaded, (0.0,)), gravity=HANGING)
    assert far.success and len(far.unseen) == 6 and not far.wrench.any()  # the base does not move


def test_what_counts_as_seen_depends_on_the_largest_force(reference: sl.Limb, loaded: sl.Posture) -> None:
    rough = {"tip_pose": loaded.tip, "covariance": 1e4 * TIP_COVARIANCE}
    large = reference.sense(PRESSURES, **rough, gravity=HANGING, largest_force=100.0)
    small = reference.sense(PRESSURES, **rough, gravity=HANGING, largest_force=0.05)
    assert len(large.unseen) < len(small.unseen) and (small.singular_values >= 1.0).sum() == 6 - len(small.unseen)
    # Along what both see they agree to first order about the uncertainty.
    assert small.standard_deviations[0] <= large.standard_deviations[0]


def test_a_measurement_that_no_wrench_explains_has_a_large_chi_square(reference: sl.Limb, loaded: sl.Posture) -> None:
    given = of_points(loaded)
    given["points"][1, 0] += 0.01  # a hundred standard deviations
    found = reference.sense(PRESSURES, **given, gravity=HANGING)
    assert found.success and found.chi_square > 1000.0
    assert found.residual.shape == (12,)
    sound = reference.sense(PRESSURES, **of_points(loaded), gravity=HANGING)
    assert_allclose(found.residual - (given["points"] - found.posture.centreline(at=AT)).ravel(), 0.0, atol=1e-15)
    assert np.linalg.norm(found.residual) > 100.0 * np.linalg.norm(sound.residual)


def test_a_limb_without_a_stable_posture_is_no_exception() -> None:
    limb = sl.Limb([sl.Segment([plain()], ring_radius=0.0)])
    found = limb.sense([200 * kPa], tip_pose=pose((0.0, 0.0, 0.3)), covariance=TIP_COVARIANCE)  # balloons at 90 kPa
    assert not found.success and found.status == "limit_point" and "no stable posture" in found.message
    assert np.isnan(found.wrench).all() and np.isnan(found.chi_square)


@pytest.mark.parametrize("wrong", ["turned", "far", "point"])
def test_a_measurement_that_no_stable_limb_gives_is_given_up(
    reference: sl.Limb, wrong: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    effort = 0
    solve = sl.Limb.solve

    def counted(limb: sl.Limb, *args: Any, **options: Any) -> sl.Posture:
        nonlocal effort
        found = solve(limb, *args, **options)
        effort += found.iterations
        return found

    monkeypatch.setattr(sl.Limb, "solve", counted)
    seen, pressures = pose((100.0, 0.0, 0.7)), PRESSURES
    if wrong == "turned":
        pressures = np.array([60, 20, 0, 0, 30, 30, 10, 20, 30]) * kPa
        seen = reference.solve(pressures, gravity=HANGING, tip_force=(0.2, 0.0, 0.0)).tip
        seen = seen @ np.diag([1.0, -1.0, -1.0, 1.0])
    given: dict[str, Any] = {"tip_pose": seen, "covariance": TIP_COVARIANCE}
    if wrong == "point":
        given = {"points": seen[:3, 3:].T, "at": [1.0], "points_covariance": POINT_COVARIANCE}
    found = reference.sense(pressures, **given, gravity=HANGING)
    assert not found.success and found.posture.success and found.posture.stable
    assert ("mm from where they" if wrong == "point" else "deg from its measured pose") in found.message
    # The limit is 1500; what was begun below it ends, and one posture takes two thousand at most.
    assert effort < 3500


def test_a_wrench_found_by_holding_the_tip_counts_as_a_step(reference: sl.Limb) -> None:
    wrench = np.array([0.0, 0.0, 20.0, 0.0, 0.0, 0.0])
    truth = under(reference, wrench)
    found = reference.sense(PRESSURES, **of_tip(truth), gravity=HANGING)
    assert found.success and relative_error(found, wrench) < 1e-6 and found.iterations >= 1


SOUND: dict[str, Any] = {"tip_pose": np.eye(4), "covariance": np.eye(6)}
REFUSED: list[tuple[dict[str, Any], type[Exception], str]] = [
    ({}, ValueError, "nothing was measured"),
    ({"tip_pose": np.eye(4)}, ValueError, "tip_pose and covariance belong together"),
    ({"points": [[0, 0, 0]], "at": [1.0]}, ValueError, "points and points_covariance belong together"),
    ({"points": [[0, 0, 0]], "points_covariance": np.eye(3)}, ValueError, "points and at belong together"),
    ({"tip_pose": 2.0 * np.eye(4), "covariance": np.eye(6)}, ValueError, "block of tip_pose must be a rotation matrix"),
    ({"tip_pose": np.full((4, 4), np.nan), "covariance": np.eye(6)}, ValueError, "tip_pose must be finite"),
    ({"tip_pose": np.eye(3), "covariance": np.eye(6)}, ValueError, r"tip_pose has shape \(3, 3\): expected \(4, 4\)"),
    ({"tip_pose": np.eye(4), "covariance": np.eye(3)}, ValueError, r"covariance has shape \(3, 3\): expected \(6, 6\)"),
    ({"tip_pose": np.eye(4), "covariance": np.full((6, 6), np.nan)}, ValueError, "covariance must be finite"),
    ({"tip_pose": np.eye(4), "covariance": np.triu(np.ones((6, 6)))}, ValueError, "covariance must be symmetric"),
    ({"tip_pose": np.eye(4), "covariance": -np.eye(6)}, ValueError, "covariance must be positive definite"),
    ({"tip_pose": np.eye(4), "covariance": np.ones((6, 6))}, ValueError, "covariance must be positive definite"),
    ({"tip_pose": np.eye(4), "covariance": np.zeros((6, 6))}, ValueError, "covariance must be positive definite"),
    (
        {"points": [[0, 0, 0]], "at": [1.5], "points_covariance": np.eye(3)},
        ValueError,
        r"at must be shares of the centreline, within 0 and 1, got \[1.5\]",
    ),
    (
        {"points": [[0, 0, 0]], "at": [0.2, 0.4], "points_covariance": np.eye(3)},
        ValueError,
        r"points has shape \(1, 3\): expected \(2, 3\)",
    ),
    (
        {"points": [[0, 0, np.inf]], "at": [0.2], "points_covariance": np.eye(3)},
        ValueError,
        "points must be finite",
    ),
    (
        {"points": [[0, 0, 0]], "at": [0.2], "points_covariance": np.eye(2)},
        ValueError,
        r"points_covariance has shape \(2, 2\): expected \(3, 3\)",
    ),
    (
        {"points": [[0, 0, 0]], "at": [0.2], "points_covariance": [np.diag([1.0, 1.0, -1.0])]},
        ValueError,
        r"points_covariance\[0\] must be positive definite",
    ),
    ({**SOUND, "largest_force": 0.0}, ValueError, "largest_force must be finite"),
    ({**SOUND, "unknown": "moment"}, ValueError, "unknown must be one of"),
    ({**SOUND, "prefer_stable": False}, TypeError, "prefer_stable does not apply"),
    ({**SOUND, "foo": 1}, TypeError, r"'foo' is no load where a force is sensed: expected one of (?!.*(held|prefer))"),
    ({**SOUND, "gravity": (0, 0)}, ValueError, "gravity has shape"),
]


@pytest.mark.parametrize(("given", "error", "message"), REFUSED)
def test_what_is_wrong_is_named(
    reference: sl.Limb, given: dict[str, Any], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        reference.sense(PRESSURES, **given)
