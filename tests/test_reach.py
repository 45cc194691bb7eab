"""Pressures for a target: closed forms, symmetry, what must hold at a least effort and at a nearest posture."""

from __future__ import annotations

import pickle
import signal
import threading
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

import softlimb as sl
from frames import pose, turn
from softlimb import presets
from softlimb.paper_reach import PaperReach
from softlimb.reach import ReachError
from softlimb.units import deg, kPa, mm

Array = NDArray[np.float64]

HANGING: dict[str, Any] = {"gravity": (0.0, 0.0, 9.81), "tip_force": (0.2, 0.0, 0.0)}
HIGHEST = 80 * kPa


@pytest.fixture(scope="module")
def limb() -> sl.Limb:
    return presets.reference_limb()


def random_postures(limb: sl.Limb, count: int, seed: int) -> list[sl.Posture]:
    rng = np.random.default_rng(seed)
    found = [limb.solve(rng.uniform(0.0, HIGHEST, 9), **HANGING) for _ in range(count)]
    assert all(posture.success and posture.stable for posture in found)
    return found


def require_reached(found: sl.Reach, limb: sl.Limb, tolerance: float = 1e-6) -> None:
    """What the answer says of itself holds for a solve of its own, from its pressures alone, and for its checks."""
    assert found.reached and found.success and found.status == "converged", found.message
    assert found.posture.success and found.posture.stable and found.posture.verify().success
    again = limb.solve(found.pressures, start=found.posture, tolerance=1e-9, **HANGING)
    miss = again.tip[:3, 3] - found.target[:3, 3]
    # A tenth for the posture's own error, which is asked to be that small.
    assert np.linalg.norm(miss) <= 1.1 * tolerance * limb.length
    assert (found.pressures >= found.min_pressures).all() and (found.pressures <= found.max_pressures).all()


@pytest.mark.parametrize("kind", ["position", "pose"])
def test_tips_of_random_pressures_are_reached_from_nothing_with_no_more_effort(limb: sl.Limb, kind: str) -> None:
    for posture in random_postures(limb, 12, 11):
        target = posture.tip[:3, 3] if kind == "position" else posture.tip
        found = limb.reach(**{kind: target}, max_pressure=HIGHEST, **HANGING)
        require_reached(found, limb)
        if kind == "pose":
            assert found.error.rotation is not None and found.error.rotation <= 1e-6
        assert found.least and posture.pressures is not None
        assert np.sum(found.pressures**2) <= np.sum(posture.pressures**2) * (1 + 1e-6)


def test_the_effort_cannot_fall_along_pressures_that_keep_the_tip(limb: sl.Limb) -> None:
    for posture in random_postures(limb, 6, 12):
        found = limb.reach(position=posture.tip[:3, 3], max_pressure=HIGHEST, **HANGING)
        p, rows = found.pressures / HIGHEST, found.posture.jacobian[:3] * HIGHEST
        free = np.array([number not in found.active for number in range(9)])
        price = np.linalg.lstsq(rows[:, free].T, p[free], rcond=None)[0]
        rest = p - rows.T @ price
        # A search from nothing ends when its last step is below 1e-4 of the bounds, and takes that step; the curvature
        # is of order one, up to twenty where the target's price is high.
        assert_allclose(rest[free], 0.0, atol=2e-3)
        for number, bound in found.active.items():
            assert rest[number] > -2e-3 if bound == "min" else rest[number] < 2e-3


def test_a_straight_segment_reaches_a_height_with_equal_pressures_of_its_tubes() -> None:
    segment = presets.reference_limb(["middle"]).segments[0]
    one = sl.Limb([segment])
    found = one.reach(position=(0.0, 0.0, 0.23), max_pressure=HIGHEST)
    assert found.reached
    expected = segment.actuators[0].pressure_for(0.23 / 0.2)
    # Height to 1e-6 of 0.2 m, over the slope of about 0.9 m/MPa; the preference to 1e-3 of 80 kPa at the very worst.
    assert_allclose(found.pressures, expected, rtol=0.0, atol=1.0)


