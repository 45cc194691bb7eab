"""Which share of targets does `Limb.reach` find from nothing, and what does a path of targets cost?

Targets are tips of the reference limb, hanging, 0.2 N at the tip in a random direction, at random pressures, 0..80 kPa:
each can be reached within these bounds. Every answer that says it reached is held against the tip of its posture, and
that posture against the independent re-integration. Along a path (a straight line between two random rows of pressures,
in `--steps` steps) each target starts from the answer before it, and the forward solves that made the targets from the
posture before; the ratio of the two times is printed, times in turn.

Run: python tests/benchmarks/bench_reach.py [--targets 1000] [--paths 5] [--steps 100]; exits 1 when an answer is false.
"""

from __future__ import annotations

import argparse
import platform
import statistics
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

import softlimb as sl
from softlimb import presets
from softlimb.units import kPa

HIGHEST = 80 * kPa
SEED = 20261122
KINDS = ("position", "pose")


def loads(generator: np.random.Generator) -> dict[str, Any]:
    direction = generator.normal(size=3)
    return {"gravity": (0.0, 0.0, 9.81), "tip_force": tuple(0.2 * direction / np.linalg.norm(direction))}


def wanted(kind: str, tip: NDArray[np.float64]) -> dict[str, Any]:
    return {kind: tip[:3, 3] if kind == "position" else tip, "max_pressure": HIGHEST}


def is_false(found: sl.Reach) -> bool:
    """Says that it reached, and did not."""
    if not found.reached:
        return False
    near = found.error.relative <= found.posture.tolerance and (found.error.rotation or 0.0) <= found.posture.tolerance
    return not (near and found.posture.success and found.posture.stable and found.posture.verify().success)


def from_nothing(limb: sl.Limb, kind: str, targets: int) -> int:
    reached, least, alone, false, times, looks, failed = 0, 0, 0, 0, [], [], []
    for number in range(targets):
        generator = np.random.default_rng([SEED, number])
        pressures, scene = generator.uniform(0.0, HIGHEST, 9), loads(generator)
        posture = limb.solve(pressures, **scene)
        if not posture.success or not posture.stable:
            print(f"target {number} is no posture: {posture.message}")
            continue
        started = time.process_time()
        found = limb.reach(**wanted(kind, posture.tip), **scene)
        times.append(1e3 * (time.process_time() - started))
        looks.append(found.iterations)
        reached += found.reached
        least += found.least
        alone += found.reached and not found.remarks
        false += is_false(found)
        if not found.reached:
            failed.append(f"  target {number}: {found.message}")
    print(f"{kind}: reached {reached} of {targets} ({reached / targets:.1%}), of these least effort {least}, ", end="")
    print(f"the same posture without a start {alone}; false answers {false}")
    print("\n".join(failed))
    for name, values in {"processor time [ms]": times, "postures looked at": looks}.items():
        low, middle, high, top = np.percentile(values, [5, 50, 95, 100])
        print(f"  {name:<20} 5 %: {low:.3g}  median: {middle:.3g}  95 %: {high:.3g}  largest: {top:.3g}")
    return false


def along_paths(limb: sl.Limb, kind: str, paths: int, steps: int) -> int:
    ratios, lost, false = [], 0, 0
    for number in range(paths):
        generator = np.random.default_rng([SEED, 1, number])
        first, last = generator.uniform(0.0, HIGHEST, (2, 9))
        scene = loads(generator)
        rows = [first + (last - first) * share for share in np.linspace(0.0, 1.0, steps + 1)]
        posture = limb.solve(rows[0], **scene)
        start = limb.reach(**wanted(kind, posture.tip), **scene)

        def forward(begin: sl.Posture = posture, rows: Any = rows, scene: Any = scene) -> list[sl.Posture]:
            found = [begin]
            for row in rows[1:]:
                found.append(limb.solve(row, start=found[-1], **scene))
            return found

        tips = [each.tip for each in forward()]

        def inverse(begin: sl.Reach = start, tips: Any = tips, scene: Any = scene) -> list[sl.Reach]:
            found = [begin]
            for tip in tips[1:]:
                found.append(limb.reach(**wanted(kind, tip), start=found[-1], **scene))
            return found

        answers = inverse()
        lost += sum(not found.reached for found in answers)
        false += sum(is_false(found) for found in answers)
        taken = {forward: [], inverse: []}
        for _ in range(7):
            for way, seconds in taken.items():
                started = time.process_time()
                way()
                seconds.append(time.process_time() - started)
        there, back = (statistics.median(seconds) for seconds in taken.values())
        ratios.append(back / there)
        print(
            f"  {kind} path {number}: solves {1e6 * there / steps:.0f} us a step, reach {1e6 * back / steps:.0f} us, ",
            end="",
        )
        looks = statistics.mean(found.iterations for found in answers[1:])
        print(f"ratio {ratios[-1]:.2f}, {looks:.1f} postures looked at, {sum(f.starts > 0 for f in answers[1:])} cold")
    print(f"{kind} paths: median ratio {statistics.median(ratios):.2f}, not reached {lost} of {paths * (steps + 1)}")
    return false


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--targets", type=int, default=1000)
    parser.add_argument("--paths", type=int, default=5)
    parser.add_argument("--steps", type=int, default=100)
    arguments = parser.parse_args()
    limb = presets.reference_limb()
    print(f"{platform.machine()}, Python {platform.python_version()}, one core")
    false = 0
    for kind in KINDS:
        if arguments.targets:
            false += from_nothing(limb, kind, arguments.targets)
        if arguments.paths:
            false += along_paths(limb, kind, arguments.paths, arguments.steps)
    return 1 if false else 0


if __name__ == "__main__":
    raise SystemExit(main())
