"""Signals, metrics, tuning, and controllers side by side on the plant; the command ``softlimb control``."""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from softlimb import plot
from softlimb.cli import main
from softlimb.control import (
    DISTURBANCES,
    PID,
    SIGNALS,
    Chamber,
    Disturbance,
    Event,
    Gas,
    Guard,
    NeuralPID,
    Pneumatics,
    PressureLoop,
    Sensor,
    Signal,
    Supply,
    Trace,
    Valve,
    best_pid,
    candidates,
    compare,
    follow,
    learning_from,
    learning_limit,
    metrics,
    simc,
    staircase,
    step_test,
    steps,
)
from softlimb.presets import reference_limb
from softlimb.units import kPa, ms

GOAL = np.array([90, 60, 50]) * kPa


@pytest.fixture(scope="module")
def plant() -> Pneumatics:
    """One actuator of each segment of the reference limb."""
    return Pneumatics([segment.actuators[0] for segment in reference_limb().segments])


# Signals and metrics


def test_the_staircase_of_sixty_has_the_papers_pressures() -> None:
    signal = staircase([60 * kPa])
    assert_allclose(np.unique(signal.targets), np.array([20, 40, 60]) * kPa, rtol=1e-15)
    assert list(signal.jumps) == [0, 800, 1600, 2400, 3200]
    assert signal.seconds == 4.0


def test_ramps_and_sines_hold_nothing_and_count_no_jump() -> None:
    for name in ("ramp", "sine"):
        signal = SIGNALS[name](GOAL)
        assert len(signal.jumps) == 0
        assert signal.targets.max() <= GOAL.max() and signal.targets.min() >= 0.0


def trace_of(signal: Signal, pressures: np.ndarray) -> Trace:
    n, a = pressures.shape
    rows = np.zeros((n, a))
    time = np.arange(n) * signal.period
    return Trace(time, signal.targets, rows, pressures, rows, rows, np.zeros((n, a, 3)), time, 0.0, (), True)


def test_metrics_of_an_exponential_approach_are_its_closed_forms() -> None:
    size, tau, period = 50 * kPa, 0.2, 1 * ms
    signal = steps([size], hold=4.0, period=period)
    time = np.arange(4000) * period
    decay = np.exp(-time / tau)
    pressures = np.concatenate([size * (1 - decay), size * (0.5 + 0.5 * decay), size * (1 - 0.5 * decay)])[:, None]
    found = metrics(trace_of(signal, pressures), signal)
    areas = 1.0 + 0.5 + 0.5
    # sums of rectangles instead of integrals: half a period at the start, over tau
    assert_allclose(found.iae, areas * size * tau, rtol=0.6 * period / tau)
    assert_allclose(found.itae, areas * size * tau**2, rtol=1e-4)
    assert_allclose(found.settling, tau * np.log(20.0), atol=period)
    assert found.overshoot == 0.0 and found.unsettled == 0
    assert_allclose(found.steady_error, 0.0, atol=size * np.exp(-16.0))


def test_overshoot_is_a_share_of_the_jump_and_what_does_not_settle_is_counted() -> None:
    signal = steps([20 * kPa, 0.0], hold=1.0)
    pressures = signal.targets.copy()
    pressures[300, 0] += 5 * kPa  # of a jump of 20 kPa
    pressures[1300, 0] -= 5 * kPa  # of one of 10 kPa, downwards
    pressures[-1, 0] += 2 * kPa
    found = metrics(trace_of(signal, pressures), signal)
    assert_allclose(found.overshoot, np.mean([0.25, 0.5, 0.2]), rtol=1e-12)
    assert found.unsettled == 1
    assert_allclose(found.settling, np.mean([0.301, 0.301]), rtol=1e-12)


# Tuning


