"""Sweeps: one row does not know of the others, and nothing fails silently."""

from __future__ import annotations

import csv
import signal
import types
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from softlimb import presets, rows
from softlimb.sweep import bending_angle, rotation_vector, run, sweep
from sweep_examples import KnownRows, same_bits, small_limb, some_pressures


class Pillar:
    """A limb of one actuator, whose rows `KnownRows` solves."""

    length = 0.2
    segments = (types.SimpleNamespace(actuators=(None,)),)


@pytest.fixture
def known_rows(monkeypatch):
    solver = KnownRows()
    monkeypatch.setattr(rows, "solve_rows", solver)
    return solver


# --- what a batch says -------------------------------------------------------------------------------------------


def test_a_failed_row_has_status_message_and_no_pose(known_rows) -> None:
    batch = sweep(Pillar(), [[10e3], [60e3], [-1.0]], progress=False)
    assert batch.success.tolist() == [True, False, False]
    assert batch.status == ["converged", "max_iterations", "invalid"]
    assert batch.failures == {1: "no balance after 50 iterations", 2: "pressures must be at least 1 kPa, got -1.0 Pa"}
    assert np.isnan(batch.tip[1:]).all()
    assert_allclose(batch.tip[0, 2, 3], 0.21)
    assert not batch.interrupted


def test_failures_are_found_in_every_block_of_rows(known_rows, monkeypatch) -> None:
    batch = sweep(Pillar(), [[p] for p in (60e3, 2e3, 3e3, 4e3, 0.0, 5e3, 6e3, 70e3, 8e3)], progress=False)
    monkeypatch.setattr("softlimb.sweep.row_table._BLOCK", 2)
    assert list(batch.failures) == [0, 4, 7] and "got 0.0 Pa" in batch.failures[4]
    assert list(batch.message) == batch.message[:] and len(batch.message[:]) == 9
    assert sweep(Pillar(), [[2e3]], progress=False).failures == {}


def test_remarks_are_the_rows_that_succeeded_and_say_more(known_rows) -> None:
    batch = sweep(Pillar(), [[10e3], [60e3], [25e3]], progress=False)
    assert batch.remarks.tolist() == [2]
    assert batch.message == ["converged", "no balance after 50 iterations", batch.message[2]]
    assert "a remark at 25000.0 Pa" in batch.message[-1]
    assert batch.having("max_iterations").tolist() == [1]


def test_the_order_of_rows_does_not_matter(known_rows) -> None:
    pressures = np.linspace(1e3, 12e3, 7)[:, None]
    forward, backward = sweep(Pillar(), pressures, progress=False), sweep(Pillar(), pressures[::-1], progress=False)
    assert np.array_equal(forward.tip, backward.tip[::-1])


def test_what_the_limb_refuses_for_every_row_is_an_error(known_rows) -> None:
    with pytest.raises(ValueError, match="gravity must be three numbers"):
        sweep(Pillar(), [[1e3], [2e3]], progress=False, gravity="up")
    with pytest.raises(ValueError, match=r"got -2\.0 Pa"):
        sweep(Pillar(), [[-1.0], [-2.0]], progress=False)
    with pytest.raises(ValueError, match="gravity"):
        small_limb().sweep(np.zeros((2, 3)), progress=False, gravity="up")


def test_columns_carry_units_and_unknown_numbers_are_empty(known_rows, tmp_path: Path) -> None:
    sweep(Pillar(), [[10e3], [60e3]], progress=False).to_csv(tmp_path / "a.csv")
    with (tmp_path / "a.csv").open(encoding="utf-8", newline="") as file:
        read = list(csv.DictReader(file))
    assert read[0]["pressure_1_1_kPa"] == "10"
    assert float(read[0]["tip_z_mm"]) == pytest.approx(210.0, rel=1e-11)  # twelve digits are written
    assert read[0]["clearance_mm"] == read[1]["tip_z_mm"] == ""
    assert read[1]["message"] == "no balance after 50 iterations"


