"""Does every cold start of the reference limb succeed, truly and stably, and how long does it take?

Scenes, seeded: pressures uniform 0..90 kPa each, gravity 9.81 m/s^2 in any direction, tip force 0..1 N in any;
with --moment as well a dead tip moment of 0..0.02 N m, which has no potential. No start is given. Every success is
verified by the independent re-integration. Prints counts, every scene that is not a verified stable success, and the
distribution of iterations and times; exits 1 when a success is false.

Run: python tests/benchmarks/bench_cold_starts.py --scenes 10000 [--moment]
"""

import argparse
import platform
import time

import numpy as np

from softlimb import presets
from softlimb.units import kPa


def direction(generator):
    vector = generator.normal(size=3)
    return vector / np.linalg.norm(vector)


def scene(number, with_moment):
    generator = np.random.default_rng([20261122, number])
    options = {
        "pressures": generator.uniform(0.0, 90.0 * kPa, (3, 3)),
        "gravity": 9.81 * direction(generator),
        "tip_force": generator.uniform(0.0, 1.0) * direction(generator),
    }
    if with_moment:
        options["tip_moment"] = generator.uniform(0.0, 0.02) * direction(generator)
    return options


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=int, default=1000)
    parser.add_argument("--moment", action="store_true")
    arguments = parser.parse_args()
    limb = presets.reference_limb()
    times, newton, descent, odd, false = [], [], [], [], 0
    for number in range(arguments.scenes):
        options = scene(number, arguments.moment)
        started = time.process_time()
        posture = limb.solve(**options)
        times.append(1e3 * (time.process_time() - started))
        newton.append(posture.iterations)
        descent.append(posture.descent_iterations)
        verified = posture.success and posture.verify().success
        false += posture.success and not verified
        if not (verified and posture.stable):
            odd.append(f"scene {number}: {posture.status}, verified {verified}, {posture.message}")
    print(f"{platform.machine()}, Python {platform.python_version()}, one core; {arguments.scenes} scenes")
    print(f"verified stable successes: {arguments.scenes - len(odd)}; false successes: {false}")
    print("\n".join(odd))
    rows = {"processor time [ms]": times, "Newton iterations": newton, "descent iterations": descent}
    for name, values in rows.items():
        low, middle, high, top = np.percentile(values, [5, 50, 95, 100])
        print(f"{name:<20} 5 %: {low:.3g}  median: {middle:.3g}  95 %: {high:.3g}  largest: {top:.3g}")
    print(f"slowest over median: {max(times) / np.median(times):.1f}")
    return 1 if false else 0


if __name__ == "__main__":
    raise SystemExit(main())