def test_the_step_test_finds_the_rate_and_delay_of_a_choked_rigid_chamber() -> None:
    chamber = Chamber(np.array([0.0, 500 * kPa]), np.full(2, 2e-4))
    valve = Valve(dead_band=0.0, hysteresis=0.0)
    pneumatics = Pneumatics([chamber], valve=valve, gas=Gas(exponent=1.0), supply=Supply(volume=10.0))
    found = step_test(pneumatics, between=(10e3, 40e3))[0]
    in_line = np.pi / 4 * 0.0025**2
    rate = 1e-9 * 1.185 * (250 * kPa + 101325) * 287.05 * 293.15 / (2e-4 + in_line)
    assert_allclose(found.gain, rate, rtol=5e-3)  # the line's own pressure still rises a little less than the chamber's
    # dead time, lag and half a period; the line's time constant and the sub-steps are half a millisecond
    assert_allclose(found.delay, 13.5 * ms, atol=0.5 * ms)


def test_the_rule_is_simc_and_holds_its_targets(plant: Pneumatics) -> None:
    rule = simc(plant)
    for controller, test in zip(rule, step_test(plant), strict=True):
        gain, integral, difference = controller.weights
        assert_allclose(gain, 100 * kPa / (2 * test.gain * test.delay), rtol=1e-12)
        assert_allclose(integral, gain / (8 * test.delay), rtol=1e-12)
        assert difference == 0.0
    signal = steps(GOAL)
    found = metrics(follow(plant, rule, signal), signal)
    # half of a converter's code, and a tenth of the jumps
    assert found.steady_error < 1 * kPa and found.unsettled <= 1 and found.overshoot < 0.1


def test_the_papers_sign_runs_into_the_supply_or_the_atmosphere(plant: Pneumatics) -> None:
    weights = simc(plant)[0].weights
    for controller in (PID(weights, sign="printed"), NeuralPID(weights, rates=0.1, sign="printed")):
        trace = PressureLoop(plant, controller).run(np.tile(GOAL, (1500, 1)))
        assert np.abs(trace.errors[-1]).min() > 40 * kPa


def test_a_neural_pid_mends_weights_that_are_ten_times_too_small(plant: Pneumatics) -> None:
    rule = simc(plant)
    weak = [one.replaced(weights=tuple(0.1 * w for w in one.weights)) for one in rule]
    signal = staircase(GOAL)
    learning = learning_from(weak, 0.1, learning="normalised")
    fixed, learned, tuned = (metrics(follow(plant, c, signal), signal).iae for c in (weak, learning, rule))
    # It closes more than half of the gap to the weights that the rule gives.
    assert learned < 0.5 * (fixed + tuned)


def test_a_search_by_nlopt_is_no_worse_than_the_rule_it_starts_from(plant: Pneumatics) -> None:
    pytest.importorskip("nlopt")
    signals = [staircase(GOAL, hold=0.3)]
    found = best_pid(plant, signals, evaluations=16)
    assert found.evaluations <= 18  # NLopt may finish the point it is at
    rule = np.mean([metrics(follow(plant, simc(plant), signal), signal).iae for signal in signals])
    assert found.iae <= rule
    assert 0.05 <= found.numbers[0] <= 5.0


def test_without_nlopt_the_search_says_what_to_install(plant: Pneumatics, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "nlopt", None)
    with pytest.raises(ModuleNotFoundError, match=r"softlimb\[design\]"):
        best_pid(plant, [staircase(GOAL)], evaluations=10)


def test_learning_rates_beyond_the_limit_slam_the_valve_and_those_below_hold(plant: Pneumatics) -> None:
    few = Pneumatics(plant.chambers[1:2])
    start = simc(few)
    found = learning_limit(few, start, rates=[0.1, 1.0, 1e4], learning="normalised")
    assert found.limit is not None and 1.0 < found.limit < 1e4
    assert found.chatter[0] < 0.1 < found.threshold < found.chatter[-1]
    below, above = (
        learning_limit(few, start, rates=[rate], learning="normalised").chatter[0]
        for rate in (found.limit / 2, found.limit * 2)
    )
    assert below < found.threshold < above
    assert found.held and found.unlearned < 0.1