def test_a_table_is_the_same_in_one_block_and_in_many(known_rows, monkeypatch, tmp_path: Path) -> None:
    batch = sweep(small_limb(), some_pressures(50), progress=False)
    batch.to_csv(tmp_path / "one.csv")
    monkeypatch.setattr("softlimb.sweep.batch._BLOCK", 7)
    batch.to_csv(tmp_path / "many.csv")
    assert (tmp_path / "one.csv").read_bytes() == (tmp_path / "many.csv").read_bytes()


def test_an_empty_sweep_is_an_empty_batch(tmp_path: Path) -> None:
    batch = small_limb().sweep(np.zeros((0, 3)), progress=False)
    assert len(batch) == 0 and not batch.interrupted and batch.message == []
    batch.to_csv(tmp_path / "a.csv")
    assert (tmp_path / "a.csv").read_text(encoding="utf-8").startswith("pressure_1_1_kPa,")


# --- the same bits -----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def plain():
    """Rows of the real solver, with a refused one (a balloon far beyond its limit) in the middle."""
    pressures = some_pressures(40)
    pressures[17] = 5e6
    return small_limb().sweep(pressures, gravity=(0.0, 0.0, 9.81), progress=False)


def test_a_row_equals_the_posture_of_its_pressures(plain) -> None:
    assert plain.having("limit_point").tolist() == [17]
    assert "5000 kPa" in plain.message[17]
    for row in (0, 16, 39):
        posture = plain.limb.solve(plain.pressures[row], gravity=(0.0, 0.0, 9.81))
        # both are within the tolerance of the same equilibrium
        assert_allclose(plain.tip[row], posture.tip, rtol=0, atol=2e-6)
        assert plain.stable[row] == posture.stable and plain.unstable_modes[row] == posture.unstable_modes
        assert_allclose(plain.clearance[row], posture.clearance, atol=1e-6)


@pytest.mark.parametrize("threads", [1, 2, 7])
def test_thread_count_does_not_change_any_bit_of_the_sweep(plain, threads: int) -> None:
    again = plain.limb.sweep(plain.pressures, gravity=(0.0, 0.0, 9.81), progress=False, threads=threads)
    assert same_bits(plain, again)
    assert again.builds == plain.builds


def test_permuting_the_rows_permutes_their_bits(plain) -> None:
    order = np.random.default_rng(3).permutation(len(plain))
    again = plain.limb.sweep(plain.pressures[order], gravity=(0.0, 0.0, 9.81), progress=False)
    for name, values in plain.as_columns().items():
        assert values[order].tobytes() == again.as_columns()[name].tobytes(), name
    assert [plain.message[row] for row in order] == list(again.message)


def test_the_blocks_of_an_ordered_sweep_do_not_show_in_its_rows(monkeypatch) -> None:
    limb, pressures = small_limb(), np.linspace(0.0, 40e3, 100)[:, None] * [1.0, 0.5, 0.0]
    whole = limb.sweep(pressures, ordered=True, progress=False)
    monkeypatch.setattr(run, "_BLOCK_SECONDS", 1e-9)
    assert same_bits(whole, limb.sweep(pressures, ordered=True, progress=False, threads=1))
    assert whole.ordered
    single = limb.sweep(pressures, progress=False)
    # each row is within its tolerance of the one equilibrium
    assert_allclose(whole.tip, single.tip, rtol=0, atol=2e-6)
    assert whole.tip.tobytes() != single.tip.tobytes()  # a different way there


def test_an_ordered_row_starts_from_the_one_before_within_its_group(known_rows) -> None:
    pressures = np.full((70, 3), 10e3)
    height = small_limb().sweep(pressures, ordered=True, progress=False).tip[:, 2, 3]
    assert height[0] == height[32] == height[64] < height[1] == height[33] == height[65] < height[2]