def test_turning_the_target_by_a_third_passes_the_pressures_round(limb: sl.Limb) -> None:
    target = np.array([0.12, 0.05, 0.75])
    weight = {"gravity": (0.0, 0.0, 9.81)}
    first = limb.reach(position=target, max_pressure=HIGHEST, **weight)
    turned = limb.reach(position=turn((0.0, 0.0, 2.0 * np.pi / 3.0)) @ target, max_pressure=HIGHEST, **weight)
    assert first.reached and turned.reached
    passed = np.roll(first.pressures.reshape(3, 3), 1, axis=1).ravel()
    assert_allclose(turned.pressures, passed, rtol=0.0, atol=2e-3 * HIGHEST)  # as for the preference above


def test_preferred_pressures_that_reach_are_the_answer(limb: sl.Limb) -> None:
    (posture,) = random_postures(limb, 1, 13)
    for prefer in (posture, posture.pressures):
        found = limb.reach(position=posture.tip[:3, 3], prefer=prefer, max_pressure=HIGHEST, **HANGING)
        require_reached(found, limb)
        assert posture.pressures is not None
        assert_allclose(found.pressures, posture.pressures, rtol=0.0, atol=1e-3 * HIGHEST)
    lazy = limb.reach(position=posture.tip[:3, 3], max_pressure=HIGHEST, **HANGING)
    assert np.sum(lazy.pressures**2) < np.sum(found.pressures**2)


def test_a_pose_whose_rotation_has_no_weight_is_a_position(limb: sl.Limb) -> None:
    (posture,) = random_postures(limb, 1, 14)
    wanted = pose(posture.tip[:3, 3], turn((0.3, 0.0, 0.0)))
    as_pose = limb.reach(pose=wanted, weights=(1, 1, 1, 0, 0, 0), max_pressure=HIGHEST, **HANGING)
    as_position = limb.reach(position=wanted[:3, 3], max_pressure=HIGHEST, **HANGING)
    require_reached(as_pose, limb)
    assert as_pose.error.rotation is None
    assert_allclose(as_pose.pressures, as_position.pressures, rtol=0.0, atol=1e-3 * HIGHEST)


def test_no_small_change_of_the_pressures_comes_nearer_to_a_target_out_of_reach(limb: sl.Limb) -> None:
    rng = np.random.default_rng(15)
    for target in ((0.6, 0.0, 0.7), (0.1, -0.1, 1.2), (-0.2, 0.3, 1.0)):
        found = limb.reach(position=target, max_pressure=HIGHEST, **HANGING)
        assert not found.reached and not found.success and found.status == "no_progress", found.message
        assert "out of reach" in found.message and found.active
        assert found.posture.success and found.posture.stable
        miss = found.error.position
        assert miss == pytest.approx(np.linalg.norm(found.posture.tip[:3, 3] - target), rel=1e-12)
        for _ in range(20):
            other = np.clip(found.pressures + 2 * kPa * rng.normal(size=9), 0.0, HIGHEST)
            beside = limb.solve(other, start=found.posture, **HANGING)
            # The miss is the least one to 1e-8 of itself; postures are exact to 1e-6 of the length.
            assert np.linalg.norm(beside.tip[:3, 3] - target) > miss - 1e-6


def test_the_farthest_that_a_hanging_limb_gets_is_all_pressures_at_their_bound(limb: sl.Limb) -> None:
    found = limb.reach(position=(0.0, 0.0, 2.0), max_pressure=50 * kPa, gravity=(0.0, 0.0, 9.81))
    straight = limb.solve([50 * kPa] * 9, gravity=(0.0, 0.0, 9.81))
    assert found.active == dict.fromkeys(range(9), "max")
    assert found.error.position == pytest.approx(2.0 - straight.tip[2, 3], abs=1e-6 * limb.length)
    assert found.error.relative == pytest.approx(found.error.position / limb.length)


def test_bounds_of_each_actuator_hold_and_a_fixed_one_stays(limb: sl.Limb) -> None:
    (posture,) = random_postures(limb, 1, 16)
    assert posture.pressures is not None
    low, high = np.full(9, 5 * kPa), np.full(9, 90 * kPa)
    low[4] = high[4] = posture.pressures[4]
    found = limb.reach(position=posture.tip[:3, 3], min_pressure=low, max_pressure=high.reshape(3, 3), **HANGING)
    require_reached(found, limb)
    assert found.pressures[4] == posture.pressures[4]