def test_learning_is_not_blamed_for_what_does_not_hold_without_it(plant: Pneumatics) -> None:
    few = Pneumatics(plant.chambers[1:2])
    # the paper's error feeds back positively at any rate, zero included
    found = learning_limit(few, simc(few), rates=[1e-4, 1e4], sign="printed")
    assert found.limit is None and not found.held
    assert found.unlearned > found.threshold and (found.chatter > found.threshold).all()


# Disturbances


@pytest.mark.parametrize("name", [name for name in DISTURBANCES if name != "none"])
def test_every_disturbance_is_felt_and_none_breaks_the_loop(plant: Pneumatics, name: str) -> None:
    signal = staircase(GOAL, hold=0.3)
    rule = simc(plant)
    calm, disturbed = follow(plant, rule, signal), follow(plant, rule, signal, DISTURBANCES[name])
    assert disturbed.solved and len(disturbed.time) == len(signal.targets)
    # the same seed: without the disturbance both would be the same to the last bit
    assert np.abs(disturbed.pressures - calm.pressures).max() > 0.1 * kPa
    assert disturbed.pressures.min() > -1 * kPa and disturbed.pressures.max() < 110 * kPa


def test_a_run_in_parts_is_the_run_in_one(plant: Pneumatics) -> None:
    targets = steps(GOAL, hold=0.2).targets
    controller = NeuralPID((10.0, 50.0, 0.0), rates=0.1)
    whole = PressureLoop(plant, controller).run(targets)
    loop = PressureLoop(plant, controller)
    parts = Trace.joined([loop.run(targets[:77]), loop.run(targets[77:])])
    for name in ("time", "pressures", "readings", "commands", "weights"):
        assert (getattr(whole, name) == getattr(parts, name)).all()
    assert controller.weights == (10.0, 50.0, 0.0)  # what it learned in the loop stayed there


# Guards


def guarded(pneumatics: Pneumatics, **options) -> PressureLoop:
    learning = learning_from(simc(pneumatics), 0.1, learning="normalised", **options)
    return PressureLoop(pneumatics, learning, guard=Guard())


@pytest.mark.parametrize("seed", range(4))
def test_a_sensor_that_sticks_while_a_target_stands_is_found_before_the_pressure_has_gone_far(
    plant: Pneumatics, seed: int
) -> None:
    loop = guarded(plant.replaced(seed=seed))
    targets = np.tile(GOAL, (1500, 1))
    assert not loop.run(targets).faults
    loop.plant.set_sensor(0, fault="stuck")
    trace = loop.run(np.repeat(targets, 4, axis=0))
    assert [(fault.kind, fault.channel) for fault in trace.faults] == [("sensor_stuck", 0)]
    found = np.searchsorted(trace.time, trace.faults[0].time)
    # Air of 12 steps of full flow at most, a fifth of 60 as a code of 0.2 kPa is of 1 kPa. Before that the integral
    # crawled through the dead band, and nothing moved.
    rate = step_test(plant)[0].gain
    assert np.abs(trace.pressures[:found, 0] - GOAL[0]).max() < 12 * ms * rate + 0.5 * kPa
    assert trace.pressures[:, 0].max() < GOAL[0] + 15 * ms * rate  # and what was on its way
    assert trace.pressures[-1].max() < 5 * kPa


@pytest.mark.parametrize("sensor", [Sensor(noise=0.0), Sensor(bits=8), Sensor(noise=0.0, bits=8)], ids=str)
@pytest.mark.parametrize("name", ["none", "load change", "valve x 0.5"])
def test_a_healthy_sensor_without_noise_or_with_few_bits_is_no_fault(
    plant: Pneumatics, sensor: Sensor, name: str
) -> None:
    healthy = plant.replaced(sensor=sensor)
    learning = learning_from(simc(healthy), 0.1, learning="normalised")
    hold = Signal("hold", np.tile(GOAL, (4000, 1)), plant.period)
    # beyond the range of the valve, and back to nothing
    down = Signal("down", np.repeat(np.outer([1.0, 0.0], GOAL), 2000, axis=0), plant.period)
    for signal in (hold, staircase(GOAL), down, SIGNALS["sine"](GOAL)):
        for controllers in (learning, simc(healthy)):
            trace = follow(healthy, controllers, signal, name, guard=Guard())
            assert not trace.faults, (signal.name, trace.faults[0].message)


