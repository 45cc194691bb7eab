"""Rows of pressures on threads: each is the posture that a solve gives, whoever solves it and in whatever order."""

from __future__ import annotations

import os
import signal
import threading
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import softlimb as sl
from softlimb import presets
from softlimb.rows import GROUP, INVALID, NOT_RUN, Rows, solve_rows
from softlimb.units import kPa

HANGING = (0.0, 0.0, 9.81)
ARRAYS = ("tip", "plates", "success", "stable", "unstable_modes", "clearance", "iterations", "residual")


@pytest.fixture(scope="module")
def limb() -> sl.Limb:
    return presets.reference_limb(["proximal", "distal"])


@pytest.fixture(scope="module")
def pressures() -> np.ndarray:
    """A little more than two groups of neighbours."""
    along = np.linspace(0.0, 1.0, 2 * GROUP + 7)[:, None]
    return np.array([30.0, 5.0, 0.0, 20.0, 40.0, 10.0]) * kPa * (0.2 + 0.8 * along)


def rows_of(limb: sl.Limb, pressures: np.ndarray, **options: Any) -> Rows:
    given: dict[str, Any] = {"threads": 2, "ordered": False, "tick": lambda done: True, "gravity": HANGING}
    return solve_rows(limb, pressures, **(given | options))


def same_bits(a: Rows, b: Rows) -> bool:
    """Of everything, NaN included."""
    arrays = all(getattr(a, name).tobytes() == getattr(b, name).tobytes() for name in ARRAYS)
    return arrays and a.status == b.status and a.message == b.message


def test_rows_are_the_postures_of_a_loop(limb: sl.Limb, pressures: np.ndarray) -> None:
    rows = rows_of(limb, pressures, tip_force=(0.2, 0.0, 0.1), tolerance=1e-8)
    for row in range(0, len(pressures), 9):
        posture = limb.solve(pressures[row], gravity=HANGING, tip_force=(0.2, 0.0, 0.1), tolerance=1e-8)
        assert rows.status[row] == posture.status == "converged" and rows.success[row]
        assert rows.message.get(row, "converged") == posture.message
        assert_allclose(rows.tip[row], posture.tip, rtol=0.0, atol=2e-8)  # two solves of a tolerance of 1e-8
        assert_allclose(rows.plates[row], posture.plates, rtol=0.0, atol=2e-8)
        assert rows.stable[row] == posture.stable
        assert rows.unstable_modes[row] == posture.unstable_modes
        assert rows.clearance[row] == pytest.approx(posture.clearance, abs=1e-7)
        assert rows.iterations[row] > 0 and np.isfinite(rows.residual[row])


@pytest.mark.parametrize("section, valve", [("nonlinear", "open"), ("paper", "locked")])
def test_rows_take_the_options_of_a_solve(limb: sl.Limb, section: Any, valve: Any) -> None:
    pressures = np.array([[40.0, 5.0, 0.0, 20.0, 30.0, 10.0]]) * kPa
    options: dict[str, Any] = {
        "section": section, "valve": valve, "gravity": HANGING, "tip_moment": (0.0, 0.01, 0.0), "frame": "plate",
        "rod_forces": np.full((6, 3), 0.1), "plate_held": [[False] * 6, [False] * 3 + [True] * 3],
    }  # fmt: skip
    rows, posture = rows_of(limb, pressures, **options), limb.solve(pressures[0], **options)
    assert posture.success and rows.success[0]
    assert_allclose(rows.tip[0], posture.tip, rtol=0.0, atol=2e-6)


@pytest.mark.parametrize("ordered", [False, True])
@pytest.mark.parametrize("threads", [2, 3, 50])
def test_no_bit_depends_on_the_number_of_threads(
    limb: sl.Limb, pressures: np.ndarray, ordered: bool, threads: int
) -> None:
    one = rows_of(limb, pressures, threads=1, ordered=ordered)
    assert same_bits(one, rows_of(limb, pressures, threads=threads, ordered=ordered))


