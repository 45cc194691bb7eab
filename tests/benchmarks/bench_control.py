"""How large may the plant's steps be, how long do inner and outer steps take, and how near does the tip come?

Run: python tests/benchmarks/bench_control.py [--only steps|times|seeds] [--task carry|circle|eight] [--seeds 20].
Every line is printed as soon as it is known. The step-size study checks that no air was made or lost. Times are of the
controllers alone, without plant and posture, and of the processor as well as by the clock: a machine that is shared
stops a process for milliseconds. The seeds are limbs drawn by `Perturbation.drawn` around the reference limb, hanging;
the carry task has 0.1 N at the tip between grasp and release.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from softlimb.bench.machine import machine
from softlimb.control import Guard, Pneumatics, PressureLoop, learning_from, posture_study, run_task, simc
from softlimb.control.tasks import TASKS
from softlimb.presets import reference_limb
from softlimb.units import kPa, mm, ms, us


def steps() -> None:
    """Nine chambers, filled, held and exhausted in 1.2 s: largest difference of any pressure from 256 sub-steps."""
    commands = np.repeat([0.6, 0.0, -0.5], (400, 200, 600))

    def pressures(substeps: int) -> tuple[np.ndarray, float]:
        plant = Pneumatics(reference_limb(), substeps=substeps).plant()
        began, found = time.thread_time(), []
        for command in commands:
            assert plant.advance(np.full(9, command))
            found.append(plant.pressures)
        taken = (time.thread_time() - began) / len(commands)
        air = plant.ledger
        assert abs(air["stored"] - air["at_start"] - air["pumped"] + air["lost"]) < 1e-13
        return np.array(found), taken

    finest, _ = pressures(256)
    print("sub-steps a millisecond, largest error [Pa] by segment, processor time of nine chambers a millisecond [us]")
    for substeps in (1, 2, 4, 8, 16, 32):
        found, taken = pressures(substeps)
        errors = np.abs(found - finest).max(axis=0)[::3]
        print(f"{substeps:4}  " + "  ".join(f"{error:7.2f}" for error in errors) + f"  {taken / us:8.1f}")


def times() -> None:
    """The inner loop's step for nine actuators with guards, and the outer step along a task."""
    limb = reference_limb()
    plant = Pneumatics(limb)
    targets = np.random.default_rng(0).uniform(0.0, 80 * kPa, (200, 9)).repeat(100, axis=0)
    fixed = simc(plant)
    for name, controllers in (("fixed", fixed), ("neural", learning_from(fixed, 0.1, learning="normalised"))):
        seconds = PressureLoop(plant, controllers, guard=Guard()).run(targets, timed=True).seconds
        assert seconds is not None
        print(f"inner step, nine {name} PIDs and guards, {len(seconds)} steps [us]: {quantiles(seconds / us)}")
    for name, make in TASKS.items():
        run = run_task(limb, make())
        assert run.success, run.message
        print(f"outer step, {name}, {len(run.seconds)} steps, by the clock [ms]: {quantiles(run.seconds / ms)}")
        print(f"    of the processor [ms]: {quantiles(run.cpu_seconds / ms)}")


def quantiles(values: np.ndarray) -> str:
    median, p99, p999 = np.percentile(values, [50.0, 99.0, 99.9])
    return f"median {median:.3f}, p99 {p99:.3f}, p99.9 {p999:.3f}, most {values.max():.3f}"


def seeds(task: str, count: int) -> None:
    """Mean, 95th percentile and largest tip error of every seed, without correction and with it."""
    limb = reference_limb()
    print(f"{task}: tip error [mm], in brackets the mean in per cent of the reference length {limb.length / mm:.0f} mm")
    print("seed      open: mean     95 %  largest            closed: mean     95 %  largest")
    rows = []
    for found in posture_study(limb, TASKS[task](), range(count)):
        cells = []
        for run in (found.open_loop, found.closed_loop):
            assert run.success, run.message
            e = run.errors
            rows.append((e.mean, e.percentile_95, e.largest))
            cells.append(
                f"{e.mean / mm:9.2f} ({e.mean / e.length:6.2%}) {e.percentile_95 / mm:7.2f} {e.largest / mm:8.2f}"
            )
        print(f"{found.seed:4}  {cells[0]}    {cells[1]}", flush=True)
    table = np.array(rows).reshape(-1, 2, 3) / mm
    for name, at in (("open", 0), ("closed", 1)):
        mean, high, most = table[:, at].T
        print(
            f"{name} loop over {len(table)} seeds: mean {mean.mean():.2f} mm = {mean.mean() * mm / limb.length:.2%} "
            f"({mean.min():.2f} to {mean.max():.2f}), 95th percentiles up to {high.max():.2f}, largest {most.max():.2f}"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", choices=("steps", "times", "seeds"))
    parser.add_argument("--task", choices=tuple(TASKS), help="of the seeds; default: all")
    parser.add_argument("--seeds", type=int, default=20)
    arguments = parser.parse_args()
    for name in ("processor", "compiler", "target"):
        print(f"{name}: {machine()[name]}")
    if arguments.only in (None, "steps"):
        steps()
    if arguments.only in (None, "times"):
        times()
    if arguments.only in (None, "seeds"):
        for task in [arguments.task] if arguments.task else TASKS:
            seeds(task, arguments.seeds)


if __name__ == "__main__":
    main()