@pytest.mark.parametrize("limits", [(-1.0, 1.0), (-0.5, 0.5)])
def test_a_stuck_valve_is_found_whatever_the_limits_and_the_target(
    plant: Pneumatics, limits: tuple[float, float]
) -> None:
    time = np.arange(3000) * ms
    for change in (
        np.full(3000, 30 * kPa),
        np.full(3000, 4.5 * kPa),
        15 * kPa * np.sin(2 * np.pi * time),
        15 * kPa * np.sin(4 * np.pi * time),
    ):
        loop = guarded(plant, limits=limits)
        assert not loop.run(np.tile(GOAL, (1500, 1))).faults
        loop.plant.set_valve_stuck(1, True)
        trace = loop.run(GOAL + change[:, None] * [0.0, 1.0, 0.0])
        assert [(fault.kind, fault.channel) for fault in trace.faults] == [("no_response", 1)]


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_command_that_leads_away_from_the_target_is_a_fault(plant: Pneumatics, sign: float) -> None:
    rule = simc(plant)
    options = {"sign": "printed"} if sign > 0.0 else {}
    wrong = [one.replaced(weights=tuple(sign * w for w in one.weights), **options) for one in rule]
    trace = PressureLoop(plant, wrong, guard=Guard()).run(np.tile(GOAL, (1000, 1)))
    assert trace.faults[0].kind == "wrong_way" and "away from the target" in trace.faults[0].message
    assert trace.faults[0].time < 0.5  # 400 steps, and what it takes to reach the limit


def test_a_target_that_no_air_can_reach_is_a_fault(plant: Pneumatics) -> None:
    loop = guarded(plant.replaced(supply=Supply(pressure=100 * kPa)))
    trace = loop.run(np.full((8000, 3), 120 * kPa))  # the pump refills slowly near its stop, and the pressure creeps
    assert trace.faults[0].kind == "no_response"


def test_a_guard_asks_of_a_weak_supply_what_it_gives(plant: Pneumatics) -> None:
    weak = plant.replaced(supply=Supply(pressure=100 * kPa))
    trace = guarded(weak).run(np.full((1000, 3), 40 * kPa))
    assert not trace.faults and np.abs(trace.errors[-1]).max() < 2 * kPa
    with pytest.raises(ValueError, match="lowest_supply of a Guard must be below the supply's 100000 Pa, got 120000"):
        PressureLoop(weak, PID((1, 1, 1)), guard=Guard(lowest_supply=120 * kPa))


# The comparison and its command


def test_the_comparison_has_a_row_for_every_run_and_says_which_names_it_knows(plant: Pneumatics) -> None:
    group = {"one": [PID((10.0, 10.0, 0.0))] * 3}
    found = compare(plant, GOAL, group, signals=["ramp"], disturbances=["none", "leak"])
    assert [(row.signal, row.disturbance) for row in found.rows] == [
        ("ramp", "none"), ("staircase", "none"), ("staircase", "leak"),
    ]  # fmt: skip
    assert found.found("one", "ramp").iae > 0.0
    with pytest.raises(KeyError):
        found.found("two", "ramp")
    with pytest.raises(ValueError, match="unknown signal 'jump'"):
        compare(plant, GOAL, group, signals=["jump"])


def test_searched_candidates_beat_the_rule_on_what_they_were_searched_for() -> None:
    pytest.importorskip("nlopt")
    distal = reference_limb(["distal"])
    pneumatics = Pneumatics(distal)
    goal = np.array([50.0, 50.0, 20.0]) * kPa
    made = candidates(pneumatics, goal, evaluations=10)
    assert len(made) == 7 and all(len(group) == 3 for group in made.values())
    found = compare(pneumatics, goal, made, disturbances=["none"])
    means = {name: np.mean([found.found(name, signal).iae for signal in SIGNALS]) for name in made}
    # on all three actuators, of which one was searched on
    assert means["fixed, best found"] <= 1.01 * means["fixed, SIMC"]


