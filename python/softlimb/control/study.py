"""Tasks on many limbs that are not the model: every seed, open loop and closed loop."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from softlimb.control.posture_loop import PoseSensor, PostureControl, PostureRun, run_task
from softlimb.control.tasks import Task
from softlimb.control.true_limb import Perturbation
from softlimb.limb import Limb

__all__ = ["SeedRuns", "posture_study"]


@dataclass(frozen=True, eq=False)
class SeedRuns:
    """One perturbed limb: its task without correction and with it."""

    seed: int
    open_loop: PostureRun
    closed_loop: PostureRun


def posture_study(limb: Limb, task: Task, seeds: Iterable[int], **options: Any) -> Iterator[SeedRuns]:
    """Run a task on limbs drawn by `Perturbation.drawn`, one after the other.

    Parameters
    ----------
    limb : Limb
    task : Task
    seeds : iterable of int
        Of the limb and of the noise of its sensors.
    **options
        Of `run_task`, the perturbation, sensor and control excepted.

    Yields
    ------
    SeedRuns
        As each is done.
    """
    for seed in seeds:
        runs = [
            run_task(
                limb,
                task,
                control=PostureControl(closed=closed),
                perturbation=Perturbation.drawn(limb, seed),
                sensor=PoseSensor(seed=seed),
                **options,
            )
            for closed in (False, True)
        ]
        yield SeedRuns(seed, *runs)
