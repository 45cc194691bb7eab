"""`softlimb bench`: its unit of time is the agreed loop, its rows say what they should, it refuses wrong answers.

No test here says how fast anything is.
"""

from __future__ import annotations

import copy
import dataclasses
import json
import math
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import softlimb as sl
from softlimb import _core, presets
from softlimb.bench import checks, instructions, limbs, omissions, others, speed
from softlimb.bench.clock import Clock, Samples
from softlimb.bench.core_calls import CoreCalls
from softlimb.bench.figures import three_digits
from softlimb.cli import bench, main
from softlimb.paper.problem import Answer
from softlimb.units import kPa, us

PRESSURES = np.array([30.0, 20.0, 10.0]) * kPa
BRIEF = speed.Effort(steps=3, cold=2, sweep_rows=20, limit=20.0)


@pytest.fixture(scope="module")
def segment() -> sl.Limb:
    return presets.reference_limb(["proximal"])


@pytest.fixture(scope="module")
def posture(segment: sl.Limb) -> sl.Posture:
    return segment.solve(PRESSURES, **limbs.loads())


def relabelled(posture: sl.Posture, **claims: Any) -> sl.Posture:
    """The posture under a false claim: of another tolerance, or of pressures that it was not solved for."""
    other = copy.copy(posture)
    for name, value in claims.items():
        setattr(other, name, value)
    return other


def measured(name: str) -> list[speed.Row]:
    (entry,) = [entry for entry in speed.ENTRIES if entry.name == name]
    return list(entry.measure(entry, Clock(budget=0.0), BRIEF))


# --- the unit of time ------------------------------------------------------------------------------------------------


def test_the_yardstick_does_the_agreed_arithmetic() -> None:
    microseconds, checksum = _core.yardstick(repetitions=1)
    assert microseconds > 0.0
    assert f"{checksum:.6f}" == "0.159407"
    assert _core.yardstick(repetitions=2)[1] == checksum
    with pytest.raises(ValueError, match="repetitions must be at least 1, got 0"):
        _core.yardstick(repetitions=0)


def test_the_yardstick_agrees_with_the_program_that_defines_it(shared: Path, tmp_path: Path) -> None:
    compiler, source = shutil.which("g++"), shared / "yardstick.cpp"
    if compiler is None or not source.is_file():
        pytest.skip("no g++, or no yardstick.cpp in the shared folder")
    program = tmp_path / "yardstick"
    subprocess.run([compiler, "-O3", "-std=c++17", str(source), "-o", str(program)], check=True)
    printed = subprocess.run([str(program)], capture_output=True, text=True, check=True).stdout
    found = re.search(r"checksum (\S+)", printed)
    assert found, printed
    assert f"{_core.yardstick(repetitions=1)[1]:.6f}" == found.group(1)


def test_the_build_says_what_it_is() -> None:
    info = _core.build_info()
    assert set(info) == {"compiler", "flags", "standard", "target", "assertions"}
    assert all(info.values())
    assert info["flags"] != "unknown"


def test_every_sample_has_the_yardsticks_around_it(monkeypatch: pytest.MonkeyPatch) -> None:
    readings = iter(range(1, 100))
    monkeypatch.setattr(_core, "yardstick", lambda repetitions: (float(next(readings)), 0.0))
    order: list[str] = []

    def way(name: str, seconds: Any) -> Any:
        return lambda: order.append(name) or seconds

    found = Clock(budget=0.0).in_turn({"a": way("a", 3.0), "b": way("b", [1.0, 2.0])}, (2, 2))
    assert order == ["a", "b"] * 3  # in turn, after a round that warms up
    assert_allclose(found["a"].yardsticks / us, [1.5, 3.5])
    assert_allclose(found["b"].yardsticks / us, [2.5, 2.5, 4.5, 4.5])
    assert_allclose(found["a"].seconds, 3.0)
    assert_allclose(found["b"].ratios * us, [1 / 2.5, 2 / 2.5, 1 / 4.5, 2 / 4.5])


def test_a_sample_takes_at_least_the_shortest_time() -> None:
    runs: list[int] = []
    question = speed.Question([lambda: runs.append(1) or []], lambda _: None, solves=4)
    (seconds,) = question.timed(question.walks, shortest=0.002)
    assert len(runs) > 1
    assert seconds * 4 * len(runs) >= 0.002
    runs.clear()
    question.timed(question.walks)
    assert len(runs) == 1