def test_nothing_may_move_and_the_answer_is_the_posture_that_there_is(limb: sl.Limb) -> None:
    there = limb.solve([20 * kPa] * 9, **HANGING)
    bounds = {"min_pressure": 20 * kPa, "max_pressure": 20 * kPa}
    found = limb.reach(pose=there.tip, **bounds, **HANGING)
    assert found.reached and (found.pressures == 20 * kPa).all()
    elsewhere = limb.reach(position=there.tip[:3, 3] + [0.0, 0.0, 10 * mm], **bounds, **HANGING)
    assert not elsewhere.reached and elsewhere.error.position == pytest.approx(10 * mm, abs=1e-6)


def test_a_path_of_targets_is_followed_from_answer_to_answer(limb: sl.Limb) -> None:
    found = limb.reach(position=(0.15, 0.0, 0.72), max_pressure=HIGHEST, **HANGING)
    for angle in np.linspace(0.0, 60 * deg, 21)[1:]:
        target = (0.15 * np.cos(angle), 0.15 * np.sin(angle), 0.72)
        before, found = found, limb.reach(position=target, max_pressure=HIGHEST, start=found, **HANGING)
        require_reached(found, limb)
        assert found.starts == 0
        # A step of 8 mm; the pressures go on without a jump.
        assert np.abs(found.pressures - before.pressures).max() < 10 * kPa
    cold = limb.reach(position=target, max_pressure=HIGHEST, **HANGING)
    assert_allclose(found.pressures, cold.pressures, rtol=0.0, atol=2e-3 * HIGHEST)


def test_an_answer_is_corrected_by_its_own_gap_and_a_path_of_poses_needs_no_new_start(limb: sl.Limb) -> None:
    # Postures on the way are integrated to the tolerance of a search: corrected by their gaps alone, steps of such a
    # path ended just outside the tolerance, and the search began again from nothing.
    generator = np.random.default_rng([20261122, 1, 0])
    first, last = generator.uniform(0.0, HIGHEST, (2, 9))
    direction = generator.normal(size=3)
    scene = {"gravity": (0.0, 0.0, 9.81), "tip_force": 0.2 * direction / np.linalg.norm(direction)}
    found = None
    for share in np.linspace(0.64, 0.70, 7):
        target = limb.solve(first + (last - first) * share, **scene).tip
        found = limb.reach(pose=target, max_pressure=HIGHEST, start=found, **scene)
        assert found.reached and found.posture.stable and (found.starts == 0 or share == 0.64)
        error = found.error
        assert error.relative <= 1e-6 and error.rotation is not None and error.rotation <= 1e-6


def test_a_posture_may_be_the_start_and_a_bad_one_gives_way(limb: sl.Limb) -> None:
    (posture,) = random_postures(limb, 1, 17)
    near = limb.reach(pose=posture.tip, max_pressure=HIGHEST, start=posture, **HANGING)
    require_reached(near, limb)
    assert near.starts == 0
    far = limb.solve([0.0, 90e3, 90e3, 90e3, 0.0, 0.0, 90e3, 0.0, 0.0], **HANGING)
    require_reached(limb.reach(pose=posture.tip, max_pressure=HIGHEST, start=far, **HANGING), limb)


def test_loads_of_every_kind_are_those_of_the_posture(limb: sl.Limb) -> None:
    scene: dict[str, Any] = {
        "gravity": (0.0, 0.0, 9.81),
        "plate_wrenches": np.array([[0.1, 0.2, 0, 0, 0, 0], [0.0] * 6, [0.3, 0, 0, 0, 0.01, 0]]),
        "rod_forces": np.tile([0.2, 0.0, 0.0], (9, 1)),
        "section": "nonlinear",
    }
    wanted = limb.solve([40e3, 20e3, 10e3, 30e3, 50e3, 20e3, 10e3, 0.0, 60e3], **scene)
    found = limb.reach(position=wanted.tip[:3, 3], max_pressure=HIGHEST, **scene)
    assert found.reached and found.posture.verify().success
    again = limb.solve(found.pressures, start=found.posture, **scene)
    assert_allclose(again.tip, found.posture.tip, rtol=0.0, atol=3e-6)
    assert_allclose(found.posture.loads["plate_wrenches"], scene["plate_wrenches"])
    assert_allclose(found.posture.loads["rod_forces"], scene["rod_forces"])