def test_the_command_prints_tables_and_writes_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture, table = tmp_path / "c.png", tmp_path / "c.csv"
    assert main(["control", "bend-2", "--output", str(picture), "--table", str(table)]) == 0
    said = capsys.readouterr().out
    assert "steady error [kPa]" in said and "neural, normalised, from SIMC/10" in said and "supply drop" in said
    assert picture.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    with table.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 6 * (len(SIGNALS) + len(DISTURBANCES) - 1)
    assert all(np.isfinite(float(row["iae_Pa_s"])) for row in rows)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["bend-2", "--evaluations", "3"], "--evaluations must be 0, or at least 10"),
        (["bend-2", "--seed", "-1"], "--seed must not be negative"),
        (["bend-2", "--pressures-kPa", "0", "0", "0"], "--pressures-kPa must not all be zero"),
        (["bend-2", "--pressures-kPa", "-5", "9", "0"], "--pressures-kPa must not be negative"),
        (["bend-1", "--pressures-kPa", "-10", "-10", "-10"], "must not be negative to be followed, got -10 kPa"),
        (["bend-1", "--pressures-kPa", "300", "0", "0"], "--pressures-kPa must be at most the 150 kPa that the guard"),
        (["bend-1", "--pressures-kPa", "60000", "0", "0"], "got 60000 kPa"),
        (["bend-2", "--seeds", "2"], "--seeds needs a --task"),
        (["bend-2", "--task", "carry", "--pressures-kPa", "1", "2", "3"], "--pressures-kPa goes with the comparison"),
        (["bend-2", "--task", "carry", "--disturbed", "steps"], "--disturbed goes with the comparison"),
        (["bend-2", "--task", "carry", "--learning-limits"], "--learning-limits goes with the comparison"),
        (["bend-2", "--task", "carry", "--evaluations", "0"], "--evaluations goes with the comparison"),
        (["bend-2", "--table", "x.png"], "--table must end in .csv, got x.png"),
        (["bend-2", "--disturbed", "jump"], "invalid choice"),
    ],
)
def test_the_command_refuses_what_makes_no_sense(
    arguments: list[str], says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["control", *arguments]) == 2
    assert says in capsys.readouterr().err


def test_a_folder_that_takes_no_files_is_refused_before_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("tempfile.TemporaryFile", full)
    assert main(["control", "bend-2", "--output", str(tmp_path / "x.png")]) == 2
    said = capsys.readouterr().err
    assert "--output" in said and "No space left on device" in said


def test_learning_limits_say_what_does_not_hold_without_learning(
    plant: Pneumatics, monkeypatch: pytest.MonkeyPatch
) -> None:
    from softlimb.cli import control

    monkeypatch.setattr(control, "LEARNING_RULES", {"as printed": {"sign": "printed", "rates": [1.0]}})
    assert "as printed: not held even without learning (rms command 1.00)" in control._limits(
        Pneumatics(plant.chambers[:1])
    )


