"""Is the tolerance honoured? Error of the tip against a far finer answer, on random scenes at random tolerances.

Scenes, seeded. Even numbers: the reference limb as in bench_cold_starts.py, every third with a dead tip moment. Odd
ones: random limbs of 1 to 4 segments of 1 to 6 rods, segments of 10 mm to 10 m, EA l^2/EI from 10 to 1e9 (in a third of
them mixed within a segment), under no load, any load, tension (growth to e^30), compression to four times buckling,
dead moments, weight, distributed loads. Tolerances log-uniform from 1e-3 to 1e-9. Every solve is cold.

Truth: the same scene solved on from that posture at tolerance 1e-12, or at the finest that works, a tenth at most.
Error: distance of the tips over the limb's length, and angle between them [rad]; the larger counts.

Prints the distributions of error over tolerance and error over the solver's own estimate, every scene beyond its
tolerance, failures with their causes; exits 1 if more than 1 % lie beyond the tolerance or one beyond ten times.

Run: python tests/benchmarks/bench_tolerance.py [--scenes 2000] [--first 0]
"""

import argparse
import collections
import platform
import time
from dataclasses import dataclass

import numpy as np

import softlimb as sl
from softlimb import presets
from softlimb.units import kPa

FINEST = (1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7)
_ROUNDING = 1e-13  # what two fine answers differ by anyway


@dataclass
class Outcome:
    number: int
    tolerance: float
    success: bool
    message: str
    milliseconds: float
    stable: bool = False
    judged: bool = False  # a truth exists and the answer is one single posture
    left: bool = False  # a finer solve from the answer went to another posture
    why_not: str = ""
    position_error: float = np.nan
    rotation_error: float = np.nan
    estimate: float = np.nan

    @property
    def error(self):
        return max(self.position_error, self.rotation_error)

    @property
    def share(self):
        """Error over tolerance."""
        return max(self.error - _ROUNDING, 0.0) / self.tolerance


def direction(generator):
    vector = generator.normal(size=3)
    return vector / np.linalg.norm(vector)


def on_the_reference_limb(generator):
    options = {
        "pressures": generator.uniform(0.0, 90.0 * kPa, (3, 3)),
        "gravity": 9.81 * direction(generator),
        "tip_force": generator.uniform(0.0, 1.0) * direction(generator),
    }
    if generator.random() < 1.0 / 3.0:
        options["tip_moment"] = generator.uniform(0.0, 0.02) * direction(generator)
    return presets.reference_limb(), options


def on_a_random_limb(generator):
    segments, rods = generator.integers(1, 5), generator.integers(1, 7)
    length = 10.0 ** generator.uniform(-2.0, 1.0)
    bending = 10.0 ** generator.uniform(-4.0, 2.0)
    ratio, mixed = 10.0 ** generator.uniform(1.0, 9.0), generator.random() < 1.0 / 3.0
    weight = generator.uniform(0.0, 1.0) * bending / length**3 / segments**2 if generator.random() < 0.5 else 0.0
    parts, taper = [], 1.0
    for _ in range(segments):
        radius = length * generator.uniform(0.05, 0.3)
        spread = min(0.1, 0.5 * radius / length)  # so that no segment bends much beyond a radian by its lengths
        members = []
        for _ in range(rods):
            own = taper * bending * (10.0 ** generator.uniform(-1.0, 1.0) if mixed else 1.0)
            axial = own / length**2 * np.clip(ratio * (10.0 ** generator.uniform(-2, 2) if mixed else 1.0), 10.0, 1e9)
            section = sl.Section(
                axial=axial,
                shear=axial * generator.uniform(0.2, 1.0),
                bending=own,
                torsion=own * generator.uniform(0.4, 1.0),
                mass_per_length=weight / 9.81,
            )
            members.append(sl.Rod(section, length * (1.0 + generator.uniform(-spread, spread))))
        plate = sl.Plate(thickness=0.1 * length, mass=0.3 * weight * length / 9.81)
        parts.append(sl.Segment(rods=members, ring_radius=radius, plate=plate))
        taper *= generator.uniform(0.4, 1.0)
    unit = taper * rods * bending / length**2  # force that bends the softest segment
    options = {"gravity": 9.81 * direction(generator)}
    kind = generator.integers(0, 4)
    if kind == 1:
        options["tip_force"] = unit * 10.0 ** generator.uniform(-2.0, 1.0) * direction(generator)
    elif kind == 2:  # tension; the growth is its root
        pull = unit * generator.uniform(1.0, 30.0) ** 2
        softest = min(sum(rod.section.axial for rod in part.rods) for part in parts)
        pull = min(pull, 0.3 * softest)  # beyond such strains a linear section means nothing
        options["tip_force"] = pull * (np.array([0.0, 0.0, 1.0]) + generator.uniform(0.0, 0.3) * direction(generator))
    elif kind == 3:  # compression of the whole limb, as a share of a cantilever's buckling load
        push = generator.uniform(0.2, 4.0) * unit * 0.25 * np.pi**2 / segments**2
        options["tip_force"] = push * (0.05 * direction(generator) - [0.0, 0.0, 1.0])
    if generator.random() < 0.3:
        wrenches = np.zeros((segments, 6))
        plate = generator.integers(0, segments)
        wrenches[plate, 3:] = generator.uniform(0.0, 2.0) * unit * length / segments * direction(generator)
        options["plate_wrenches"] = wrenches
    if generator.random() < 0.2:
        size = generator.uniform(0.0, 1.0) * taper * bending / length**3 / segments**2
        options["rod_forces"] = size * generator.normal(size=(segments * rods, 3))
    return sl.Limb(parts), options


