"""A rod as a simulator has it: PyElastica, damped until it rests.

PyElastica (github.com/GazzolaLab/PyElastica) steps Newton's second law of a discrete Cosserat rod in time. Two things
of it differ from ours and bound how near its tip can come: the clamp holds the first element, half an element too far
from the base, and its sections thin out with stretch. It has no rigid plates that are ends of rods, so one rod it is.
"""

from __future__ import annotations

import time
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from softlimb.limb import Rod
from softlimb.paper.problem import Answer

__all__ = ["solve"]

_ELEMENTS = 40  # the clamp then costs 0.1 % of the length on the benchmark's rod; half with twice as many
_COURANT = 0.4  # of the time in which a wave of stretch crosses an element
_STILL = 1e-6  # move of the tip, over the length, in a tenth of the damping time, of a rod at rest


def solve(rod: Rod, tip_force: ArrayLike, gravity: ArrayLike, limit: float = 20.0) -> Answer:
    """Where a clamped rod comes to rest.

    Parameters
    ----------
    rod : Rod
        With a radius and a mass.
    tip_force : array_like, shape (3,)
        Dead, base axes [N].
    gravity : array_like, shape (3,)
        [m/s^2]
    limit : float
        Time after which it gives up [s].

    Raises
    ------
    ModuleNotFoundError
        PyElastica is missing.
    ValueError
        The rod has no radius or no mass.
    """
    deadline = time.perf_counter() + limit
    section, length = rod.section, rod.length
    radius = rod.radius
    if radius is None or section.mass_per_length == 0.0:
        raise ValueError("a rod in motion needs a radius and a mass")
    elastica: Any = import_module("elastica")
    area = np.pi * radius**2
    young, density = section.axial / area, section.mass_per_length / area

    parts = (elastica.BaseSystemCollection, elastica.Constraints, elastica.Forcing, elastica.Damping)
    simulator = type("Simulator", parts, {})()
    moving = elastica.CosseratRod.straight_rod(
        _ELEMENTS,
        np.zeros(3),
        np.array([0.0, 0.0, 1.0]),
        np.array([1.0, 0.0, 0.0]),
        length,
        radius,
        density,
        youngs_modulus=young,
        shear_modulus=young / 3.0,
    )
    moving.shear_matrix[:] = np.diag([section.shear, section.shear, section.axial])[..., None]
    moving.bend_matrix[:] = np.diag([section.bending, section.bending, section.torsion])[..., None]
    simulator.append(moving)
    simulator.constrain(moving).using(
        elastica.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,)
    )
    simulator.add_forcing_to(moving).using(elastica.GravityForces, acc_gravity=np.asarray(gravity, dtype=float))
    # Twice the first frequency of a clamped beam damps its slowest motion as fast as can be.
    damping = 2.0 * 3.516 * np.sqrt(section.bending / section.mass_per_length) / length**2
    step = np.float64(_COURANT * length / _ELEMENTS / np.sqrt(young / density))
    simulator.add_forcing_to(moving).using(
        elastica.EndpointForces, np.zeros(3), np.asarray(tip_force, dtype=float), ramp_up_time=float(step)
    )
    simulator.dampen(moving).using(
        elastica.AnalyticalLinearDamper, uniform_damping_constant=damping, time_step=float(step)
    )
    simulator.finalize()

    stepper, now = elastica.PositionVerlet(), np.float64(0.0)
    answer = Answer(False, "gave up", lengths=np.array([length]))
    still, stretch = 0, round(float(0.1 / damping / step))
    tip = moving.position_collection[:, -1].copy()
    while time.perf_counter() < deadline:
        for _ in range(stretch):
            now = stepper.step(simulator, now, step)
        answer.iterations += stretch
        before, tip = tip, moving.position_collection[:, -1].copy()
        if not np.isfinite(tip).all():
            answer.outcome = "overflow"
            break
        # Several times in a row: a tip that turns around stands still for a moment.
        still = still + 1 if np.linalg.norm(tip - before) < _STILL * length else 0
        if still == 3:
            answer.converged, answer.outcome = True, "converged"
            break
    pose = np.eye(4)
    pose[:3, 3], pose[:3, :3] = tip, moving.director_collection[:, :, -1].T  # its directors are rows
    answer.plates = pose[None]
    return answer