def test_pictures_have_their_labels_and_refuse_channels_that_are_not_there(plant: Pneumatics) -> None:
    trace = PressureLoop(plant, PID((10.0, 10.0, 0.0))).run(np.tile(GOAL, (50, 1)))
    labels = [axes.get_ylabel() for axes in plot.pressure_control(trace, [0, 2]).axes]
    assert labels == ["gauge pressure [kPa]", "command", "weights, actuator 0"]
    assert plot.pressure_control(trace, title="fixed; hold").get_suptitle() == "fixed; hold"
    with pytest.raises(ValueError, match="channels must be one to 4 of 0 to 2"):
        plot.pressure_control(trace, [3])
    found = learning_limit(Pneumatics(plant.chambers[:1]), simc(plant)[:1], rates=[1.0])
    assert [axes.get_xlabel() for axes in plot.learning({"gradient": found}).axes] == [
        "learning rate of all weights"
    ] * 2


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda p: staircase([-1.0]), "goal must be a row of pressures"),
        (lambda p: follow(p, PID((1, 1, 1)), staircase(GOAL, period=2 * ms)), "period of the signal"),
        (lambda p: PressureLoop(p, [PID((1, 1, 1))]), "one a chamber"),
        (lambda p: PressureLoop(p, PID((1, 1, 1), period=0.1)), "period of a controller"),
        (lambda p: PressureLoop(p, PID((1, 1, 1))).run(np.zeros((3, 2))), "targets has shape"),
        (lambda p: PressureLoop(p, PID((1, 1, 1))).run(np.full((3, 3), np.nan)), "targets must be finite"),
        (lambda p: learning_limit(p, simc(p), rates=[2.0, 1.0]), "rates must be a rising row"),
        (lambda p: Trace.joined([]), "traces to join"),
        (lambda p: learning_limit(p, simc(p), threshold=np.nan), "threshold must be finite and positive"),
        (lambda p: learning_limit(p, simc(p), threshold=1.0), "threshold must be below 1"),
        (lambda p: step_test(p, command=2.0), "command must be at most 1"),
        (lambda p: step_test(p, between=(1e4, 2e3)), "between must be two rising pressures"),
        (lambda p: step_test(p, between=(1e4,)), "between has shape"),
        (lambda p: best_pid(p, [], evaluations=10), "signals must be at least one"),
        (lambda p: steps(GOAL, hold=1e-4), "hold must be at least a period"),
        (lambda p: SIGNALS["sine"](GOAL, seconds=1e-5), "targets of a Signal must be"),
        (lambda p: Signal("x", np.full((3, 1), np.nan), 1 * ms), "targets of a Signal must be finite"),
        (lambda p: Signal("x", np.zeros(3), 1 * ms), "targets of a Signal must be"),
        (lambda p: Signal("x", np.zeros((0, 3)), 1 * ms), "targets of a Signal must be"),
        (lambda p: Signal("x", np.zeros((3, 1)), -1.0), "period of a Signal"),
        (lambda p: Event(np.nan, print), "share of an Event"),
        (lambda p: follow(p, PID((1, 1, 1)), staircase(GOAL), "hole"), 'disturbance must be one of .*"leak"'),
        (lambda p: Guard(response_command=2.0), "response_command of a Guard must be a share"),
        (lambda p: Guard(stuck_effort=np.nan), "stuck_effort of a Guard"),
        (lambda p: Guard(supply_steps=2**31), "supply_steps of a Guard"),
    ],
)
def test_bad_arguments_are_refused_by_name(plant: Pneumatics, make, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        make(plant)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda p: PressureLoop(p, PID((1, 1, 1)), guard="x"), "guard must be of type Guard, got 'x'"),
        (lambda p: PressureLoop("x", PID((1, 1, 1))), "pneumatics must be of type Pneumatics"),
        (lambda p: follow(p, PID((1, 1, 1)), staircase(GOAL), 3), "disturbance must be of type Disturbance or str"),
        (lambda p: follow(p, PID((1, 1, 1)), GOAL), "signal must be of type Signal"),
        (lambda p: Event(0.5, 3), "happens of an Event must be a function, got 3"),
        (lambda p: Disturbance("x", (3,)), r"events\[0\] of a Disturbance must be of type Event, got 3"),
        (lambda p: Disturbance("x", (), 3), "other of a Disturbance must be a function"),
        (lambda p: Signal(3, np.zeros((3, 1)), 1 * ms), "name of a Signal must be of type str"),
    ],
)
def test_other_types_are_refused_by_name(plant: Pneumatics, make, says: str) -> None:
    with pytest.raises(TypeError, match=says):
        make(plant)


def test_a_disturbance_goes_by_its_name(plant: Pneumatics) -> None:
    signal = staircase(GOAL, hold=0.05)
    by_name, itself = (follow(plant, simc(plant), signal, one) for one in ("leak", DISTURBANCES["leak"]))
    assert (by_name.pressures == itself.pressures).all()
