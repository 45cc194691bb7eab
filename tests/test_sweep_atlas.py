"""Long sweeps: rows that start from a fit through some of them have the answers of rows that start by themselves."""

from __future__ import annotations

import pickle
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest

from softlimb import rows
from softlimb.sweep import run
from sweep_examples import same_bits, small_limb, some_pressures

LONG = run._LONG
TIP = {"gravity": (0.0, 0.0, 9.81), "tip_force": (0.05, -0.02, 0.1)}


@pytest.fixture(scope="module")
def limb():
    return small_limb()


@pytest.fixture(scope="module")
def pressures():
    return some_pressures(LONG)


@pytest.fixture(scope="module")
def batch(limb, pressures):
    return limb.sweep(pressures, threads=1, progress=False, **TIP)


def test_a_long_sweep_has_the_answers_of_a_short_one(limb, pressures, batch) -> None:
    assert batch.success.all() and batch.stable.all() and (batch.unstable_modes == 0).all()
    short = limb.sweep(pressures[:200], progress=False, **TIP)
    # Each within its tolerance of 1e-6 of the limb's length, or radians.
    gap = np.abs(batch.plates[:200] - short.plates).max(axis=(1, 2, 3))
    assert (gap < 2e-6).all()
    np.testing.assert_allclose(batch.clearance[:200], short.clearance, atol=2e-6)
    # It was not solved by the other way after all.
    assert not np.array_equal(batch.tip[:200], short.tip)


def test_no_bit_of_a_long_sweep_depends_on_threads_or_order(limb, pressures, batch) -> None:
    assert same_bits(batch, limb.sweep(pressures, threads=2, progress=False, **TIP))
    order = np.random.default_rng(3).permutation(len(pressures))
    other = limb.sweep(pressures[order], threads=2, progress=False, **TIP)
    for name, values in batch.as_columns().items():
        assert values[order].tobytes() == other.as_columns()[name].tobytes(), name


def test_an_atlas_travels_to_other_processes(limb, pressures, batch) -> None:
    with ProcessPoolExecutor(2) as pool:
        assert same_bits(batch, limb.sweep(pressures, executor=pool, progress=False, **TIP))


def test_a_long_sweep_that_was_cut_goes_on_to_the_same_bits(limb, pressures, batch, tmp_path, monkeypatch) -> None:
    whole = rows.solve_rows
    calls = []

    def cut(*args, **options):
        calls.append(len(args[1]))
        if len(calls) == 2:
            raise RuntimeError("the machine went down")
        return whole(*args, **options)

    monkeypatch.setattr(rows, "solve_rows", cut)
    with pytest.raises(RuntimeError, match="went down"):
        limb.sweep(pressures, threads=1, progress=False, file=tmp_path / "sweep.npz", **TIP)
    monkeypatch.setattr(rows, "solve_rows", whole)
    assert same_bits(batch, limb.sweep(pressures, threads=1, progress=False, file=tmp_path / "sweep.npz", **TIP))


def test_a_row_that_is_refused_does_not_disturb_the_others(limb, pressures, batch) -> None:
    wild = pressures.copy()
    bad = np.arange(5, len(wild), 100)
    wild[bad, 1] = 5e6  # far beyond what the tubes bear
    found = limb.sweep(wild, progress=False, **TIP)
    assert (~found.success).nonzero()[0].tolist() == bad.tolist()
    assert all("has no stable state" in found.failures[row] for row in bad)
    good = np.setdiff1d(np.arange(len(wild)), bad)
    # Another set of rows, another fit: the same answers to the tolerance.
    assert np.abs(found.plates[good] - batch.plates[good]).max() < 2e-6