def test_every_answer_is_stable_where_postures_without_stability_lie_near() -> None:
    # A standing limb under weight: the straight postures of low pressure are unstable.
    limb = presets.reference_limb()
    rng = np.random.default_rng(18)
    standing = {"gravity": (0.0, 0.0, -9.81)}
    reached = 0
    for _ in range(4):
        wanted = limb.solve(rng.uniform(0.0, HIGHEST, 9), **standing)
        found = limb.reach(position=wanted.tip[:3, 3], max_pressure=HIGHEST, **standing)
        assert found.posture.success and found.posture.stable
        reached += found.reached
    assert reached == 4


@pytest.mark.parametrize("factor", [1e-8, 1e-6, 1e8])
def test_a_factor_of_all_weights_changes_nothing(limb: sl.Limb, factor: float) -> None:
    given = np.array([1.0, 0.5, 0.25])
    for position in ((0.1, 0.0, 0.72), (0.3, 0.1, 0.9)):  # in reach, and out of it
        plain, scaled = (
            limb.reach(position=position, weights=w, max_pressure=HIGHEST, **HANGING) for w in (given, factor * given)
        )
        assert plain.reached == scaled.reached == (position[2] < 0.8) and plain.status == scaled.status
        # The division by the largest weight rounds, and the search follows that to its own tolerance.
        assert_allclose(scaled.gap, plain.gap, rtol=0.0, atol=1e-5)
        assert_allclose(scaled.weights[:3], factor * given, rtol=1e-15)


@pytest.mark.parametrize("weights", [(1e-3, 1, 1, 1, 1, 1), (1, 1, 1, 1e-3, 1e-3, 1e-3), (1e-3, 1e-3, 1e-3, 1, 1, 1)])
def test_the_smallest_weights_allowed_reach_what_can_be_reached(limb: sl.Limb, weights: Any) -> None:
    for posture in random_postures(limb, 4, 13):
        require_reached(limb.reach(pose=posture.tip, weights=weights, max_pressure=HIGHEST, **HANGING), limb)


def test_pressures_stop_short_of_what_an_actuator_carries() -> None:
    plain = sl.Tube(0.2, [sl.Layer(18 * mm, 21.5 * mm, sl.materials.SMOOTHSIL_950)])
    limit = plain.limit_pressure
    assert limit is not None
    one = sl.Limb([sl.Segment([plain] * 3, ring_radius=30 * mm)])
    found = one.reach(position=(0.0, 0.0, 1.0), max_pressure=2.0 * limit)
    assert found.active == dict.fromkeys(range(3), "limit")
    assert (found.pressures < limit).all() and "carries no more" in found.message


def test_a_limb_without_freedom_to_go_there_says_so_for_every_target(limb: sl.Limb) -> None:
    held = {"tip_pose": limb.solve([0.0] * 9).tip}
    found = limb.reach(position=(0.1, 0.0, 0.7), max_pressure=HIGHEST, **held)
    assert not found.reached and found.status == "no_progress"


def test_an_answer_pickles_and_shows_itself(limb: sl.Limb) -> None:
    found = limb.reach(position=(0.1, 0.1, 0.75), max_pressure=HIGHEST, **HANGING)
    copy = pickle.loads(pickle.dumps(found))
    assert repr(copy) == repr(found) and copy.message == found.message == "reached"
    require_reached(limb.reach(position=(0.1, 0.1, 0.75), max_pressure=HIGHEST, start=copy, **HANGING), limb)