def test_a_figure_is_met_by_less_and_a_gain_by_more() -> None:
    time, gain = speed.Goal(15.0, 8.0), speed.Goal(1.9, 1.95, "times")
    assert [time.met(value) for value in (8.0, 8.1, 15.0, 15.1, np.nan)] == ["aim", "yes", "yes", "no", "no"]
    assert [gain.met(value) for value in (1.95, 1.9, 1.8)] == ["aim", "yes", "no"]


# --- calls of the core -----------------------------------------------------------------------------------------------


def test_calls_of_the_core_are_written_down_and_can_be_made_again(segment: sl.Limb) -> None:
    before = dict(vars(_core.Geometry))
    calls = CoreCalls.of(lambda: segment.solve(PRESSURES, **limbs.loads()))
    assert dict(vars(_core.Geometry)) == before
    assert any(isinstance(call.result, _core.Posture) for call in calls.calls)
    assert calls.fault() is None
    calls.again()
    names = list(calls.counts())
    assert sum(len(calls.only(name).calls) for name in names) == len(calls.calls)


def test_arguments_are_kept_as_they_were_at_the_call(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_core, "total", math.fsum, raising=False)  # a compiled function like those of the core
    values = [1.0, 2.0]

    def ask() -> None:
        _core.total(values)
        values[:] = [5.0]
        _core.total(values)

    calls = CoreCalls.of(ask)
    assert calls.counts() == {"total": 2}
    assert [call.arguments for call in calls.calls] == [([1.0, 2.0],), ([5.0],)]


def test_the_core_is_left_alone_when_a_question_fails() -> None:
    before = dict(vars(_core.Tube)), _core.yardstick

    def ask() -> None:
        raise RuntimeError("no answer")

    with pytest.raises(RuntimeError, match="no answer"):
        CoreCalls.of(ask)
    assert (dict(vars(_core.Tube)), _core.yardstick) == before


def test_calls_that_answer_otherwise_the_second_time_do_not_stand_for_the_question(segment: sl.Limb) -> None:
    assert CoreCalls.of(lambda: None).fault() == "no call of the core was seen"
    calls = CoreCalls.of(lambda: segment.solve(PRESSURES))
    those_of_another = CoreCalls.of(lambda: segment.solve(2.0 * PRESSURES)).calls
    changed = [
        dataclasses.replace(call, result=other.result)
        for call, other in zip(calls.calls, those_of_another, strict=True)
    ]
    fault = CoreCalls(changed).fault()
    assert fault is not None and "another posture" in fault


# --- wrong answers are refused ---------------------------------------------------------------------------------------


def test_a_right_posture_passes_and_wrong_ones_are_refused(segment: sl.Limb, posture: sl.Posture) -> None:
    assert checks.posture_fault(posture, segment.solve(PRESSURES, tolerance=1e-9, **limbs.loads())) is None
    elsewhere = checks.posture_fault(posture, segment.solve(1.01 * PRESSURES, **limbs.loads()))
    assert elsewhere is not None and "the tip is off by" in elsewhere
    coarse = relabelled(segment.solve(PRESSURES, tolerance=0.1, **limbs.loads()), tolerance=1e-12)
    unverified = checks.posture_fault(coarse)
    assert unverified is not None and "verification finds" in unverified
    standing = presets.reference_limb().solve(np.zeros(9), gravity=(0.0, 0.0, -9.81), prefer_stable=False)
    assert standing.success and not standing.stable
    unstable = checks.posture_fault(standing)
    assert unstable is not None and "not stable" in unstable
    beyond = segment.solve([10e6, 0.0, 0.0])
    assert not beyond.success
    failed = checks.posture_fault(beyond)
    assert failed is not None and "no equilibrium" in failed


def test_points_apart_and_points_that_are_no_numbers_are_refused() -> None:
    assert checks.distance_fault(np.zeros(3), np.full(3, 1e-8), 1e-7) is None
    for wrong in (1e-6, np.nan):
        assert checks.distance_fault(np.zeros(3), np.full(3, wrong), 1e-7, "the platform") is not None


