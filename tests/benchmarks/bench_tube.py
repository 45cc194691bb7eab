"""How long does a tube take for its next pressure, and what does its section cost?

Run: python tests/benchmarks/bench_tube.py. The answers are checked against a second route before anything is timed.
Times are per solve inside one call over an array, so the Python call itself is divided away, but for the lines with a
star. Median and spread of several repetitions.
"""

from __future__ import annotations

import platform
import statistics
import time
from collections.abc import Callable

import numpy as np

import softlimb as sl
from softlimb.units import deg, kPa


def tube_of(tension_only: bool = False, twisting: bool = False) -> sl.Tube:
    core, skin = sl.Yeoh(c1=86.1 * kPa, c2=13.6 * kPa), sl.NeoHookean(c1=340 * kPa)
    fibres = sl.Fibres.pair(angle=1.33 * deg, modulus=31.067e9, fraction=0.0083)
    if twisting:
        fibres = [sl.Fibres(angle=20 * deg, stiffness=2.5e8), sl.Fibres(angle=-35 * deg, stiffness=1e8)]
    layers = [sl.Layer(0.018, 0.0205, core), sl.Layer(0.0205, 0.0215, skin, fibres=fibres)]
    return sl.Tube(0.2, layers, tension_only=tension_only)


def check(tube: sl.Tube, pressures: np.ndarray) -> None:
    state = tube.inflate(pressures)
    assert np.all(state.success)
    inverse = tube.pressure_for(state.stretch[::500])
    assert np.allclose(inverse, pressures[::500], rtol=1e-8), "pressure_for does not invert inflate"
    at = state[len(pressures) // 2]
    inside = at.stress(at.inner_radius).radial
    assert abs(float(inside) + at.pressure) < 1e-7 * at.pressure, "the stress does not meet the pressure"


def microseconds(call: Callable[[], object], count: int, repetitions: int = 9) -> str:
    times = []
    for _ in range(repetitions):
        start = time.perf_counter()
        call()
        times.append((time.perf_counter() - start) / count * 1e6)
    return f"{statistics.median(times):8.2f}  ({min(times):.2f} to {max(times):.2f})"


def main() -> None:
    print(f"Python {platform.python_version()}, {platform.processor() or platform.machine()}")
    print("microseconds: median (least to most)")
    pressures = 20 * kPa * 1.01 ** (np.arange(5000) % 100)  # neighbours differ by 1 %
    none, pull = np.zeros_like(pressures), np.full_like(pressures, 2.0)
    tubes = {
        "two-way fibres": tube_of(),
        "tension-only fibres": tube_of(tension_only=True),
        "unequal families": tube_of(twisting=True),
    }
    for name, tube in tubes.items():
        check(tube, pressures)
        print(name)
        report("next pressure", lambda t=tube: t._inflate(pressures, none, none, False), pressures.size)
        report("next pressure under 2 N", lambda t=tube: t._inflate(pressures, pull, none, False), pressures.size)
        stretch = tube.inflate(pressures).stretch
        report("stretch to pressure", lambda t=tube, s=stretch: t._at_stretch(s), pressures.size)
        for model in ("tangent", "nonlinear"):
            for derivative in (False, True):
                label = f"{model} section{', d/dP' if derivative else ''} *"
                report(label, lambda t=tube, m=model, d=derivative: sections(t, m, d), 200)
        report("inflate *", lambda t=tube: [t.inflate(30 * kPa) for _ in range(200)], 200)
    report("construction *", lambda: [tube_of() for _ in range(20)], 20)
    print("* one Python call each, its cost included")


def sections(tube: sl.Tube, model: str, derivative: bool) -> list[object]:
    return [tube._section(30 * kPa, model, "open", derivative) for _ in range(200)]


def report(label: str, call: Callable[[], object], count: int) -> None:
    print(f"  {label:28}", microseconds(call, count))


if __name__ == "__main__":
    main()
