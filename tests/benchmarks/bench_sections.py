"""What does the nonlinear axial law move and cost on the paper's scenes, against the tangent section and the paper's?

Each posture is verified before it is timed. Prints, for every scene and section, the tip's distance to the answer with
the nonlinear law [mm and per cent of the limb's length], and the median time of a cold solve with its spread, as a
ratio to the tangent section's in the same run. Run: python tests/benchmarks/bench_sections.py
"""

import platform
import statistics
import time
from functools import partial

import numpy as np

from softlimb import load_scene
from softlimb.scenes import available_scenes

SECTIONS = ("tangent", "nonlinear", "paper")
RUNS = 15


def timed(solve):
    started = time.perf_counter()
    solve()
    return 1e3 * (time.perf_counter() - started)


def main():
    print(f"{platform.machine()}, Python {platform.python_version()}, {RUNS} runs; time: median (min..max) [ms]")
    print(f"{'scene':<24}{'section':<11}{'off [mm]':>9}{'off [%]':>9}{'time':>24}{'ratio':>7}")
    for name in available_scenes():
        scene = load_scene(name)
        pressures = scene.sweep_pressures()[-1] if scene.pressures is None else scene.pressures

        def solve(section, scene=scene, pressures=pressures):
            return scene.solve(pressures, section=section)

        postures, times = {}, {section: [] for section in SECTIONS}
        for section in SECTIONS:
            posture = solve(section)
            assert posture.success and posture.verify().success, (name, section, posture.message)
            postures[section] = posture
        for _ in range(RUNS):
            for section in SECTIONS:  # in turn, so that a drifting machine drifts for all
                times[section].append(timed(partial(solve, section)))
        reference = postures["nonlinear"].tip[:3, 3]
        base = statistics.median(times["tangent"])
        for section in SECTIONS:
            off = np.linalg.norm(postures[section].tip[:3, 3] - reference)
            middle = statistics.median(times[section])
            spread = f"{middle:.2f} ({min(times[section]):.2f}..{max(times[section]):.2f})"
            share = 100 * off / scene.limb.length
            print(f"{name:<24}{section:<11}{1e3 * off:>9.3f}{share:>9.3f}{spread:>24}{middle / base:>7.2f}")


if __name__ == "__main__":
    main()