def test_wrong_states_and_sections_of_a_tube_are_refused() -> None:
    tube = presets.reference_limb().segments[0].actuators[0]
    other = presets.reference_limb().segments[1].actuators[0]
    pressures = limbs.zigzag(40)
    assert checks.state_fault(tube, tube.inflate(pressures)) is None
    assert checks.state_fault(tube, other.inflate(pressures)) == "the stretch does not give the pressure back"
    assert checks.state_fault(tube, tube.inflate(pressures * 1e3)) == "a tube found no state"
    assert checks.section_fault(tube, 30.0 * kPa, tube.section(30.0 * kPa)) is None
    wrong = checks.section_fault(tube, 30.0 * kPa, tube.section(30.1 * kPa))
    assert wrong is not None and "EA is" in wrong


def test_a_wrong_jacobian_is_refused(segment: sl.Limb, posture: sl.Posture) -> None:
    assert checks.jacobian_fault(posture) is None
    wrong = relabelled(posture)
    wrong.__dict__["jacobian"] = 1.01 * posture.jacobian
    fault = checks.jacobian_fault(wrong)
    assert fault is not None and "Jacobian" in fault
    assert checks.jacobian_fault(relabelled(posture, pressures=None)) is not None


def test_wrong_sweeps_are_refused(segment: sl.Limb) -> None:
    loads = limbs.loads()
    batch = segment.sweep(limbs.random_pressures(4, 3, 1), progress=False, **loads)
    assert checks.batch_fault(segment, batch, loads) is None
    moved = dataclasses.replace(batch, tip=batch.tip + 1e-4)
    fault = checks.batch_fault(segment, moved, loads)
    assert fault is not None and "the tip of row 0 is off" in fault
    failed = dataclasses.replace(batch, success=np.array([True, True, False, True]), message=["", "", "lost", ""])
    fault = checks.batch_fault(segment, failed, loads)
    assert fault is not None and "1 of 4 rows failed, row 2: lost" in fault
    assert checks.same_bits_fault(batch, dataclasses.replace(batch)) is None
    tip = batch.tip.copy()
    tip[3, 0, 3] = np.nextafter(tip[3, 0, 3], 1.0)
    assert checks.same_bits_fault(batch, dataclasses.replace(batch, tip=tip)) == "tip differs"
    assert checks.same_bits_fault(batch, dataclasses.replace(batch, message=["?"] * 4)) == "message differs"


def test_wrong_answers_of_other_methods_are_refused(posture: sl.Posture) -> None:
    shooting, algorithm = others.METHODS[2], others.METHODS[3]
    assert algorithm.finds_lengths and not shooting.finds_lengths
    right = Answer(True, "converged", plates=posture.plates, lengths=posture.rest_lengths)
    for method in (shooting, algorithm):
        assert others.answer_fault(method, right, posture)[::2] == (None, "")
    off = posture.plates.copy()
    off[-1, 0, 3] += 1e-3 * posture.limb.length
    fault, distance, _ = others.answer_fault(shooting, dataclasses.replace(right, plates=off), posture)
    assert fault is not None
    assert distance == pytest.approx(1e-3, rel=1e-6)
    # The paper's algorithm has the tip from us: only its lengths can be wrong.
    lengths = posture.rest_lengths * [1.01, 1.0, 1.0]
    fault, _, _ = others.answer_fault(algorithm, dataclasses.replace(right, lengths=lengths), posture)
    assert fault is not None