def test_no_bit_depends_on_the_order_of_the_rows(limb: sl.Limb, pressures: np.ndarray) -> None:
    order = np.random.default_rng(3).permutation(len(pressures))
    straight, mixed = rows_of(limb, pressures), rows_of(limb, pressures[order])
    for name in ARRAYS:
        assert getattr(mixed, name).tobytes() == getattr(straight, name)[order].tobytes(), name
    assert mixed.message == {i: straight.message[row] for i, row in enumerate(order) if row in straight.message}


def test_ordered_rows_are_the_same_postures_and_take_fewer_iterations(limb: sl.Limb, pressures: np.ndarray) -> None:
    single, chained = rows_of(limb, pressures), rows_of(limb, pressures, ordered=True)
    assert chained.success.all()
    assert_allclose(chained.tip, single.tip, rtol=0.0, atol=2e-6)  # two solves of a tolerance of 1e-6
    heads = np.arange(len(pressures)) % GROUP == 0
    # The first of each group starts by itself.
    assert chained.tip[heads].tobytes() == single.tip[heads].tobytes()
    # The others have started elsewhere, and say nothing of it.
    assert not (chained.tip[~heads] == single.tip[~heads]).all(axis=(1, 2)).any() and not chained.message


def test_a_row_that_did_not_converge_starts_nobody(limb: sl.Limb) -> None:
    pressures = np.array([[10.0] * 6, [1e6] * 6, [12.0] * 6]) * kPa
    chained, without = rows_of(limb, pressures, ordered=True), rows_of(limb, pressures[[0, 2]], ordered=True)
    assert chained.success.tolist() == [True, False, True]
    assert chained.tip[2].tobytes() == without.tip[1].tobytes()
    # And where it is the only one before, the next starts by itself.
    chained, single = rows_of(limb, pressures[1:], ordered=True), rows_of(limb, pressures[1:])
    assert chained.tip[1].tobytes() == single.tip[1].tobytes()


def test_a_refused_row_has_status_and_reason_and_the_others_stand() -> None:
    balloon = sl.Tube(0.2, [sl.Layer(0.018, 0.0215, sl.NeoHookean(c1=340 * kPa))])
    limb = sl.Limb([sl.Segment(actuators=[balloon] * 3, ring_radius=0.03)])
    pressures = np.array([[20.0, 10.0, 0.0], [20.0, 95.0, 0.0], [5.0, 5.0, 5.0]]) * kPa
    rows = rows_of(limb, pressures)
    assert rows.status == ["converged", "limit_point", "converged"]
    assert rows.message[1] == limb.solve(pressures[1]).message
    assert rows.message[1].startswith("actuator 1 has no stable state at 95 kPa")
    assert np.isnan(rows.tip[1]).all() and np.isnan(rows.plates[1]).all() and np.isnan(rows.clearance[1])
    assert not rows.success[1] and not rows.stable[1] and rows.unstable_modes[1] == -1
    assert np.isinf(rows.residual[1])


def test_touching_tubes_and_tubes_beyond_their_law_are_told_of_by_row(limb: sl.Limb) -> None:
    pressures = np.array([[0.0] * 6, [0.0] * 3 + [110.0, 110.0, 110.0], [90.0, 0.0, 0.0, 90.0, 0.0, 0.0]]) * kPa
    rows = rows_of(limb, pressures)
    assert 0 not in rows.message
    for row in (1, 2):
        assert rows.message[row] == limb.solve(pressures[row], gravity=HANGING).message
    assert "the law leaves its range" in rows.message[1]


def test_rows_start_where_they_are_told(limb: sl.Limb, pressures: np.ndarray) -> None:
    start = limb.solve(pressures[0], gravity=HANGING)
    near = pressures[:3]
    for given in (start, start.plates):
        rows = rows_of(limb, near, start=given)
        assert rows.success.all() and not rows.message
        alone = [limb.solve(p, gravity=HANGING, start=given) for p in near]
        assert all("started from the given posture" in " ".join(posture.plan) for posture in alone)
        assert rows.tip.tobytes() == np.array([posture.tip for posture in alone]).tobytes()


# --- ways to stop ------------------------------------------------------------------------------------------------

MANY = 20_000  # a sweep that takes longer than a tenth of a second, however fast its rows