@pytest.mark.parametrize("loads", [{}, HANGING])
def test_the_papers_algorithm_finds_lengths_whose_posture_is_at_the_pose(limb: sl.Limb, loads: dict[str, Any]) -> None:
    rng = np.random.default_rng(19)
    wanted = limb.solve(rng.uniform(5 * kPa, 60 * kPa, 9), section="paper", **loads)
    found = limb.reach(pose=wanted.tip, max_pressure=HIGHEST, method="paper", **loads)
    assert isinstance(found, PaperReach) and found.reached and found.status == "converged", found.message
    assert (found.unknowns, found.residuals, found.rank) == (63, 72, 60)
    # Singular values that count span five to nine decades; the other three are below 1e-15 of the largest.
    assert 1e4 < found.condition < 1e10
    again = limb.solve(rest_lengths=found.lengths, start=found.posture, section="paper", tolerance=1e-9, **loads)
    assert again.success and again.stable
    assert np.linalg.norm(again.tip[:3, 3] - wanted.tip[:3, 3]) < 1e-6 * limb.length
    assert found.error.rotation is not None and found.error.rotation < 1e-6
    for tube, length, pressure in zip(limb._tubes, found.lengths, found.pressures, strict=True):
        assert tube.pressure_for(length / tube.length) == pytest.approx(pressure, rel=1e-12)
    assert "rank 60 of 63" in found.message
    copy = pickle.loads(pickle.dumps(found))
    assert copy.message == found.message and copy.rank == 60


def test_the_papers_algorithm_returns_an_answer_near_its_start(limb: sl.Limb) -> None:
    rng = np.random.default_rng(20)
    pressures = rng.uniform(10 * kPa, 50 * kPa, 9)
    wanted = limb.solve(pressures, section="paper")
    starts = [limb.solve(pressures + 0.3 * kPa * rng.normal(size=9), section="paper") for _ in range(2)]
    found = [limb.reach(pose=wanted.tip, max_pressure=HIGHEST, method="paper", start=start) for start in starts]
    assert all(each.reached and each.iterations > 1 for each in found)
    # One of a family with three parameters: another start, another answer.
    assert np.abs(found[0].lengths - found[1].lengths).max() > 1e-4  # type: ignore[attr-defined]


def test_lengths_that_need_more_pressure_than_allowed_are_no_answer(limb: sl.Limb) -> None:
    wanted = limb.solve([60e3, 20e3, 20e3, 30e3, 30e3, 10e3, 20e3, 20e3, 20e3], section="paper")
    found = limb.reach(pose=wanted.tip, max_pressure=40 * kPa, method="paper", start=wanted)
    assert found.status == "converged" and not found.reached
    assert "pressures outside the bounds" in found.message and "0 (max)" in found.message


def test_where_the_papers_algorithm_fails_the_nearest_posture_of_the_search_is_the_answer(limb: sl.Limb) -> None:
    wanted = limb.solve([60e3, 20e3, 20e3, 30e3, 30e3, 10e3, 20e3, 20e3, 20e3], section="paper")
    found = limb.reach(pose=wanted.tip, max_pressure=30 * kPa, method="paper")
    assert isinstance(found, PaperReach) and not found.reached and found.status != "converged"
    assert found.message.startswith("Algorithm 1 did not converge")
    assert "pressures outside the bounds" in found.message and "the nearest of the search" in found.message
    assert "no stable posture" not in found.message
    assert found.posture.success and found.posture.stable
    # The algorithm's own search, which leaves out what shortens tubes, at its own tolerance.
    bounds = {"min_pressure": 1 * kPa, "max_pressure": 30 * kPa}
    nearest = limb.reach(pose=wanted.tip, section="paper", tolerance=1e-4, **bounds)
    assert_allclose(found.pressures, nearest.pressures, rtol=1e-12)
    assert f"misses by {1e3 * nearest.error.position:.4g} mm" in found.message
    assert ((found.pressures >= 0.0) & (found.pressures <= 30 * kPa)).all() and found.active
    assert found.lengths.shape == (9,) and found.residual > 1e-6


