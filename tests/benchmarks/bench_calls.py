"""What does a call of `Limb.solve` cost beside the solve?

Run: python tests/benchmarks/bench_calls.py. The same warm solve of one actuator is timed from Python and inside the
core, as rows of a sweep that all start from one posture; their difference is the call. (A row has clearance besides,
one rod's two microseconds at most, and the sweep its thread.) The answers are compared before anything is timed.
"""

from __future__ import annotations

import platform
import statistics
import time
from collections.abc import Callable

import numpy as np

import softlimb as sl
from softlimb.rows import solve_rows
from softlimb.units import kPa

HANGING = (0.0, 0.0, 9.81)
COUNT, REPETITIONS = 500, 41


def microseconds(call: Callable[[], object]) -> float:
    start = time.perf_counter()
    call()
    return (time.perf_counter() - start) / COUNT * 1e6


def main() -> None:
    # One actuator: the solve is as short as it gets, and the call around it stands out.
    tube = sl.presets.reference_limb().segments[2].actuators[0]
    limb = sl.Limb([sl.Segment(actuators=[tube], ring_radius=0.0, plate=sl.Plate(thickness=0.025, mass=0.14))])
    pressures = np.array([30 * kPa])
    start = limb.solve(pressures, gravity=HANGING)
    rows = np.tile(pressures, (COUNT, 1))

    def solve_all() -> sl.Posture:
        for _ in range(COUNT):
            posture = limb.solve(pressures, gravity=HANGING, start=start)
        return posture

    def sweep_all() -> np.ndarray:
        found = solve_rows(limb, rows, threads=1, ordered=False, tick=lambda done: True, gravity=HANGING, start=start)
        assert found.success.all()
        return found.tip

    assert np.array_equal(sweep_all()[0], solve_all().tip), "a row is not the posture of a call"
    # By turns: what else the machine does meets both.
    calls, sweeps = zip(*[(microseconds(solve_all), microseconds(sweep_all)) for _ in range(REPETITIONS)], strict=True)
    print(f"Python {platform.python_version()}, {platform.processor() or platform.machine()}")
    print("microseconds: least, median")
    for name, found in (("a call, warm", calls), ("a row, warm", sweeps)):
        print(f"  {name:22} {min(found):8.2f} {statistics.median(found):8.2f}")
    print(f"  the call beside it     {min(calls) - min(sweeps):8.2f}")


if __name__ == "__main__":
    main()
