"""Sweeps: one row does not know of the others, and nothing fails silently."""

from __future__ import annotations

import csv
import types
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from softlimb import presets
from softlimb.sweep import bending_angle, rotation_vector, sweep


class Pillar:
    """A limb made of one straight actuator that grows by 1 mm a kPa: everything is known beforehand."""

    length = 0.2
    segments = (types.SimpleNamespace(actuators=(None,)),)

    def solve(self, pressures, **scene):
        if scene.get("gravity") == "up":
            raise ValueError("gravity must be three numbers")
        pressure = float(pressures[0])
        if pressure < 0.0:
            raise ValueError("pressures must not be negative")
        if pressure == 13e3:
            raise KeyboardInterrupt
        pose = np.eye(4)
        pose[2, 3] = self.length + 1e-6 * pressure
        good = pressure < 50e3
        return types.SimpleNamespace(
            success=good,
            status="converged" if good else "max_iterations",
            message="" if good else "no balance after 50 iterations",
            iterations=3,
            residual=1e-12,
            tip=pose,
            plates=pose[None],
            stable=True,
            clearance=None,
        )


def test_a_failed_row_has_status_message_and_no_pose() -> None:
    batch = sweep(Pillar(), [[10e3], [60e3], [-1.0]], progress=False)
    assert batch.success.tolist() == [True, False, False]
    assert batch.status == ["converged", "max_iterations", "invalid"]
    assert batch.failures == {1: "no balance after 50 iterations", 2: "pressures must not be negative"}
    assert np.isnan(batch.tip[1:]).all()
    assert_allclose(batch.tip[0, 2, 3], 0.21)


def test_an_interrupted_sweep_keeps_what_is_done() -> None:
    batch = sweep(Pillar(), [[1e3], [13e3], [2e3]], progress=False)
    assert batch.interrupted
    assert batch.success.tolist() == [True, False, False]
    assert batch.status[1:] == ["not_run", "not_run"]


def test_the_order_of_rows_does_not_matter() -> None:
    rows = np.linspace(0.0, 12e3, 7)[:, None]
    forward, backward = sweep(Pillar(), rows, progress=False), sweep(Pillar(), rows[::-1], progress=False)
    assert np.array_equal(forward.tip, backward.tip[::-1])


def test_what_the_limb_refuses_for_every_row_is_an_error() -> None:
    with pytest.raises(ValueError, match="gravity must be three numbers"):
        sweep(Pillar(), [[1e3], [2e3]], progress=False, gravity="up")


@pytest.mark.parametrize(
    ("pressures", "message"),
    [
        ([1.0], r"shape \(1,\) but the limb has 1 actuators: expected \(N, 1\)"),
        ([[1.0, 2.0]], r"shape \(1, 2\)"),
        ([[1.0], [np.nan]], r"must be finite; row 1 is \[nan\]"),
    ],
)
def test_wrong_pressures_are_named(pressures, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        sweep(Pillar(), pressures, progress=False)


def test_columns_carry_units_and_unknown_numbers_are_empty(tmp_path: Path) -> None:
    sweep(Pillar(), [[10e3], [60e3]], progress=False).to_csv(tmp_path / "a.csv")
    with (tmp_path / "a.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert rows[0]["pressure_1_1_kPa"] == "10"
    assert float(rows[0]["tip_z_mm"]) == pytest.approx(210.0, rel=1e-11)  # twelve digits are written
    assert rows[0]["clearance_mm"] == rows[1]["tip_z_mm"] == ""
    assert rows[1]["message"] == "no balance after 50 iterations"


@given(st.tuples(*[st.floats(-1.0, 1.0)] * 3), st.floats(0.0, np.pi))
def test_rotation_vectors_come_back_from_their_matrix(direction: tuple[float, float, float], angle: float) -> None:
    length = float(np.linalg.norm(direction))
    if length < 1e-3:
        return
    x, y, z = axis = np.array(direction) / length
    hat = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    pose = np.eye(4)
    pose[:3, :3] = np.eye(3) + np.sin(angle) * hat + (1.0 - np.cos(angle)) * hat @ hat
    found = rotation_vector(pose)
    # At half a turn both signs of the axis are the same rotation.
    sign = -1.0 if angle > np.pi - 1e-6 and found @ axis < 0.0 else 1.0
    # rounding of the matrix, 1e-16, over the sine of the smallest angle at which it decides, 0.14
    assert_allclose(sign * found, angle * axis, rtol=0, atol=1e-14 / 0.1)
    assert_allclose(bending_angle(pose), np.arctan2(np.hypot(*pose[:2, 2]), pose[2, 2]), rtol=0, atol=0)


@pytest.mark.parametrize("pressures", [[[1.0 + 2.0j]], [["1000"]], [[True]], [[1.0], [1.0, 2.0]], [[None]]])
def test_pressures_that_are_no_real_numbers_are_refused_by_name(pressures) -> None:
    with pytest.raises(ValueError, match="pressures must be"):
        sweep(Pillar(), pressures, progress=False)


@pytest.mark.parametrize("rows", [[[True] + [0.0] * 8], [[0.0] * 8 + ["1"]], [[None] * 9], [[0.0] * 8 + [1j]]])
def test_a_lone_truth_value_among_pressures_is_refused_by_name(rows):
    with pytest.raises(ValueError, match="pressures"):
        presets.reference_limb().sweep(rows, progress=False)


@pytest.mark.parametrize("progress", [None, 2, np.zeros(3), "yes"])
def test_progress_is_true_or_false(progress):
    with pytest.raises(ValueError, match="progress must be True or False"):
        presets.reference_limb().sweep(np.zeros((1, 9)), progress=progress)
