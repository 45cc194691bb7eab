"""What does a design cost: payload in six directions and a workspace of 512 postures, and 10,000 of them?

Designs are reference limbs with a radius ratio, a common length factor and a skin's stiffness drawn from a box, each
held at the reference limb's mass. The answers of the first designs are checked before anything is timed: payloads
against `Limb.payload`, which follows a path, and rows of the workspace against cold solves to 1e-8. Times are processor
times of one core; the extrapolation divides by `--cores` and is that: an extrapolation. With `--workers` the designs
are evaluated by that many processes as well, and the wall time of that is extrapolated.

Run: python tests/benchmarks/bench_design.py [--designs 40] [--workers 0] [--cores 2]; exits 1 when an answer is false.
"""

from __future__ import annotations

import argparse
import platform
import statistics
import time

import numpy as np

import softlimb as sl
from softlimb import design, presets
from softlimb.units import kPa, mm

SEED = 20261122
WANTED = 10_000
SCENE = {"gravity": (0.0, 0.0, 9.81), "tolerance": 1e-4}
LOADED = np.full(9, 30 * kPa)
DEFLECTION = 65 * mm
WORKSPACE = design.PressureSet(60 * kPa, 512, 0, scene=SCENE)
PAYLOAD = design.Payload(LOADED, DEFLECTION, scene=SCENE)


def problem() -> design.Problem:
    return design.Problem(
        presets.reference_limb(),
        [
            design.RadiusRatio(0.3, 1.0, "mass"),
            design.Factor("segments[*].length", 0.8, 1.2, "length"),
            design.Factor("segments[*].layers[1].c*", 0.5, 2.0, "skin"),
        ],
        PAYLOAD,
        also=[design.Bending(WORKSPACE), design.WorkspaceVolume(WORKSPACE)],
    )


def is_false(limb: sl.Limb) -> bool:
    """Does a payload or a posture of the workspace differ from the slow and sure way?"""
    wrong = False
    for along, found in zip(design.SIX_DIRECTIONS, PAYLOAD.by_direction(limb), strict=True):
        sure = limb.payload(along, pressures=LOADED, max_deflection=DEFLECTION, gravity=SCENE["gravity"])
        # The tip's tolerance of 1e-4 of the length is 1e-3 of the deflection; where a column buckles the count of modes
        # that `Limb.payload` goes by has a margin of a per cent of the force.
        near = 2e-3 if found.limit == sure.limit == "deflection" else 2e-2
        if abs(found.force / sure.force - 1.0) > near:
            print(f"  payload along {along}: {found.message}; by the path {sure.message}")
            wrong = True
    rows, batch = WORKSPACE.rows(9), WORKSPACE.sweep(limb)
    for k in range(0, len(rows), 37):
        sure = limb.solve(rows[k], gravity=SCENE["gravity"], tolerance=1e-8)
        off = np.linalg.norm(sure.tip[:3, 3] - batch.tip[k, :3, 3]) / limb.length
        if off > SCENE["tolerance"]:
            print(f"  row {k} of the workspace: the tip is off by {off:.1e} of the length")
            wrong = True
    return wrong


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--designs", type=int, default=40)
    parser.add_argument("--checked", type=int, default=3)
    parser.add_argument("--workers", type=int, default=0)
    parser.add_argument("--cores", type=int, default=2)
    arguments = parser.parse_args()
    asked = problem()
    generator = np.random.default_rng(SEED)
    drawn = asked.lower + generator.uniform(size=(arguments.designs, 3)) * (asked.upper - asked.lower)
    print(f"{platform.machine()}, Python {platform.python_version()}, one core, seed {SEED}")
    false = sum(is_false(asked.limb(row)) for row in drawn[: arguments.checked])
    print(f"checked {min(arguments.checked, len(drawn))} designs, false: {false}")

    parts = {
        "build": lambda limb: None,
        "payload": PAYLOAD.value,
        "workspace": WORKSPACE.sweep,
        "hull, angle": lambda limb: [criterion.value(limb) for criterion in asked.also],
    }
    taken: dict[str, list[float]] = {name: [] for name in parts}
    failed = 0
    for row in drawn:
        started = time.process_time()
        limb = asked.limb(row)
        try:
            for name, part in parts.items():
                part(limb)
                taken[name].append(1e3 * (time.process_time() - started))
                started = time.process_time()
        except design.DesignFailure as error:
            failed += 1
            print(f"  a design failed: {error}")
    for name, values in taken.items():
        if values:
            low, middle, high = np.percentile(values, [5, 50, 95])
            print(f"{name:<12} {middle:8.2f} ms a design (5 %: {low:.2f}, 95 %: {high:.2f})")
    total = sum(statistics.mean(values) for values in taken.values() if values)
    minutes = total * WANTED / arguments.cores / 6e4
    print(f"in all {total:.1f} ms a design and core, failed {failed} of {len(drawn)}")
    print(f"extrapolated: {WANTED} designs in {minutes:.1f} min on {arguments.cores} such cores (wanted: 10 min)")
    if arguments.workers:
        started = time.perf_counter()
        design.evaluate_many(asked, drawn, workers=arguments.workers)
        seconds = time.perf_counter() - started
        print(
            f"{arguments.workers} processes: {seconds:.1f} s for {len(drawn)} designs, their start included; "
            f"{WANTED}: {seconds * WANTED / len(drawn) / 60:.1f} min"
        )
    return 1 if false else 0


if __name__ == "__main__":
    raise SystemExit(main())