def test_bounds_beyond_what_an_actuator_carries_are_refused(limb: sl.Limb) -> None:
    with pytest.raises(ValueError, match="min_pressure must be below what the actuator carries, got 9e\\+06 Pa"):
        limb.reach(position=(0.1, 0.0, 0.72), min_pressure=9e6, max_pressure=1e7, gravity=(0, 0, 9.81))


@pytest.mark.filterwarnings("error")
def test_a_miss_is_said_in_numbers_that_can_be_read(limb: sl.Limb) -> None:
    far = limb.reach(position=(1e300, 1e300, 0.0), max_pressure=HIGHEST)
    assert np.isfinite(far.error.position) and np.isfinite(far.error.relative)
    assert "misses by 1.414e+300 m;" in far.message and "%" not in far.message
    for error, words in (
        (ReachError(1.09, None, 1.09 / 0.65), "1090 mm (167.69% of 650 mm)"),
        (ReachError(1.549e-5, 0.0, 2.4e-5), "0.01549 mm and 0 deg"),
        (ReachError(12.5, None, 19.0), "12.5 m"),
    ):
        assert error.in_words(0.65) == words


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"position": (0, 0, 0.7)}, "takes a pose"),
        ({"pose": np.eye(4), "prefer": 20e3}, "neither position, weights nor prefer"),
        ({"pose": np.eye(4), "section": "tangent"}, 'section must be "paper"'),
        ({"pose": np.full((4, 4), np.nan)}, "pose must be finite"),
    ],
)
def test_what_the_papers_algorithm_cannot_do_is_refused(limb: sl.Limb, given: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        limb.reach(max_pressure=HIGHEST, method="paper", **given)


def test_a_method_that_is_none_is_refused(limb: sl.Limb) -> None:
    with pytest.raises(ValueError, match="method must be one of"):
        limb.reach(pose=np.eye(4), max_pressure=HIGHEST, method="magic")  # type: ignore[arg-type]


SHEARED = np.eye(4) + np.diag([0.1, 0.0, 0.0], 1)
MISTAKES: list[tuple[dict[str, Any], str]] = [
    ({}, "either position or pose"),
    ({"position": (0, 0, 1), "pose": np.eye(4)}, "either position or pose"),
    ({"position": (0.0, np.nan, 0.7)}, "position must be finite"),
    ({"position": (0.0, 0.7)}, "position has shape"),
    ({"position": "up"}, "position must be numbers"),
    ({"pose": SHEARED}, "rotation matrix"),
    ({"pose": np.diag([1.0, 1.0, -1.0, 1.0])}, "rotation matrix"),
    ({"pose": np.full((4, 4), np.inf)}, "pose must be finite"),
    ({"pose": np.eye(3)}, "pose has shape"),
    ({"position": (0, 0, 0.7), "weights": (1, 1, -1)}, "weights must not be negative"),
    ({"position": (0, 0, 0.7), "weights": (0, 0, 0)}, "weights must not be negative"),
    ({"position": (0, 0, 0.7), "weights": np.ones(6)}, "weights has shape"),
    ({"position": (0, 0, 0.7), "weights": (9e-4, 1, 1)}, "weights must each be zero, or at least 0.001 of the largest"),
    ({"pose": np.eye(4), "weights": (1, 1, 1, 1e-6, 0, 0)}, "at least 0.001 of the largest"),
    ({"position": (0, 0, 0.7), "min_pressure": 90e3}, "min_pressure must not exceed max_pressure"),
    ({"position": (0, 0, 0.7), "max_pressure": [80e3, -1.0] + [80e3] * 7}, "for actuator 1"),
    ({"position": (0, 0, 0.7), "max_pressure": np.inf}, "max_pressure must be finite"),
    ({"position": (0, 0, 0.7), "max_pressure": [80e3] * 4}, "max_pressure has shape"),
    ({"position": (0, 0, 0.7), "prefer": [1e3] * 4}, "prefer has shape"),
    ({"position": (0, 0, 0.7), "tolerance": 1e-10}, "tolerance must be within 1e-09 and 0.1"),
    ({"position": (0, 0, 0.7), "tolerance": 0.0}, "tolerance must be within 1e-09 and 0.1"),
    ({"position": (0, 0, 0.7), "gravity": (0, 0, np.nan)}, "gravity must be finite"),
    ({"position": (0, 0, 0.7), "section": "stiff"}, "section must be one of"),
]


@pytest.mark.parametrize(("given", "message"), MISTAKES)
def test_a_mistake_is_named(limb: sl.Limb, given: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        limb.reach(**{"max_pressure": HIGHEST, **given})


@pytest.mark.parametrize(
    "given", [{"pressures": [0.0] * 9}, {"prefer_stable": False}, {"speed": 1.0}, {"start": np.eye(4)}]
)
def test_what_does_not_apply_is_refused(limb: sl.Limb, given: dict[str, Any]) -> None:
    with pytest.raises(TypeError):
        limb.reach(position=(0, 0, 0.7), max_pressure=HIGHEST, **given)


def test_an_unknown_argument_is_answered_by_those_that_apply(limb: sl.Limb) -> None:
    with pytest.raises(TypeError, match=r"'foo' is no load of a reach: expected .*gravity(?!.*(prefer|lengths))"):
        limb.reach(position=(0, 0, 0.7), max_pressure=HIGHEST, foo=1)


def test_a_start_of_another_limb_or_without_pressures_is_refused(limb: sl.Limb) -> None:
    other = presets.reference_limb(["middle"]).solve([0.0] * 3)
    with pytest.raises(ValueError, match="another limb"):
        limb.reach(position=(0, 0, 0.7), max_pressure=HIGHEST, start=other)
    rods = sl.Limb(
        [sl.Segment(rods=[sl.Rod(sl.Section(axial=1e3, shear=1e3, bending=1.0, torsion=1.0), 0.2)], ring_radius=0.0)]
    )
    with pytest.raises(ValueError, match="no actuators"):
        rods.reach(position=(0, 0, 0.7), max_pressure=HIGHEST)


def test_a_search_is_interrupted_by_ctrl_c(limb: sl.Limb) -> None:
    timer = threading.Timer(0.3, signal.raise_signal, (signal.SIGINT,))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        for _ in range(1000):  # a tenth of a second each: far longer than the interrupt takes
            limb.reach(position=(0.0, 0.0, 0.3), max_pressure=HIGHEST, **HANGING)


def test_without_starts_from_nothing_a_path_is_the_same_and_a_far_target_is_given_up_at_once() -> None:
    limb, hanging = presets.reference_limb(), {"gravity": (0, 0, 9.81), "max_pressure": 80 * kPa}
    first = limb.reach(position=(0.08, 0.0, 0.73), **hanging)
    for position in ((0.08, 0.005, 0.73), (0.09, 0.0, 0.72)):
        found, usual = (limb.reach(position=position, start=first, starts=n, **hanging) for n in (0, 16))
        assert found.reached and found.starts == 0
        assert_allclose(found.pressures, usual.pressures, rtol=0, atol=1e-3 * 80 * kPa)  # as near as a preference goes
    far = limb.reach(position=(0.6, 0.0, 0.5), start=first, starts=0, **hanging)
    assert not far.reached and far.starts == 0 and far.posture.stable
    for starts, start in ((0, None), (-1, first), (17, None), (2.0, None)):
        with pytest.raises(ValueError, match="starts must be a whole number up to 16"):
            limb.reach(position=(0.0, 0.0, 0.7), start=start, starts=starts, **hanging)


def test_a_reach_starts_from_the_pressures_that_were_solved() -> None:
    limb, pressures = presets.reference_limb(["middle"]), np.array([30.0, 40.0, 20.0]) * kPa
    target = limb.solve(pressures + 4 * kPa).tip[:3, 3]
    found = []
    for written in (False, True):
        start = limb.solve(pressures)
        assert start.pressures is not None
        if written:
            start.pressures[:] = np.nan
        found.append(limb.reach(position=target, start=start, starts=0, max_pressure=80 * kPa).pressures)
        preferring = limb.reach(position=target, start=start, starts=0, max_pressure=80 * kPa, prefer=start)
        found.append(preferring.pressures)
    np.testing.assert_array_equal(found[0], found[2])
    np.testing.assert_array_equal(found[1], found[3])