def scene(number):
    """Limb, options of `solve` and tolerance of a scene."""
    generator = np.random.default_rng([20261122, 7, number])
    limb, options = (on_a_random_limb if number % 2 else on_the_reference_limb)(generator)
    return limb, options, 10.0 ** generator.uniform(-9.0, -3.0)


def gaps(posture, other):
    """Distance of the two tips over the limb's length, and angle between them [rad]."""
    turn = posture.tip[:3, :3] @ other.tip[:3, :3].T
    sine = 0.5 * np.linalg.norm([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    distance = np.linalg.norm(posture.tip[:3, 3] - other.tip[:3, 3]) / posture.limb.length
    return float(distance), float(np.arctan2(sine, 0.5 * (np.trace(turn) - 1.0)))


def measure(number):
    """Solve a scene and compare the tip with a far finer answer."""
    limb, options, tolerance = scene(number)
    started = time.perf_counter()
    posture = limb.solve(**options, tolerance=tolerance)
    milliseconds = 1e3 * (time.perf_counter() - started)
    outcome = Outcome(number, tolerance, posture.success, posture.message, milliseconds)
    if not posture.success:
        outcome.why_not = posture.status
        return outcome
    outcome.stable, outcome.estimate = posture.stable, posture.error_estimate
    # A finer solve may leave for another posture. One that ends nearby proves that an equilibrium is there.
    truth, far = None, 10.0 * tolerance
    for finest in (t for t in FINEST if t <= 0.1 * tolerance):
        finer = limb.solve(**options, tolerance=finest, start=posture, prefer_stable=False)
        if not finer.success:
            continue
        near = max(gaps(posture, finer)) <= far
        outcome.left = outcome.left or not near
        if near or truth is None:
            truth = finer
        if near:
            break
    if truth is None:
        outcome.why_not = "no finer answer"
        return outcome
    if "costs nothing" in truth.message + posture.message:
        outcome.why_not = "one of many equal postures"
        return outcome
    outcome.position_error, outcome.rotation_error = gaps(posture, truth)
    outcome.judged = True
    return outcome


def show(name, values):
    low, middle, high, higher, top = np.percentile(values, [5, 50, 95, 99, 100])
    print(f"{name:<28} 5 %: {low:.2g}  median: {middle:.2g}  95 %: {high:.2g}  99 %: {higher:.2g}  largest: {top:.3g}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=int, default=2000)
    parser.add_argument("--first", type=int, default=0)
    arguments = parser.parse_args()
    outcomes = [measure(number) for number in range(arguments.first, arguments.first + arguments.scenes)]
    judged = [o for o in outcomes if o.judged]
    print(f"{platform.machine()}, Python {platform.python_version()}, one core; {len(outcomes)} scenes")
    print(f"solved: {sum(o.success for o in outcomes)}; of these unstable and said so: ", end="")
    print(f"{sum(o.success and not o.stable for o in outcomes)}; judged: {len(judged)}")
    for why, count in collections.Counter(o.why_not for o in outcomes if o.why_not).most_common():
        numbers = [o.number for o in outcomes if o.why_not == why]
        print(f"  not judged: {count} of {why}: scenes {numbers[:20]}{' ...' if count > 20 else ''}")
    left = [o.number for o in outcomes if o.left]
    print(f"  from {len(left)} answers a finer solve left for another posture: scenes {left}")
    show("position error/tolerance", [o.position_error / o.tolerance for o in judged])
    show("rotation error/tolerance", [o.rotation_error / o.tolerance for o in judged])
    show("error/tolerance", [o.share for o in judged])
    show("error/estimate", [o.error / max(o.estimate, _ROUNDING) for o in judged])
    times = [o.milliseconds for o in outcomes]
    show("time [ms]", times)
    slow = [o for o in outcomes if o.milliseconds > 50.0 * np.median(times)]
    for o in slow:
        print(f"  slow: scene {o.number}, {o.milliseconds:.0f} ms: {o.message}")
    beyond, far = [o for o in judged if o.share > 1.0], [o for o in judged if o.share > 10.0]
    for o in beyond:
        print(
            f"  beyond: scene {o.number}, tolerance {o.tolerance:.1e}, position {o.position_error:.1e}, "
            f"rotation {o.rotation_error:.1e}, estimate {o.estimate:.1e}: {o.message}"
        )
    percent = 100.0 * len(beyond) / max(1, len(judged))
    print(f"beyond the tolerance: {len(beyond)} of {len(judged)} ({percent:.2f} %); beyond ten times: {len(far)}")
    return 1 if len(beyond) > 0.01 * len(judged) or far else 0


if __name__ == "__main__":
    raise SystemExit(main())