@pytest.mark.parametrize(
    "option",
    [
        {"prefer_stable": False},
        {"prefer_stable": False, "ordered": True},
        {"tip_held": [False, True, False, False, False, False]},
    ],
)
def test_rows_with_a_start_of_their_own_have_no_atlas(limb, option, monkeypatch) -> None:
    option = dict(option)
    ordered = option.pop("ordered", False)
    seen = []
    whole = rows.solve_rows

    def watched(*args, **options):
        seen.append(options["atlas"])
        return whole(*args, **options)

    monkeypatch.setattr(rows, "solve_rows", watched)
    monkeypatch.setattr(run, "_LONG", 64)
    given = some_pressures(64)
    limb.sweep(given, progress=False, ordered=ordered, **TIP, **option)
    assert seen and all(atlas is None for atlas in seen)


def test_an_atlas_with_a_start_is_refused(limb, pressures) -> None:
    atlas = rows.survey_rows(limb, pressures[:128], threads=1, tick=lambda _: True, **TIP)
    assert atlas is not None and min(atlas.terms) > 9
    copied = pickle.loads(pickle.dumps(atlas))
    assert copied.terms == atlas.terms
    with pytest.raises(ValueError, match="atlas must be None"):
        rows.solve_rows(
            limb, pressures[:4], threads=1, ordered=False, tick=lambda _: True, atlas=atlas, prefer_stable=False, **TIP
        )


def test_the_surveyed_rows_are_the_same_in_any_order_and_all_different(pressures) -> None:
    twice = np.concatenate([pressures, pressures[::-1]])
    some = run._some_rows(twice, 100)
    assert len(np.unique(some, axis=0)) == 100
    order = np.random.default_rng(1).permutation(len(twice))
    np.testing.assert_array_equal(some, run._some_rows(twice[order], 100))
    np.testing.assert_array_equal(run._some_rows(np.array([[0.0, -0.0], [-0.0, 0.0]]), 5), [[0.0, 0.0]])


@pytest.fixture(scope="module")
def grid():
    """Three axes of 13 pressures, whose last line is not a whole one: groups of 32 rows begin anywhere in a line."""
    axis = np.linspace(0.0, 40e3, 13)
    return np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)[:-4]


@pytest.fixture(scope="module")
def chained(limb, grid):
    return limb.sweep(grid, threads=1, ordered=True, progress=False, **TIP)


def test_groups_side_by_side_have_the_answers_of_groups_one_by_one(limb, grid, chained, monkeypatch) -> None:
    assert len(grid) >= LONG
    assert chained.success.all() and chained.stable.all() and (chained.unstable_modes == 0).all()
    assert set(chained.message) == {"converged"}
    monkeypatch.setattr(run, "_LONG", 10 * len(grid))
    single = limb.sweep(grid, ordered=True, progress=False, **TIP)
    assert np.abs(chained.plates - single.plates).max() < 2e-6
    np.testing.assert_allclose(chained.clearance, single.clearance, atol=2e-6)
    assert not np.array_equal(chained.tip, single.tip)
    # Most rows take one linearisation, where the others of their line lead.
    assert np.median(chained.iterations) == 1


def test_no_bit_of_groups_side_by_side_depends_on_threads_or_processes(limb, grid, chained) -> None:
    assert same_bits(chained, limb.sweep(grid, threads=2, ordered=True, progress=False, **TIP))
    with ProcessPoolExecutor(2) as pool:
        assert same_bits(chained, limb.sweep(grid, executor=pool, ordered=True, progress=False, **TIP))


def test_a_refused_row_does_not_disturb_its_group(limb, grid, chained) -> None:
    wild = grid.copy()
    bad = np.arange(5, len(wild), 100)
    wild[bad, 1] = 5e6  # far beyond what the tubes bear
    found = limb.sweep(wild, ordered=True, progress=False, **TIP)
    assert (~found.success).nonzero()[0].tolist() == bad.tolist()
    good = np.setdiff1d(np.arange(len(wild)), bad)
    assert np.abs(found.plates[good] - chained.plates[good]).max() < 2e-6


def test_an_ordered_sweep_whose_rows_jump_is_solved_all_the_same(limb, pressures, batch) -> None:
    found = limb.sweep(pressures, ordered=True, progress=False, **TIP)
    assert found.success.all() and found.stable.all()
    assert np.abs(found.plates - batch.plates).max() < 2e-6