@pytest.mark.parametrize("name", ["warm", "cold", "segment", "six-legs", "cantilever", "jacobian", "python", "sweep"])
def test_no_row_times_wrong_postures(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    # Every solve at the tolerance of the row is of slightly different loads; the finer ones of the checks are right.
    solve = sl.Limb.solve

    def wrong(self: sl.Limb, *given: Any, **options: Any) -> sl.Posture:
        finer = options.get("tolerance", 1e-6) < 1e-8
        push = 0.0 if finer else 1e-2
        force = np.asarray(options.pop("tip_force", np.zeros(3))) + push
        return solve(self, *given, tip_force=force, **options)

    sweep = sl.Limb.sweep

    def wrong_sweep(self: sl.Limb, *given: Any, **options: Any) -> Any:
        force = np.asarray(options.pop("tip_force", np.zeros(3))) + 1e-2
        return sweep(self, *given, tip_force=force, **options)

    monkeypatch.setattr(sl.Limb, "solve", wrong)
    monkeypatch.setattr(sl.Limb, "sweep", wrong_sweep)
    if name in ("cold", "cantilever"):  # no truth but their own verification, which takes the wrong load for given
        monkeypatch.setattr(sl.Posture, "verify", lambda self: sl.Verification(1e-3, 0.0, 0.0, 0.0, 0.0, 1e-6))
    rows = measured(name)
    assert rows and all(row.wrong and row.samples is None for row in rows)


@pytest.mark.parametrize(("name", "what"), [("tube", "state_fault"), ("section", "section_fault")])
def test_no_row_times_wrong_tubes(name: str, what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checks, what, lambda *_: "injected")
    (row,) = measured(name)
    assert row.wrong and row.remark == "wrong: injected"


def swept_with_more_arguments(spoilt: bool) -> Any:
    """`Limb.sweep` as it may become, by a sweep that takes neither threads nor an order."""
    from softlimb.sweep import sweep

    def more(self: sl.Limb, pressures: Any, *, threads: int = 1, ordered: bool = False, **options: Any) -> Any:
        batch = sweep(self, pressures, **options)
        if spoilt and (threads == 2 or ordered):
            batch.tip[:] *= 1.0 + 1e-4
        return batch

    return more


def test_sweeps_with_threads_and_order_are_timed_where_they_are_right(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.cpu_count", lambda: 2)
    monkeypatch.setattr(sl.Limb, "sweep", swept_with_more_arguments(spoilt=False))
    (grid,), (threads,) = measured("grid"), measured("threads")
    assert grid.samples is not None and threads.samples is not None
    assert grid.samples.seconds.size == 1  # all rows at once
    assert threads.figures.size == threads.samples.seconds.size == 1
    monkeypatch.setattr(sl.Limb, "sweep", swept_with_more_arguments(spoilt=True))
    (grid,), (threads,) = measured("grid"), measured("threads")
    assert grid.wrong and "the tip of row" in grid.remark
    assert threads.wrong and "tip differs" in threads.remark


def test_rows_that_fail_while_they_are_timed_spoil_the_sweep(monkeypatch: pytest.MonkeyPatch) -> None:
    sweep, count = sl.Limb.sweep, iter(range(100))

    def tiring(self: sl.Limb, *given: Any, **options: Any) -> Any:
        batch = sweep(self, *given, **options)
        batch.success[0] = next(count) < 1  # the check's own sweep succeeds
        return batch

    monkeypatch.setattr(sl.Limb, "sweep", tiring)
    (row,) = measured("sweep")
    assert row.wrong and "rows failed while they were timed" in row.remark


# --- other methods ---------------------------------------------------------------------------------------------------


def others_on(scene: str, limit: float = 20.0) -> Iterator[others.Outcome]:
    (chosen,) = [s for s in others.SCENES if s.name == scene]
    return others.compare(chosen, Clock(budget=0.0), limit, compiled=False)


def test_other_methods_are_timed_where_they_are_right() -> None:
    pytest.importorskip("scipy")
    found = {outcome.method: outcome for outcome in others_on("other-rod", limit=60.0)}
    assert found.pop("PyElastica, relaxed").samples is None
    assert found["softlimb"].times_ours == pytest.approx(1.0)
    for outcome in found.values():
        assert outcome.outcome.startswith("right"), outcome
        assert outcome.times_ours is not None and outcome.times_ours > 0.0
        json.dumps(outcome.to_dict(), allow_nan=False)


def test_without_scipy_the_command_names_the_extra_that_is_missing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    monkeypatch.setitem(sys.modules, "scipy", None)  # as where it is not installed
    assert main(["bench", "--quick", "--only", "other-rod"]) == 0
    printed = capsys.readouterr().out
    assert printed.count("scipy is missing: pip install 'softlimb[bench]'") == 2
    assert re.search(r"Newton, shooting in numpy +right", printed)


def test_methods_that_are_wrong_or_late_are_not_timed(monkeypatch: pytest.MonkeyPatch) -> None:
    def near(posture: sl.Posture, _: float) -> Answer:
        plates = posture.plates.copy()
        plates[-1, 2, 3] += 2e-4 * posture.limb.length
        return Answer(True, "converged", plates=plates, lengths=posture.rest_lengths)

    methods = (
        others.Method("wrong", near),
        others.Method("late", lambda *_: Answer(False, "gave up", iterations=7)),
        others.Method("missing", near, needs="a_module_that_nobody_has"),
    )
    monkeypatch.setattr(others, "METHODS", methods)
    ours, wrong, late, missing = others_on("other-segment")
    assert ours.samples is not None
    assert wrong.outcome == "wrong" and "is off by" in wrong.detail and wrong.samples is None
    assert wrong.to_dict()["tip_off"] == pytest.approx(2e-4, rel=1e-2)
    assert late.outcome == "gave up after 20 s" and late.samples is None
    assert missing.outcome == "left out" and "pip install 'softlimb[bench]'" in missing.detail


def test_nothing_is_compared_with_a_wrong_posture_of_ours(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sl.Posture, "verify", lambda self: sl.Verification(1e-3, 0.0, 0.0, 0.0, 0.0, 1e-6))
    (ours,) = others_on("other-segment")
    assert ours.outcome == "wrong" and ours.samples is None


# --- what a scene does not need --------------------------------------------------------------------------------------


def omission(**changes: Any) -> omissions.Omission:
    first = omissions.OMISSIONS[0]
    return dataclasses.replace(first, **changes)


@pytest.fixture
def planned(monkeypatch: pytest.MonkeyPatch) -> None:
    """Plans that name gravity where there is none at all."""
    plan = property(lambda self: () if np.any(self.loads["gravity"]) else ("no gravity: its terms left out",))
    monkeypatch.setattr(sl.Posture, "plan", plan)


def test_what_no_plan_names_makes_no_row() -> None:
    assert omissions.measure(omission(words=("something that no solve leaves out",)), Clock(budget=0.0)) is None


def test_what_a_plan_names_is_timed_with_and_without(planned: None) -> None:
    row = omissions.measure(omission(), Clock(budget=0.0))
    assert row is not None and row.fault is None and row.saved is not None
    assert json.dumps(row.to_dict(), allow_nan=False)


@pytest.mark.parametrize(
    ("with_it", "fault"),
    [
        ({"pressures": omissions._APART}, "left out where it is there"),
        ({"pressures": omissions._EQUAL, "gravity": limbs.HANGING}, "the tip without it is off by"),
    ],
)
def test_what_changes_the_answer_is_no_omission(planned: None, with_it: dict[str, Any], fault: str) -> None:
    row = omissions.measure(omission(with_it=with_it), Clock(budget=0.0))
    assert row is not None and row.fault is not None and fault in row.fault
    assert row.saved is None and row.to_dict()["fault"] == row.fault


def test_the_traces_of_what_may_be_left_out_do_not_move_the_tip() -> None:
    for part in omissions.OMISSIONS:
        both = [omissions._solved(part.limb(), {**options, "tolerance": 1e-9})
                for options in (part.with_it, part.without_it)]
        for full, bare in zip(*both, strict=True):
            assert full.success and bare.success
            # A force of 1e-12 N on a limb as compliant as 0.1 m/N, and both tolerances.
            assert_allclose(full.tip, bare.tip, rtol=0.0, atol=2e-9)


# --- instructions ----------------------------------------------------------------------------------------------------


def test_work_runs_and_unknown_work_is_refused() -> None:
    assert instructions.work("yardstick", 1) == instructions.PASSES
    assert instructions.work("warm", 1) == 10
    with pytest.raises(ValueError, match=r"work must be yardstick, warm or cold, got 'hot'"):
        instructions.work("hot", 1)


@pytest.mark.slow  # valgrind starts Python twice
def test_start_up_cancels_from_the_instructions() -> None:
    if not instructions.available():
        pytest.skip("no valgrind on PATH")
    count = instructions.counted("yardstick", 1)
    # 9 rods of 8 steps of 4 stages and as many updates, in all about 700 floating-point operations a step.
    assert 9 * 8 * 400 < count < 9 * 8 * 2000


def test_without_valgrind_the_command_says_so(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> None:
    monkeypatch.setattr(instructions, "available", lambda: False)
    assert main(["bench", "--quick", "--only", "tube", "--instructions"]) == 0
    assert "valgrind is not on PATH" in capsys.readouterr().out


# --- the command -----------------------------------------------------------------------------------------------------


def test_the_command_prints_rows_and_writes_figures(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    names = ["segment", "tube", "python", "other-rod", "no-gravity"]
    file = tmp_path / "figures.json"
    assert main(["bench", "--quick", "--only", *names, "--json", str(file)]) == 0
    printed = capsys.readouterr().out
    assert max(map(len, printed.splitlines())) <= 110
    for text in ("segment of 3", "tube, state", "Python call", "one hanging rod", "Table 3", "processor", "flags"):
        assert text in printed, text
    figures = json.loads(file.read_text(encoding="utf-8"))
    assert {row["name"] for row in figures["speed"]} == {"segment", "tube", "python"}
    rows = [row for row in figures["speed"] if "median_us" in row]
    assert [row["way"] for row in rows] == ["C++", "Python", "C++", "Python", ""]
    for row in rows:
        numbers = [row["median_us"], *row["quartiles_us"], row["value"], row["ratio_to_yardstick"]]
        # What Python adds is a difference of two times, each of which a busy machine may stretch.
        if row["name"] != "python":
            assert np.all(np.array([*numbers, *row["seconds"], *row["yardstick_seconds"]]) > 0.0)
        assert np.isfinite(numbers).all()
        assert row["met"] in ("aim", "yes", "no")
    ours = next(outcome for outcome in figures["others"] if outcome["method"] == "softlimb")
    assert ours["outcome"] == "right, verified" and ours["median_ms"] > 0.0
    assert figures["yardstick"]["median_us"] > 0.0
    assert figures["machine"]["numpy"] == np.__version__


def test_an_unknown_row_is_refused_by_name_with_the_list(capsys: pytest.CaptureFixture) -> None:
    assert main(["bench", "--only", "warm", "wram"]) == 2
    error = capsys.readouterr().err
    assert "'wram'" in error
    for entry in (*speed.ENTRIES, *others.SCENES, *omissions.OMISSIONS):
        assert entry.name in error


def test_a_refused_answer_is_printed_and_ends_with_one(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    monkeypatch.setattr(checks, "state_fault", lambda *_: "injected")
    assert main(["bench", "--quick", "--only", "tube"]) == 1
    assert "wrong: injected" in capsys.readouterr().out


@pytest.mark.parametrize(("microseconds", "void"), [([6.6, 6.7], False), ([9.5, 9.6], True), ([6.6, 6.7, 8.9], False)])
def test_a_run_on_a_busy_machine_is_void(
    microseconds: list[float], void: bool, capsys: pytest.CaptureFixture
) -> None:
    found = bench._yardstick(np.array(microseconds) * us, 0.159407)
    printed = capsys.readouterr().out
    assert found["void"] is void and ("VOID" in printed) is void
    assert ("changed its speed" in printed) is (max(microseconds) > 1.2 * min(microseconds))


def test_the_names_of_rows_differ() -> None:
    names = [entry.name for entry in (*speed.ENTRIES, *others.SCENES, *omissions.OMISSIONS)]
    assert len(set(names)) == len(names)


def test_pressures_of_a_walk_change_by_one_per_cent() -> None:
    for rows in (limbs.walk(50, 9, 1), limbs.zigzag(500)[:, None]):
        assert_allclose(np.abs(np.diff(np.log(rows), axis=0)), np.log(1.01), rtol=1e-9)
        assert rows.max() < 80.0 * kPa
    grid = limbs.fine_grid(1000, 3)
    assert grid.shape == (1000, 9) and len(np.unique(grid, axis=0)) == 1000
    assert grid.min() == 0.0 and grid.max() == 60.0 * kPa


def test_figures_have_three_digits() -> None:
    shown = [three_digits(x) for x in (12345.6, 123.4, 12.34, 1.234, 0.1234, 9.0, -384.2, float("nan"))]
    assert shown == ["12346", "123", "12.3", "1.23", "0.123", "9", "-384", "-"]


def test_what_takes_longer_less_what_takes_none() -> None:
    one, other = (Samples(np.array([a, 3.0]), np.ones(2)) for a in (2.0, 1.0))
    assert_allclose(one.less(other).seconds, [1.0, 0.0])


def test_the_header_names_the_instruction_set(monkeypatch: pytest.MonkeyPatch) -> None:
    from softlimb.bench import machine

    fake = SimpleNamespace(build_info=_core.build_info, instruction_set=lambda: "x86-64-v3")
    monkeypatch.setattr(machine, "_core", fake)
    assert machine.instruction_set() == "x86-64-v3"
    monkeypatch.setattr(machine, "_core", SimpleNamespace(build_info=_core.build_info))
    assert machine.machine()["instruction set"] == "baseline"