def many() -> tuple[sl.Limb, np.ndarray]:
    limb = presets.reference_limb(["distal"])
    return limb, np.random.default_rng(5).uniform(0.0, 60 * kPa, (MANY, 3))


def assert_what_is_done_stays(limb: sl.Limb, pressures: np.ndarray, rows: Rows) -> None:
    done = np.array([status != NOT_RUN for status in rows.status])
    assert 0 < done.sum() < MANY
    assert rows.success[done].all() and np.isfinite(rows.tip[done]).all()
    assert not rows.success[~done].any() and np.isnan(rows.tip[~done]).all()
    sample = np.flatnonzero(done)[::997]
    again = rows_of(limb, pressures[sample])
    assert rows.tip[sample].tobytes() == again.tip.tobytes()


def test_a_tick_that_is_false_stops_and_what_is_done_stays() -> None:
    limb, pressures = many()
    told: list[int] = []

    def tick(done: int) -> bool:
        told.append(done)
        return len(told) < 2

    rows = rows_of(limb, pressures, tick=tick)
    assert len(told) == 2 and 0 < told[0] <= told[1]
    assert_what_is_done_stays(limb, pressures, rows)


def test_ctrl_c_stops_and_what_is_done_stays() -> None:
    limb, pressures = many()
    timer = threading.Timer(0.15, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    rows = rows_of(limb, pressures)
    timer.join()
    assert_what_is_done_stays(limb, pressures, rows)


def test_an_exception_of_a_tick_comes_out_once_the_workers_have_stopped() -> None:
    limb, pressures = many()

    def tick(done: int) -> bool:
        raise ZeroDivisionError("of the tick")

    with pytest.raises(ZeroDivisionError, match="of the tick"):
        rows_of(limb, pressures, tick=tick)


def test_several_sweeps_at_once_do_not_disturb_each_other(limb: sl.Limb, pressures: np.ndarray) -> None:
    alone, found = rows_of(limb, pressures), {}
    callers = [
        threading.Thread(target=lambda i=i: found.setdefault(i, rows_of(limb, pressures))) for i in range(3)
    ]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join()
    assert len(found) == 3 and all(same_bits(alone, rows) for rows in found.values())


# --- input -------------------------------------------------------------------------------------------------------


def test_no_rows_are_no_work(limb: sl.Limb) -> None:
    rows = rows_of(limb, np.zeros((0, 6)), threads=4)
    assert len(rows) == 0 and rows.tip.shape == (0, 4, 4) and rows.plates.shape == (0, 2, 4, 4)


def test_what_the_limb_refuses_is_invalid_in_every_row(limb: sl.Limb) -> None:
    rows = rows_of(limb, np.zeros((2, 6)), gravity="up")
    assert rows.status == [INVALID] * 2 and "gravity" in rows.message[0] and rows.message[1] == rows.message[0]
    rods = sl.Limb([sl.Segment(rods=[sl.Rod(sl.Section(axial=1, shear=1, bending=1, torsion=1), 1)], ring_radius=0)])
    assert rows_of(rods, np.zeros((1, 0))).status == [INVALID]


BAD: list[tuple[dict[str, Any], type[Exception], str]] = [
    ({"gravitas": 1.0}, TypeError, "gravitas"),
    ({"rest_length": 1.0}, TypeError, "rest_length"),
    ({"threads": 0}, ValueError, "threads"),
    ({"threads": True}, ValueError, "threads"),
    ({"threads": 1.5}, ValueError, "threads"),
    ({"ordered": "yes"}, ValueError, "ordered"),
]


@pytest.mark.parametrize("options, error, name", BAD)
def test_bad_options_are_refused_by_name(limb: sl.Limb, options: dict[str, Any], error: Any, name: str) -> None:
    with pytest.raises(error, match=name):
        rows_of(limb, np.zeros((1, 6)), **options)


@pytest.mark.parametrize("pressures", [np.zeros((2, 5)), np.zeros(6), np.full((1, 6), np.nan)])
def test_bad_pressures_are_refused_by_name(limb: sl.Limb, pressures: np.ndarray) -> None:
    with pytest.raises(ValueError, match="pressures"):
        rows_of(limb, pressures)
