"""``softlimb control``: fixed and neural PIDs side by side on a scene's pressures, or a task of its limb's tip."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from softlimb.cli.scene_arguments import add_outputs, add_scene, heading, naming, new_file, save_picture, scene_of
from softlimb.cli.tables import aligned, number, write_csv
from softlimb.units import g, kPa, mm, ms

if TYPE_CHECKING:
    from softlimb.control import Comparison, Metrics, Pneumatics
    from softlimb.scenes import Scene

_SIGNALS = ("steps", "ramp", "sine", "staircase")
_TASKS = ("carry", "circle", "eight")
_HOME = 30 * kPa  # in all actuators: where a task's offsets count from


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Arguments of the subcommand."""
    parser = subparsers.add_parser(
        "control",
        help="compare pressure controllers on the pressures of a scene, or let its limb do a task",
        description="Let fixed and neural PIDs follow steps, a ramp, a sine and a staircase to the scene's pressures "
        "against a pneumatic plant, undisturbed and disturbed, and print what each of them is worth. With --task let "
        "limbs that are not quite the scene's do a task under its gravity, and print how near their tips came.",
    )
    add_scene(parser)
    parser.add_argument(
        "--evaluations",
        type=int,
        metavar="N",
        help="search the best fixed PID and the best learning rates with so many runs each; needs NLopt (default: 0, "
        "no search)",
    )
    parser.add_argument(
        "--disturbed", choices=_SIGNALS, help="the signal that disturbances are tried on (default: staircase)"
    )
    parser.add_argument("--learning-limits", action="store_true", help="find the learning rates that do not settle")
    parser.add_argument("--seed", type=int, default=0, help="of the sensors' noise, and of the first limb (default: 0)")
    parser.add_argument("--task", choices=_TASKS, help="a task of the tip in place of the comparison")
    parser.add_argument("--seeds", type=int, metavar="N", help="so many limbs for a task (default: 1)")
    parser.add_argument(
        "--animation", type=new_file, metavar="GIF", help="of a task: write the last limb's motion, closed loop"
    )
    add_outputs(parser, "write all runs")


def run(arguments: argparse.Namespace) -> int:
    """Compare or do the task, print, write."""
    scene = scene_of(arguments)
    _require_matching(arguments)
    if arguments.seeds is not None and arguments.seeds < 1:
        raise ValueError(f"--seeds must be at least 1, got {arguments.seeds}")
    if arguments.table is not None and arguments.table.suffix.lower() != ".csv":
        raise ValueError(f"--table must end in .csv, got {arguments.table.name}")
    if arguments.animation is not None and (arguments.task is None or arguments.animation.suffix.lower() != ".gif"):
        raise ValueError("--animation needs a --task, and a name that ends in .gif")
    if arguments.evaluations and arguments.evaluations < 10:
        raise ValueError(f"--evaluations must be 0, or at least 10, got {arguments.evaluations}")
    if arguments.seed < 0:
        raise ValueError(f"--seed must not be negative, got {arguments.seed}")
    return _compare(arguments, scene) if arguments.task is None else _do(arguments, scene)


def _require_matching(arguments: argparse.Namespace) -> None:
    """Refuse what would be ignored: options of the comparison with a task, and of a task without one."""
    if arguments.task is None:
        if arguments.seeds is not None:
            raise ValueError("--seeds needs a --task: it counts the limbs that do it")
        return
    for name in ("pressures_kPa", "evaluations", "disturbed", "learning_limits"):
        given = getattr(arguments, name)
        if given is not None and given is not False:
            option = name.replace("_", "-")
            raise ValueError(f"--{option} goes with the comparison of controllers: leave it out with a --task")


