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
        {"ordered": True},
        {"prefer_stable": False},
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


def test_an_atlas_with_an_order_is_refused(limb, pressures) -> None:
    atlas = rows.survey_rows(limb, pressures[:128], threads=1, tick=lambda _: True, **TIP)
    assert atlas is not None and atlas.terms > 9
    copied = pickle.loads(pickle.dumps(atlas))
    assert copied.terms == atlas.terms
    with pytest.raises(ValueError, match="atlas must be None"):
        rows.solve_rows(limb, pressures[:4], threads=1, ordered=True, tick=lambda _: True, atlas=atlas, **TIP)


def test_the_surveyed_rows_are_the_same_in_any_order_and_all_different(pressures) -> None:
    twice = np.concatenate([pressures, pressures[::-1]])
    some = run._some_rows(twice, 100)
    assert len(np.unique(some, axis=0)) == 100
    order = np.random.default_rng(1).permutation(len(twice))
    np.testing.assert_array_equal(some, run._some_rows(twice[order], 100))
    np.testing.assert_array_equal(run._some_rows(np.array([[0.0, -0.0], [-0.0, 0.0]]), 5), [[0.0, 0.0]])