def test_the_build_says_version_core_and_instruction_set(plain) -> None:
    assert len(plain.builds) == 1 and plain.build == rows.build()
    for word in ("softlimb ", "core ", "instruction set "):
        assert word in plain.build


# --- Ctrl-C ------------------------------------------------------------------------------------------------------


def test_an_interrupted_sweep_keeps_what_is_done_and_goes_on(known_rows) -> None:
    known_rows.stop_at = 13e3
    batch = sweep(Pillar(), [[1e3], [13e3], [2e3]], progress=False)
    assert batch.interrupted
    assert batch.success.tolist() == [True, False, False]
    assert batch.status[1:] == ["not_run", "not_run"]
    assert batch.message[2] == "the sweep was interrupted before this row"
    known_rows.stop_at, known_rows.solved = None, []
    finished = batch.resume(progress=False)
    assert known_rows.solved == [13e3, 2e3]
    assert same_bits(finished, sweep(Pillar(), [[1e3], [13e3], [2e3]], progress=False))
    assert batch.interrupted  # stays as it is


@pytest.mark.parametrize("times", [1, 2])
def test_ctrl_c_ends_a_sweep_between_rows(known_rows, monkeypatch, times: int) -> None:
    pressures = np.linspace(1e3, 12e3, 100)[:, None]
    solve = rows.solve_rows

    def pressed(limb, pressures, *, tick, **options):
        def tock(done):
            if done == 20:
                for _ in range(times):
                    signal.raise_signal(signal.SIGINT)
            return tick(done)

        return solve(limb, pressures, tick=tock, **options)

    monkeypatch.setattr(rows, "solve_rows", pressed)
    batch = sweep(Pillar(), pressures, progress=False, threads=1)
    # The second one does not wait for a row to end: the block that is under way is lost.
    assert int(batch.success.sum()) == (20 if times == 1 else 0)
    assert batch.interrupted
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_an_ordered_sweep_goes_on_with_whole_groups(known_rows) -> None:
    pressures = np.linspace(1e3, 12e3, 100)[:, None]
    known_rows.stop_at = float(pressures[40, 0])
    batch = sweep(Pillar(), pressures, progress=False, ordered=True)
    assert int(batch.success.sum()) == 40
    known_rows.stop_at, known_rows.solved = None, []
    finished = batch.resume(progress=False)
    assert len(known_rows.solved) == 68  # from row 32 on
    assert same_bits(finished, sweep(Pillar(), pressures, progress=False, ordered=True))


def test_progress_counts_every_row_once(known_rows, monkeypatch, capsys) -> None:
    tqdm = pytest.importorskip("tqdm")
    bars = []

    class Bar(tqdm.tqdm):
        def __init__(self, *arguments, **options):
            super().__init__(*arguments, **options)
            bars.append(self)

    monkeypatch.setattr(tqdm, "tqdm", Bar)
    known_rows.stop_at = 40e3
    batch = sweep(Pillar(), [[p] for p in (1e3, 2e3, 40e3, 3e3)])
    known_rows.stop_at = None
    batch.resume()
    assert [(bar.initial, bar.total) for bar in bars] == [(0, 4), (2, 4)]
    assert bars[1].n == 4
    assert "4/4" in capsys.readouterr().err


# --- datasets ----------------------------------------------------------------------------------------------------


def test_a_dataset_has_units_the_scene_and_the_same_bits_after_netcdf(plain, tmp_path: Path) -> None:
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("netCDF4")
    dataset = plain.to_xarray()
    dataset.to_netcdf(tmp_path / "a.nc")
    with xarray.open_dataset(tmp_path / "a.nc") as read:
        for name, values in dataset.variables.items():
            if values.dtype == object:
                assert values.values.tolist() == read[name].values.tolist(), name
            else:
                assert values.values.tobytes() == read[name].values.astype(values.dtype).tobytes(), name
            assert read[name].attrs == values.attrs, name
        assert read.attrs == dataset.attrs
    assert dataset.pressure.attrs["units"] == "Pa" and dataset.tip_position.attrs["units"] == "m"
    assert "gravity_m_s2" in dataset.attrs["scene"] and dataset.attrs["build"] == plain.build
    assert dataset.tip_position.values.tobytes() == plain.tip[:, :3, 3].tobytes()
    assert dataset.message.values.tolist() == list(plain.message)