def _compare(arguments: argparse.Namespace, scene: Scene) -> int:
    from softlimb.control import Pneumatics, candidates, compare, follow
    from softlimb.control.signals import SIGNALS

    with naming(arguments.scene):
        goal = _goal(arguments, scene)
        pneumatics = Pneumatics(scene.limb, seed=arguments.seed)
    disturbed = arguments.disturbed or "staircase"
    controllers = candidates(pneumatics, goal, evaluations=arguments.evaluations or 0)
    found = compare(pneumatics, goal, controllers, disturbed=disturbed)
    print(heading(arguments.scene, scene))
    print(f"pneumatic plant: {len(pneumatics)} actuators, {pneumatics.period / ms:g} ms a step; its numbers are ours")
    print("SIMC weights of actuator 0: " + " ".join(f"{x:.4g}" for x in controllers["fixed, SIMC"][0].weights))
    for signal in _SIGNALS:
        print(f"\n{signal}, undisturbed")
        print(_signal_table(found, signal))
    print(f"\nintegral of |error| [kPa s] on the {disturbed}, disturbed")
    print(_disturbance_table(found, disturbed))
    if arguments.learning_limits:
        print()
        print(_limits(pneumatics))
    if arguments.table is not None:
        names = ("overshoot", "settling", "unsettled", "iae", "itae", "steady_error", "air")
        header = [
            "controller",
            "signal",
            "disturbance",
            *(f"{name}{unit}" for name, unit in zip(names, _UNITS, strict=True)),
        ]
        rows = [
            [row.controller, row.signal, row.disturbance, *(f"{getattr(row.metrics, name):.12g}" for name in names)]
            for row in found.rows
        ]
        write_csv(arguments.table, header, rows)
    if arguments.output is not None:
        from softlimb import plot

        followed, shown_one = SIGNALS[disturbed](goal, period=pneumatics.period), "neural, normalised"
        trace = follow(pneumatics, controllers[shown_one], followed)
        shown = list(dict.fromkeys(int(np.cumsum([0, *scene.counts])[j]) for j in range(len(scene.counts))))[:4]
        title = f"controller: {shown_one}; signal: {disturbed}; undisturbed"
        save_picture(plot.pressure_control(trace, shown, title=title), arguments.output)
    return 0


def _do(arguments: argparse.Namespace, scene: Scene) -> int:
    from softlimb import plot
    from softlimb.control import TASKS, posture_study
    from softlimb.control.tasks import LENGTH

    _require_actuators(scene)
    with naming(arguments.scene):
        home = scene.limb.solve(np.full(sum(scene.counts), _HOME), gravity=scene.gravity)
    if not (home.success and home.stable):
        print(f"status: {home.status}\nmessage: there is no stable posture to start from: {home.message}")
        return 1
    down = {"direction": scene.gravity} if arguments.task == "carry" and scene.gravity.any() else {}
    scale = scene.limb.length / LENGTH
    task = replace(TASKS[arguments.task](**down), home=tuple(home.tip[:3, 3])).scaled(scale)
    print(heading(arguments.scene, scene))
    print(f"task: {task.name}, {task.seconds:g} s, on limbs that are not the model; reference length ", end="")
    print(f"{number(scene.limb.length / mm, 1)} mm; offsets times {number(scale, 3)}, as its length is")
    print("errors of the tip [mm]: mean (of the length), 95th percentile, largest")
    rows, failed = [], 0
    seeds = range(arguments.seed, arguments.seed + (arguments.seeds or 1))
    for found in posture_study(scene.limb, task, seeds, gravity=scene.gravity):
        runs = {"open loop": found.open_loop, "closed loop": found.closed_loop}
        for name, one in runs.items():
            said = [number(x / mm, 2) for x in (one.errors.mean, one.errors.percentile_95, one.errors.largest)]
            share = f"{one.errors.shares()[0]:.2%}"
            print(
                f"seed {found.seed:3}  {name:>11}: {said[0]} ({share}), {said[1]}, {said[2]}; {one.message}", flush=True
            )
            rows.append([str(found.seed), name, *said, share, one.message])
            failed += not one.success
    if arguments.table is not None:
        write_csv(arguments.table, ["seed", "loop", "mean_mm", "p95_mm", "largest_mm", "mean_share", "outcome"], rows)
    if arguments.output is not None:
        save_picture(plot.tip_path(runs), arguments.output)
    if arguments.animation is not None:
        print(f"animation: {plot.animation(runs['closed loop'], arguments.animation)}")
    return 1 if failed else 0


