"""How long does Ctrl-C take?

    python tests/benchmarks/bench_interrupt.py [--samples 8] [PHASE ...]

A child process works in one phase of the package, over and over; after a random while it gets SIGINT, and the time from
the signal to the KeyboardInterrupt in Python is taken. The aim is 0.2 s. Prints the median and the largest of each
phase, and machine and Python.
"""

from __future__ import annotations

import argparse
import platform
import random
import signal
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

THIN = {"axial": 60.0, "shear": 20.0, "bending": 0.003, "torsion": 0.002, "mass_per_length": 0.1}


def _ring(count: int, **plate: float) -> Any:
    import softlimb as sl

    rod = sl.Rod(sl.Section(**THIN), 0.2, radius=0.004)
    return sl.Segment(rods=[rod] * count, ring_radius=0.03, plate=sl.Plate(**plate))


def phases() -> dict[str, Callable[[], Callable[[], Any]]]:
    """Name to what prepares the work and returns it."""
    import softlimb as sl
    from softlimb import presets

    def reference(**options: Any) -> Callable[[], Any]:
        limb = presets.reference_limb()
        return lambda: limb.solve([90e3, 60e3, 30e3, 60e3, 40e3, 20e3, 50e3, 50e3, 50e3], **options)

    def hopeless(rods: int, segments: int, **options: Any) -> Callable[[], Any]:
        limb = sl.Limb([_ring(rods, thickness=0.02, mass=0.1)] * segments)
        return lambda: limb.solve(**options)

    def tall(rods: int = 12, segments: int = 10, **options: Any) -> Any:
        limb = sl.Limb([_ring(rods, thickness=0.02, mass=0.01)] * segments)
        return limb.solve(gravity=(0.0, 0.0, 9.81), **options)

    def again(question: Callable[[Any], Any], rods: int = 12, segments: int = 10) -> Callable[[], Any]:
        solved = tall(rods, segments)
        return lambda: question(solved)

    def long_tube() -> Callable[[], Any]:
        tube = sl.Tube(1e3, presets.reference_limb().segments[0].actuators[0].layers)
        limb = sl.Limb([sl.Segment([tube] * 3, ring_radius=0.028, plate=sl.Plate(0.025, 0.14))])
        return lambda: limb.solve([55e3] * 3, gravity=(0.0, 0.0, 9.81))

    def linear(found: Any) -> Any:
        found.__dict__.pop("_linear", None)  # kept otherwise, as is the compliance
        found.__dict__.pop("compliance", None)
        return found.compliance

    bent = reference()()
    reference_tip = bent.limb.solve(bent.pressures, tip_force=(0.3, 0.0, 0.0)).tip
    tube = presets.reference_limb().segments[0].actuators[0]
    stretch = np.linspace(1.0, 2.0, 5000)
    law = sl.Ogden(mu=[6e5, 1e3, -1e4], alpha=[1.3, 5.0, -2.0])
    return {
        "reference limb": lambda: reference(gravity=(0.0, 0.0, 9.81), tolerance=1e-12),
        "standing limb": lambda: reference(gravity=(0.0, 0.0, -9.81)),
        "following load": lambda: reference(tip_force=(3.0, 0.0, 0.0), tip_moment=(0.0, 0.3, 0.0), frame="plate"),
        "mad moment, one rod": lambda: hopeless(1, 1, tip_moment=(1e3, 0.0, 0.0)),
        "mad moment, 3 x 3 rods": lambda: hopeless(3, 3, tip_moment=(1e3, 0.0, 0.0)),
        "mad moment, 12 x 10 rods": lambda: hopeless(12, 10, tip_moment=(1e3, 0.0, 0.0)),
        "mad moment, 30 x 40 rods": lambda: hopeless(30, 40, tip_moment=(1e3, 0.0, 0.0)),
        "mad force, 6 x 3 rods": lambda: hopeless(6, 3, tip_force=(1e4, 0.0, 0.0)),
        "mad following force, 6 x 3 rods": lambda: hopeless(6, 3, tip_force=(0.0, 50.0, 0.0), frame="plate"),
        "rods of a kilometre": long_tube,
        "12 x 10 rods, 1e-12": lambda: lambda: tall(tolerance=1e-12),
        "verify, 12 x 10 rods": lambda: again(lambda found: found.verify()),
        "clearance, 12 x 10 rods": lambda: again(lambda found: found._solved.clearance([0.004] * 120, 33)),
        "clearance, 30 x 10 rods": lambda: again(lambda found: found._solved.clearance([0.004] * 300, 33), 30),
        "verify, 30 x 40 rods": lambda: again(lambda found: found.verify(), 30, 40),
        "compliance, 30 x 40 rods": lambda: again(linear, 30, 40),
        "compliance, 12 x 10 rods": lambda: again(linear),
        "derivatives, 12 x 10 rods": lambda: again(
            lambda found: found.derivative(("plates", "centreline"), ("length", "section", "gravity"))
        ),
        "centreline of 20 000 points": lambda: again(lambda found: found.centreline(20_000)),
        "a path through a fold": lambda: lambda: sl.Limb([_ring(3)] * 3).follow(
            lambda force: {"tip_force": (0.0, 0.001, -force)}, 0.0, 3.0
        ),
        "a payload": lambda: lambda: presets.reference_limb().payload(
            (1.0, 0.0, 0.0), pressures=[30e3] * 9, gravity=(0.0, 0.0, 9.81)
        ),
        "a reach": lambda: lambda: presets.reference_limb().reach(position=(0.5, 0.0, 0.1), max_pressure=80e3),
        "a reach by the paper": lambda: lambda: presets.reference_limb().reach(
            pose=bent.tip, max_pressure=80e3, method="paper"
        ),
        "a sensed force": lambda: lambda: bent.limb.sense(
            bent.pressures, tip_pose=reference_tip, covariance=1e-8 * np.eye(6)
        ),
        "sweep": lambda: lambda: presets.reference_limb().sweep(np.zeros((100_000, 9)), progress=False).interrupted,
        "a tube's 1e6 pressures": lambda: lambda: tube.inflate(np.linspace(0.0, 90e3, 1_000_000)),
        "a tube's 1e5 loaded pressures": lambda: lambda: tube.inflate(
            np.linspace(-50e3, 190e3, 100_000), axial_force=-40.0
        ),
        "a tube's 1e5 stretches": lambda: lambda: tube.pressure_for(np.linspace(0.5, 2.0, 100_000)),
        "building limbs": lambda: presets.reference_limb,
        "fit of Ogden's law": lambda: lambda: sl.fit_uniaxial(
            stretch, law.uniaxial_stress(stretch), "ogden3", max_strain=1.0
        ),
    }