def test_a_dataset_says_what_its_scene_leaves_out() -> None:
    pytest.importorskip("xarray")
    limb = small_limb()
    forces = np.zeros((3, 3))
    forces[1] = (0.0, 0.1, 0.0)
    start = limb.solve([10e3, 0.0, 0.0]).plates
    dataset = limb.sweep([[10e3, 0.0, 0.0]], progress=False, start=start, rod_forces=forces).to_xarray()
    assert dataset.attrs["scene_left_out"] == "start"
    assert "force_per_length_N_m" in dataset.attrs["scene"]


# --- arguments ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("pressures", "message"),
    [
        ([1.0], r"shape \(1,\) but the limb has 1 actuators: expected \(N, 1\)"),
        ([[1.0, 2.0]], r"shape \(1, 2\)"),
        ([[1.0], [np.nan]], r"must be finite; row 1 is \[nan\]"),
        (np.array([[1.0], [np.inf]]), r"must be finite; row 1 is \[inf\]"),
        (np.ma.masked_greater([[1.0], [9.0]], 5.0), "pressures must have no masked numbers"),
    ],
)
def test_wrong_pressures_are_named(pressures, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        sweep(Pillar(), pressures, progress=False)


@pytest.mark.parametrize("pressures", [[[1.0 + 2.0j]], [["1000"]], [[True]], [[1.0], [1.0, 2.0]], [[None]]])
def test_pressures_that_are_no_real_numbers_are_refused_by_name(pressures) -> None:
    with pytest.raises(ValueError, match="pressures must be"):
        sweep(Pillar(), pressures, progress=False)


@pytest.mark.parametrize("row", [[True] + [0.0] * 8, [0.0] * 8 + ["1"], [None] * 9, [0.0] * 8 + [1j]])
def test_a_lone_truth_value_among_pressures_is_refused_by_name(row):
    with pytest.raises(ValueError, match="pressures"):
        presets.reference_limb().sweep([row], progress=False)


@pytest.mark.parametrize("name", ["progress", "ordered"])
@pytest.mark.parametrize("value", [None, 2, np.zeros(3), "yes"])
def test_progress_and_ordered_are_true_or_false(name, value):
    with pytest.raises(ValueError, match=f"{name} must be True or False"):
        presets.reference_limb().sweep(np.zeros((1, 9)), **{"progress": False, name: value})


@pytest.mark.parametrize("threads", [0, -1, 1.5, 2.0, True, "2", np.zeros(1), np.nan])
def test_threads_are_a_whole_number_of_at_least_one(threads):
    with pytest.raises(ValueError, match="threads must be a whole number of at least 1"):
        small_limb().sweep(np.zeros((1, 3)), progress=False, threads=threads)


@pytest.mark.parametrize("executor", [1, "processes", True, object()])
def test_an_executor_is_one_or_makes_one(executor):
    with pytest.raises(TypeError, match=r"executor must be a concurrent\.futures\.Executor"):
        small_limb().sweep(np.zeros((1, 3)), progress=False, executor=executor)


def test_what_an_executor_is_made_by_is_called_to_account():
    with pytest.raises(TypeError, match=r"executor must make a concurrent\.futures\.Executor, it made 3"):
        small_limb().sweep(np.zeros((1, 3)), progress=False, executor=lambda: 3)


def test_the_pressures_of_a_batch_are_its_own(known_rows):
    given = np.full((2, 1), 2e3)
    batch = sweep(Pillar(), given, progress=False)
    given[:] = 0.0
    assert (batch.pressures == 2e3).all()


# --- angles ------------------------------------------------------------------------------------------------------


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