def _require_actuators(scene: Scene) -> None:
    if sum(scene.counts) == 0:
        raise ValueError("the limb has no actuators: there is no pressure to control")


_UNITS = ("", "_s", "", "_Pa_s", "_Pa_s2", "_Pa", "_kg")


def _goal(arguments: argparse.Namespace, scene: Scene) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    from softlimb.control import Guard

    _require_actuators(scene)
    given = arguments.pressures_kPa is not None
    name = "--pressures-kPa" if given else "`pressures_kPa` in [scene]"
    if scene.pressures is None:
        raise ValueError("the scene has no pressures to follow: add `pressures_kPa` to [scene], or give them")
    if (scene.pressures < 0.0).any():
        raise ValueError(f"{name} must not be negative to be followed, got {_in_kPa(scene.pressures.min())}")
    if not (scene.pressures > 0.0).any():
        raise ValueError(f"{name} must not all be zero: there would be nothing to follow")
    highest = Guard().highest
    if scene.pressures.max() > highest:
        raise ValueError(
            f"{name} must be at most the {_in_kPa(highest)} that the guard of an actuator allows, got "
            f"{_in_kPa(scene.pressures.max())}"
        )
    return scene.pressures


def _in_kPa(pressure: float) -> str:
    return f"{pressure / kPa:g} kPa"


def _cells(found: Metrics) -> list[str]:
    overshoot = number(100.0 * found.overshoot, 1)
    settling = number(found.settling, 3)
    return [
        overshoot,
        settling + (f" ({found.unsettled} not)" if found.unsettled else ""),
        number(found.iae / kPa, 2),
        number(found.itae / kPa, 2),
        number(found.steady_error / kPa, 3),
        number(found.air / g, 3),
    ]


def _signal_table(found: Comparison, signal: str) -> str:
    headings = ["", "overshoot [%]", "settling [s]", "IAE [kPa s]", "ITAE [kPa s2]", "steady error [kPa]", "air [g]"]
    return aligned(headings, [[name, *_cells(found.found(name, signal))] for name in found.controllers])


def _disturbance_table(found: Comparison, signal: str) -> str:
    names = list(dict.fromkeys(row.disturbance for row in found.rows if row.signal == signal))
    rows = [
        [title, *(number(found.found(title, signal, name).iae / kPa, 2) for name in names)]
        for title in found.controllers
    ]
    return aligned(["", *names], rows)


def _limits(pneumatics: Pneumatics) -> str:
    from softlimb.control.tuning import learning_limit, simc

    start = simc(pneumatics)
    lines = ["learning rates of all three weights beyond which a constant 50 kPa is not held in peace, from SIMC"]
    for name, options in LEARNING_RULES.items():
        found = learning_limit(pneumatics, start, **options)
        if not found.held:
            said = f"not held even without learning (rms command {number(found.unlearned, 2)})"
        elif found.limit is None:
            said = f"none up to {found.rates[-1]:g}"
        elif found.limit == found.rates[0]:
            said = f"not held at any rate from {found.rates[0]:g} on"
        else:
            said = f"{found.limit:.3g}"
        lines.append(f"  {name}: {said}")
    return "\n".join(lines)


LEARNING_RULES: dict[str, dict[str, Any]] = {
    "gradient": {},
    "normalised": {"learning": "normalised"},
    "gradient, no anti-windup": {"anti_windup": "none"},
    "as printed": {"sign": "printed", "anti_windup": "none"},
}