def child(name: str) -> None:
    work = phases()[name]()
    print("ready", flush=True)
    try:
        while True:
            if work() is True:  # a sweep keeps its rows and says that it was interrupted
                raise KeyboardInterrupt
    except KeyboardInterrupt:
        print(time.monotonic(), flush=True)


def seconds_to_interrupt(name: str, rng: random.Random) -> float:
    process = subprocess.Popen([sys.executable, __file__, "--child", name], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    time.sleep(rng.uniform(0.05, 2.5))
    sent = time.monotonic()  # the clock is the machine's, the same in the child
    process.send_signal(signal.SIGINT)
    answered = float(process.stdout.readline())
    process.wait(timeout=60)
    return answered - sent


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=8)
    parser.add_argument("--child", help=argparse.SUPPRESS)
    parser.add_argument("phase", nargs="*")
    options = parser.parse_args()
    if options.child:
        child(options.child)
        return
    rng = random.Random(1)
    print(f"{platform.machine()}, Python {platform.python_version()}, {options.samples} samples a phase")
    for name in options.phase or phases():
        taken = [seconds_to_interrupt(name, rng) for _ in range(options.samples)]
        late = "   later than 0.2 s" if max(taken) > 0.2 else ""
        print(f"{name:34s} median {statistics.median(taken):6.3f} s   largest {max(taken):6.3f} s{late}", flush=True)


if __name__ == "__main__":
    main()
