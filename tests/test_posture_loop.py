"""The posture loop: tasks, limbs that are not the model, correction; and faults, which all end vented and said."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from frames import turn
from softlimb import plot
from softlimb.cli import main
from softlimb.control import (
    PID,
    TASKS,
    Guard,
    Incident,
    Perturbation,
    Pneumatics,
    PoseSensor,
    PostureControl,
    PressureLoop,
    Sensor,
    Task,
    TrueLimb,
    Valve,
    carry,
    circle,
    eight,
    posture_study,
    run_task,
    simc,
    still,
)
from softlimb.control.tasks import LENGTH
from softlimb.limb import Limb
from softlimb.presets import reference_limb
from softlimb.units import deg, kPa, mm, ms

HANGING = (0.0, 0.0, 9.81)


@pytest.fixture(scope="module")
def limb():
    return reference_limb()


# Tasks


@pytest.mark.parametrize("task", [make() for make in TASKS.values()], ids=list(TASKS))
def test_tasks_move_smoothly_and_stop_where_they_end(task: Task) -> None:
    time = np.linspace(0.0, task.seconds, 20001)
    places = np.array([task.place(t) for t in time])
    speeds = np.linalg.norm(np.diff(places, axis=0), axis=1) / np.diff(time)
    assert speeds.max() < 0.2  # [m/s]
    # A speed that jumped would change within one interval by much more than the mean acceleration does.
    assert np.abs(np.diff(speeds)).max() < 0.01 * speeds.max()
    assert speeds[0] < 1e-3 and speeds[-1] < 1e-3
    assert (task.place(-1.0) == task.place(0.0)).all() and (task.place(99.0) == task.place(task.seconds)).all()


def test_the_load_is_there_between_grasp_and_release() -> None:
    task = carry(weight=0.1)
    phases = {name: time for time, name in task.phases}
    loads = [np.linalg.norm(task.load(t)) for t in (phases["grasp"] - 0.01, phases["grasp"], phases["release"] - 0.01)]
    assert_allclose(loads, [0.0, 0.1, 0.1], rtol=1e-15)
    assert not task.load(phases["release"]).any()


def test_the_circle_closes_and_keeps_its_radius() -> None:
    task = circle(60 * mm, seconds=5.0)
    places = np.array([task.place(t) for t in np.linspace(2.0, 7.0, 200)]) - task.home
    assert_allclose(np.linalg.norm(places, axis=1), 60 * mm, rtol=1e-12)
    assert_allclose(places[0], places[-1], atol=1e-15)
    assert np.ptp(np.array([eight().place(t)[2] for t in np.linspace(0, 12, 200)])) > 20 * mm  # the eight is in space


# The true limb


def test_a_limb_that_is_not_perturbed_is_its_model(limb) -> None:
    pressures = np.linspace(20, 60, 9) * kPa
    found = TrueLimb(limb, Perturbation.none(limb), HANGING).solve(pressures, (0.1, 0.0, 0.0))
    expected = limb.solve(pressures, gravity=HANGING, tip_force=(0.1, 0.0, 0.0))
    assert_allclose(found.tip, expected.tip, atol=2e-6)  # twice the tolerance of a posture


def test_a_tilted_base_tilts_gravity_and_load_and_the_tip_comes_back_in_the_first_frame(limb) -> None:
    tilt = np.array([0.0, 3 * deg, 0.0])
    off = replace(Perturbation.none(limb), tilt=tilt)
    pressures, force = np.linspace(20, 60, 9) * kPa, np.array([0.1, 0.05, 0.0])
    true = TrueLimb(limb, off, HANGING)
    found = true.tip_of(true.solve(pressures, force))
    turned = turn(tilt)
    inside = limb.solve(pressures, gravity=turned.T @ HANGING, tip_force=turned.T @ force)
    assert_allclose(found[:3, 3], turned @ inside.tip[:3, 3], atol=2e-6)
    assert_allclose(found[:3, :3], turned @ inside.tip[:3, :3], atol=1e-5)


def test_stiffness_strain_and_plate_mass_count_as_they_say(limb) -> None:
    none, pressures = Perturbation.none(limb), np.full(9, 40 * kPa)
    no_weight = (0.0, 0.0, 0.0)
    true = TrueLimb(limb, replace(none, strain=np.full(9, 1.1)), no_weight)
    posture = true.solve(pressures, np.zeros(3))
    straight = limb.solve(pressures).tip[2, 3]
    plates = sum(segment.plate.thickness for segment in limb.segments[:-1])
    rest = sum(segment.length for segment in limb.segments)
    # without weight nothing else stretches the rods: each of them is as long as it says
    assert_allclose(true.tip_of(posture)[2, 3], rest + 1.1 * (straight - plates - rest) + plates, atol=2e-6)
    force = np.array([1e-3, 0.0, 0.0])
    soft, model = (
        TrueLimb(limb, replace(none, bending=factor * none.bending, axial=factor * none.axial), no_weight)
        for factor in (0.8, 1.0)
    )
    deflections = [one.tip_of(one.solve(pressures, force))[0, 3] for one in (soft, model)]
    # Shear stays as it was, and is a small part of it.
    assert 1.15 < deflections[0] / deflections[1] < 1.25
    heavy, light = (
        TrueLimb(limb, replace(none, plate_mass=np.full(3, factor)), HANGING).solve(pressures, np.zeros(3))
        for factor in (1.05, 1.0)
    )
    masses = sum(segment.plate.mass for segment in limb.segments)
    assert_allclose((light.base_wrench - heavy.base_wrench)[2], 0.05 * masses * 9.81, rtol=1e-6)


def test_seeds_draw_within_their_bounds_and_again_the_same(limb) -> None:
    for seed in range(20):
        off, again = Perturbation.drawn(limb, seed), Perturbation.drawn(limb, seed)
        assert (off.bending == again.bending).all() and (off.tilt == again.tilt).all()
        for values, bound in ((off.bending, 0.2), (off.axial, 0.2), (off.strain, 0.1), (off.plate_mass, 0.05)):
            assert np.abs(values - 1.0).max() <= bound and np.ptp(values) > 0.0
        assert_allclose(np.abs(off.pressure_offset), 1 * kPa, rtol=1e-15)
        assert_allclose(np.linalg.norm(off.tilt), 1 * deg, rtol=1e-12)
        assert off.tilt[2] == 0.0


# The loop


def short(task: Task, seconds: float) -> Task:
    return replace(task, seconds=seconds)


def test_the_model_follows_its_own_limb_and_the_task_is_done(limb) -> None:
    run = run_task(limb, short(carry(pace=0.5), 2.5))
    assert run.success and run.message == "done" and run.reached.all()
    # What is left is the delay of the pressures at 0.1 m/s and codes of 0.2 kPa, which move the tip by a millimetre.
    assert run.errors.largest < 10 * mm
    assert run.trace.solved
    assert len(run.time) == len(run.tip) == round((2.5 + 2.5) / 0.02)
    assert_allclose(run.errors.shares()[0], run.errors.mean / 0.65, rtol=1e-12)


@pytest.mark.parametrize("seed", [0, 1])
def test_correction_takes_most_of_the_error_of_a_limb_that_is_not_the_model(limb, seed: int) -> None:
    found = next(posture_study(limb, still((60 * mm, 0.0, 0.0), seconds=2.0), [seed]))
    assert found.open_loop.success and found.closed_loop.success
    open_error, closed_error = found.open_loop.errors.mean, found.closed_loop.errors.mean
    assert open_error > 4 * mm  # that there is something to correct
    # Settled for 2.5 s, twelve time constants: what is left is noise of 0.5 mm in three axes and the pressures' codes.
    assert closed_error < 2 * mm


def test_a_load_that_is_not_known_is_corrected(limb) -> None:
    force = np.array([0.0, 0.1, 0.0])
    task = replace(still(seconds=3.0), load=lambda time: force if time >= 0.5 else np.zeros(3))
    run = run_task(limb, task)
    moved = run.distances
    loaded, late = moved[(run.time > 0.5) & (run.time < 0.7)], moved[run.time > 2.0]
    assert loaded.max() > 2 * mm and late.mean() < 0.5 * loaded.max()


def test_the_same_seeds_give_the_same_run(limb) -> None:
    task = still(seconds=0.2)
    rows = [run_task(limb, task, sensor=PoseSensor(seed=3), settling=0.2).tip for _ in range(2)]
    assert (rows[0] == rows[1]).all()


def test_an_offset_of_the_sensors_is_an_offset_of_the_pressures(limb) -> None:
    off = replace(Perturbation.none(limb), pressure_offset=np.full(9, 1 * kPa))
    run = run_task(limb, still(seconds=0.5), control=PostureControl(closed=False), perturbation=off, settling=2.5)
    # a code is 0.2 kPa, and the valve's dead band lets the pressure stay as far off
    assert_allclose((run.commanded - run.pressures)[-1], 1 * kPa, atol=0.4 * kPa)


# Faults: bounded, said, vented


def vented(run) -> None:
    """What every fault must end in: the pressures are gone, and nothing was ever out of bounds."""
    assert not run.success
    assert run.pressures[-1].max() < 8 * kPa
    assert run.pressures.max() < 110 * kPa and run.pressures.min() > -1 * kPa
    assert (np.abs(run.trace.commands) <= 1.0).all()
    assert "vented" in run.message


def faulty(limb, happens, **options):
    """A task during which something happens at 0.4 s."""
    options.setdefault("task", still((40 * mm, 0.0, 0.0), seconds=2.0))
    task = options.pop("task")
    return run_task(limb, task, incidents=[Incident(0.4, happens)], settling=1.5, after=2.0, **options)


def test_a_pressure_sensor_that_gives_no_number_ends_control(limb) -> None:
    run = faulty(limb, lambda loop, _: loop.plant.set_sensor(4, fault="not_finite"))
    vented(run)
    fault = run.faults[0]
    assert (fault.kind, fault.channel) == ("sensor_not_finite", 4)
    assert 0.4 <= fault.time <= 0.4 + 10 * ms  # five readings
    assert "actuator 4: the pressure sensor gives no number" in run.message


def test_one_lost_reading_is_no_fault() -> None:
    pneumatics = Pneumatics([tube.actuators[0] for tube in reference_limb().segments])
    loop = PressureLoop(pneumatics, simc(pneumatics), guard=Guard())
    targets = np.full((50, 3), 30 * kPa)
    loop.run(targets)
    loop.plant.set_sensor(0, fault="not_finite")
    assert np.isnan(loop.run(targets[:3]).readings[:, 0]).all()
    loop.plant.set_sensor(0)
    trace = loop.run(np.repeat(targets, 10, axis=0))
    assert not trace.faults and np.abs(trace.errors[-1]).max() < 2 * kPa


def test_a_stuck_pressure_sensor_ends_control_before_the_pressure_is_out_of_bounds(limb) -> None:
    run = faulty(
        limb,
        lambda loop, _: loop.plant.set_sensor(0, fault="stuck"),
        task=carry(pace=0.3),  # it has to move to be found
    )
    vented(run)
    assert (run.faults[0].kind, run.faults[0].channel) == ("sensor_stuck", 0)


def test_a_valve_that_is_stuck_open_is_vented_past_it(limb) -> None:
    def happens(loop, _) -> None:
        loop.plant.set_valve_stuck(2, True)

    # Caught while it feeds: a target that jumps up has it open when it sticks.
    task = replace(still(seconds=2.0), offset=lambda time: np.array([0.0, 0.0, 40 * mm if time >= 0.34 else -20 * mm]))
    run = faulty(limb, happens, task=task)
    vented(run)
    assert run.faults[0].kind in ("over_pressure", "no_response") and run.faults[0].channel == 2


def test_a_valve_that_is_stuck_shut_is_found_where_it_is_needed(limb) -> None:
    task = replace(still(seconds=2.0), offset=lambda time: np.array([0.0, 0.0, 40 * mm if time >= 0.5 else 0.0]))
    run = faulty(limb, lambda loop, _: loop.plant.set_valve_stuck(7, True), task=task)
    vented(run)
    assert (run.faults[0].kind, run.faults[0].channel) == ("no_response", 7)


def test_a_lost_supply_ends_control(limb) -> None:
    run = faulty(limb, lambda loop, _: loop.plant.set_supply(pump_share=0.0, leak=1e-6))
    vented(run)
    assert run.faults[0].kind == "supply_lost"


def test_a_target_that_is_out_of_reach_is_held_for_a_while_and_then_vented(limb) -> None:
    far = replace(still(seconds=2.0), offset=lambda time: np.array([0.6 if time >= 0.4 else 0.0, 0.0, 0.0]))
    run = faulty(limb, lambda *_: None, task=far)
    vented(run)
    fault = run.faults[0]
    assert fault.kind == "out_of_reach" and "out of reach" in fault.detail
    assert_allclose(fault.time, 0.4 + 0.3, atol=0.05)  # its patience
    held = run.commanded[(run.time > 0.44) & (run.time < fault.time)]
    assert np.ptp(held, axis=0).max() == 0.0 and not run.reached[run.time > 0.5].any()


@pytest.mark.parametrize(("fault", "kind"), [("not_finite", "pose_not_finite"), ("stuck", "pose_stuck")])
def test_a_lost_pose_ends_control_where_it_is_needed_and_only_there(limb, fault: str, kind: str) -> None:
    def happens(_, sensor: PoseSensor) -> None:
        sensor.fault = fault

    run = faulty(limb, happens)
    vented(run)
    assert run.faults[0].kind == kind
    blind = faulty(limb, happens, control=PostureControl(closed=False))
    assert blind.success


def test_a_correction_that_stays_at_its_bound_is_a_fault(limb) -> None:
    heavy = replace(still(seconds=3.0), load=lambda time: np.array([2.0 if time > 0.2 else 0.0, 0.0, 0.0]))
    run = run_task(limb, heavy, settling=1.5)
    vented(run)
    assert run.faults[0].kind == "correction_limit" and "at a correction of 80 mm" in run.message
    assert run.faults[0].time < 2.0


def test_a_slow_plant_at_the_bound_of_its_correction_is_no_fault(limb) -> None:
    slow = Pneumatics(limb, valve=Valve(conductance=1.5e-10, exhaust_conductance=1.5e-10))
    run = run_task(limb, still((60 * mm, 0.0, 0.0), seconds=3.0), pneumatics=slow, settling=0.0)
    assert run.success, run.message
    assert run.distances[0] > 50 * mm and run.distances[-1] < 10 * mm


def test_a_first_target_out_of_reach_is_searched_for_once_before_the_clock_starts(limb, monkeypatch) -> None:
    starts = []
    plain = Limb.reach

    def counted(self, **options):
        starts.append(options["starts"])
        return plain(self, **options)

    monkeypatch.setattr(Limb, "reach", counted)
    run = run_task(limb, still((0.6, 0.0, 0.0), seconds=0.5), settling=0.1, after=1.5)
    vented(run)
    assert run.faults[0].kind == "out_of_reach"
    assert starts[0] > 0 and not any(starts[1:])
    assert len(starts) < 4  # no step looks again for what did not come nearer, but for the first large correction


def test_a_target_that_comes_back_into_reach_is_searched_for_again(limb) -> None:
    away = replace(still(seconds=1.5), offset=lambda time: np.array([0.6 if 0.4 <= time < 0.6 else 0.0, 0.0, 0.0]))
    run = run_task(limb, away, settling=1.0)
    assert run.success and not run.reached.all() and run.reached[run.time > 0.7].all()
    assert run.distances[-1] < 10 * mm


@pytest.mark.parametrize("what", ["offset", "load"])
def test_a_task_that_gives_no_number_on_its_way_ends_vented(limb, what: str) -> None:
    bad = replace(still(seconds=1.0), **{what: lambda time: np.full(3, np.nan if time > 0.4 else 0.0)})
    run = run_task(limb, bad, settling=0.5, after=1.5)
    vented(run)
    fault = run.faults[0]
    assert (fault.kind, fault.detail) == ("task_not_finite", what)
    assert_allclose(fault.time, 0.4, atol=0.03)
    assert np.isfinite(run.errors.mean) and np.isfinite(run.load).all()


def test_a_guard_that_is_healthy_says_nothing_in_any_task(limb) -> None:
    run = run_task(limb, short(eight(seconds=3.0), 3.0))  # four times as fast as by default
    assert not run.faults


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda limb: PostureControl(period=0.0), "period"),
        (lambda limb: PostureControl(closed=1), "closed must be True or False"),  # type: ignore[arg-type]
        (lambda limb: run_task(limb, still(), control=PostureControl(period=1.5 * ms)), "multiple of the plant's"),
        (lambda limb: run_task(limb, still(), pneumatics=Pneumatics(limb._tubes[:2])), "pneumatics has 2 chambers"),
        (lambda limb: run_task(limb, still(), controllers=[PID((1, 1, 1))]), "one a chamber"),
        (lambda limb: run_task(limb, still(), gravity=(0, 0, np.nan)), "gravity must be finite"),
        (lambda limb: run_task(limb, still(), keep=0), "keep"),
        (lambda limb: Perturbation.drawn(limb, -1), "seed"),
        (lambda limb: Perturbation.drawn(limb, 0, strain=-0.1), "strain"),
        (lambda limb: carry(weight=-1.0), "weight"),
        (lambda limb: carry(direction=(0, 0, 0)), "direction"),
        (lambda limb: PoseSensor(position_noise=-1.0), "position_noise"),
        (lambda limb: Guard(supply_steps=0), "supply_steps"),
        (lambda limb: Sensor(noise=np.inf), "noise"),
        (lambda limb: short(still(), -1.0), "seconds of a Task"),
        (lambda limb: short(still(), np.nan), "seconds of a Task"),
        (lambda limb: replace(still(), home=(0.0, 0.0)), "home of a Task has shape"),
        (lambda limb: replace(still(), offset=lambda t: np.zeros(2)).place(0.0), "offset of the task has shape"),
        (lambda limb: run_task(limb, replace(still(), load=lambda t: np.full(3, np.nan))), "load at the start"),
        (lambda limb: run_task(limb, still(seconds=0.01), settling=0, after=0), "must be at least a period"),
        (lambda limb: run_task(limb, still(), control=PostureControl(period=10.0)), "must be at least a period"),
        (lambda limb: run_task(limb, still(), incidents=[Incident(-100.0, print)]), r"time of incidents\[0\] must be"),
        (lambda limb: Incident(np.nan, print), "time of an Incident"),
        (lambda limb: PoseSensor(fault="bogus"), "fault of a PoseSensor must be one of"),
        (lambda limb: PoseSensor(seed=-1), "seed of a PoseSensor"),
        (lambda limb: PoseSensor(seed=np.nan), "seed of a PoseSensor"),
        (lambda limb: PoseSensor().read(np.eye(3)), r"pose has shape \(3, 3\)"),
        (lambda limb: replace(Perturbation.none(limb), axial=np.ones(3)), "axial of a Perturbation has shape"),
        (lambda limb: replace(Perturbation.none(limb), bending=np.full(9, np.nan)), "bending of a Perturbation"),
        (lambda limb: replace(Perturbation.none(limb), plate_mass=-np.ones(3)), "plate_mass of a Perturbation must"),
        (lambda limb: replace(Perturbation.none(limb), tilt=(0, 0, 5.0)), "given in degrees"),
        (
            lambda limb: run_task(limb, still(), perturbation=replace(Perturbation.none(limb), plate_mass=np.ones(2))),
            "plate_mass of a Perturbation has shape",
        ),
    ],
)
def test_bad_arguments_are_refused_by_name(limb, make, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        make(limb)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"task": None}, "task must be of type Task, got None"),
        ({"guard": 3}, "guard must be of type Guard, got 3"),
        ({"control": 3}, "control must be of type PostureControl"),
        ({"sensor": 3}, "sensor must be of type PoseSensor"),
        ({"incidents": [3]}, r"incidents\[0\] must be of type Incident"),
    ],
)
def test_other_types_are_refused_by_name(limb, options, says: str) -> None:
    with pytest.raises(TypeError, match=says):
        run_task(limb, **{"task": still(), **options})


def test_what_is_to_be_called_must_be_a_function() -> None:
    with pytest.raises(TypeError, match="offset of a Task must be a function"):
        replace(still(), offset=3)
    with pytest.raises(TypeError, match="happens of an Incident must be a function"):
        Incident(0.0, 3)  # type: ignore[arg-type]


def test_a_task_scales_with_the_limb_and_keeps_its_load() -> None:
    task = carry()
    half = task.scaled(0.5)
    for time in (0.0, 2.0, 5.0, 11.0):
        home = np.array(task.home)
        assert_allclose(half.place(time) - home, 0.5 * (task.place(time) - home), atol=1e-15)
        assert (half.force(time) == task.force(time)).all()
    assert_allclose(reference_limb().length, LENGTH, rtol=1e-15)


# Pictures and the command


@pytest.fixture(scope="module")
def runs(limb):
    task = carry(pace=0.1)
    return {name: run_task(limb, task, control=PostureControl(closed=name == "closed loop"), keep=20)
            for name in ("open loop", "closed loop")}  # fmt: skip


def test_the_tips_path_is_drawn_beside_the_one_that_was_wanted(runs, limb) -> None:
    figure = plot.tip_path(runs)
    space, time = figure.axes
    assert [line.get_label() for line in space.lines] == ["wanted", "open loop", "closed loop"]
    assert space.get_zlabel() == "z [mm]" and time.get_ylabel() == "distance of tip from target [mm]"
    assert_allclose(time.lines[0].get_ydata()[-1], runs["open loop"].distances[-1] / mm, rtol=1e-12)
    low, high = space.get_zlim()
    assert low > high  # it hangs
    with pytest.raises(ValueError, match="runs must be of one task, got carry, still"):
        plot.tip_path({"a": runs["open loop"], "b": run_task(limb, still(seconds=0.04), settling=0.04)})


def test_pictures_say_that_control_ended(limb, tmp_path: Path, monkeypatch) -> None:
    from matplotlib.animation import PillowWriter
    from PIL import Image

    task = short(carry(pace=0.1), 0.9)
    run = run_task(limb, task, incidents=[Incident(0.3, lambda loop, _: loop.vent())], settling=0.2, keep=20)
    lost = run_task(
        limb, task, incidents=[Incident(0.3, lambda loop, _: loop.plant.set_sensor(0, fault="not_finite"))],
        settling=0.2, keep=20, after=0.5,
    )  # fmt: skip
    assert run.success and not lost.success
    title = plot.tip_path({"calm": run, "lost": lost}).axes[1].get_title(loc="left")
    assert title == "lost: vented at 0.30 s"
    frames = []
    grab = PillowWriter.grab_frame

    def said(writer: PillowWriter) -> None:
        frames.append((writer.fig.get_suptitle(), [axes.get_ylabel() for axes in writer.fig.axes]))
        grab(writer)

    monkeypatch.setattr(PillowWriter, "grab_frame", said)
    path = plot.animation(lost, tmp_path / "lost.gif")
    assert "approach" in frames[0][0] and frames[-1][0].endswith("s, vented")
    assert frames[-1][1] == ["z [mm]", "z [mm]", "gauge pressure [kPa]"]
    with Image.open(path) as film:
        assert film.size[0] > 600


def test_a_flat_path_says_how_much_larger_its_height_is_drawn(limb) -> None:
    run = run_task(limb, short(circle(seconds=2.0), 3.0))
    said = [text.get_text() for text in plot.tip_path({"x": run}).axes[0].texts]
    assert any("drawn larger: " in one and "z x" in one for one in said)


def test_an_animation_has_a_picture_for_every_posture_of_the_task(runs, tmp_path: Path) -> None:
    from PIL import Image

    run = runs["closed loop"]
    path = plot.animation(run, tmp_path / "carry.gif", speed=2.0)
    rows = np.arange(len(run.postures)) * run.kept
    with Image.open(path) as film:
        assert film.n_frames == np.sum(run.time[rows] > 0.0) >= 2
        assert film.info["duration"] == 200  # [ms]: every 0.4 s, twice as fast as life
    with pytest.raises(ValueError, match=r"must be written to a \.gif"):
        plot.animation(run, tmp_path / "carry.mp4")


def test_the_command_lets_limbs_do_a_task(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.setitem(TASKS, "carry", lambda **options: carry(pace=0.1, **options))
    names = {kind: tmp_path / f"run.{kind}" for kind in ("png", "csv", "gif")}
    arguments = ["control", "complex-posture", "--task", "carry", "--seed", "3"]
    arguments += ["--output", str(names["png"]), "--table", str(names["csv"]), "--animation", str(names["gif"])]
    assert main(arguments) == 0
    said = capsys.readouterr().out
    assert "reference length 650.0 mm" in said and "seed   3    open loop:" in said and "; done" in said
    assert len(names["csv"].read_text(encoding="utf-8").splitlines()) == 3
    assert names["png"].read_bytes()[:4] == b"\x89PNG" and names["gif"].read_bytes()[:3] == b"GIF"
    assert main(["control", "complex-posture", "--animation", str(names["gif"])]) == 2
    assert "--animation needs a --task" in capsys.readouterr().err
    assert main(["control", "complex-posture", "--task", "carry", "--seeds", "0"]) == 2
