"""Do the 95 % intervals of an identification hold the truth 95 times in a hundred?

Run: python tests/benchmarks/bench_coverage.py [--trials 2000] [--seed 1]. A tube of one family of soft fibres, whose
length and twist are measured at twelve pressures with normal noise of one in a hundred; c1 of its core and the
stiffness of the fibres are identified in every trial, from first values that are 30 % off. Then a curve of twenty
points with an exponent, by each loss, and with one point in ten an outlier. Prints the share of trials whose interval
holds the truth.
"""

from __future__ import annotations

import argparse

import numpy as np

import softlimb as sl
from softlimb.identify import ActuatorCurve, Identified, identify, least_squares
from softlimb.units import deg, kPa

TRUTH = {"layers[0].c1": 86.1e3, "layers[1].fibre_stiffness": 2e5}
SKIN = sl.Yeoh(c1=86.1e3, c2=13.6e3)
PRESSURES = np.linspace(2, 24, 12) * kPa
DECAY = {"size": 2.0, "rate": 1.5}
PLACES = np.linspace(0.0, 1.0, 20)


def tube(values):
    """One family of soft fibres: it twists, and their stiffness shows."""
    core = sl.Yeoh(c1=values["layers[0].c1"], c2=13.6e3)
    fibres = sl.Fibres(angle=30 * deg, stiffness=values["layers[1].fibre_stiffness"])
    return sl.Tube(0.2, [sl.Layer(0.018, 0.0205, core), sl.Layer(0.0205, 0.0215, SKIN, fibres=fibres)])


def decay(values):
    """A cheap model: size * exp(-rate * x)."""
    size, rate = values
    fall = np.exp(-rate * PLACES)
    return size * fall, np.stack([fall, -size * PLACES * fall], axis=1)


def holds(found: Identified, truth) -> list[bool]:
    assert found.success, found
    return [low <= truth[name] <= high for name, (low, high) in found.intervals.items()]


def tube_trials(trials, rng):
    exact = tube(TRUTH).inflate(PRESSURES)
    elongation, twist = 0.2 * (exact.stretch - 1), 0.2 * exact.twist_rate
    sizes = 0.01 * np.abs(elongation).max(), 0.01 * np.abs(twist).max()
    start = tube({name: 1.3 * value for name, value in TRUTH.items()})
    rows = []
    for _ in range(trials):
        measured = ActuatorCurve(
            PRESSURES,
            elongation=elongation + sizes[0] * rng.standard_normal(12),
            twist=twist + sizes[1] * rng.standard_normal(12),
            elongation_sigma=sizes[0],
            twist_sigma=sizes[1],
        )
        rows.append(holds(identify(start, measured, list(TRUTH)), TRUTH))
    return np.mean(rows, axis=0)


def decay_trials(trials, rng, loss, outliers=0.0):
    exact, _ = decay(tuple(DECAY.values()))
    rows = []
    for _ in range(trials):
        wrong = rng.random(PLACES.size) < outliers
        measured = exact + 0.05 * rng.standard_normal(PLACES.size) * np.where(wrong, 20.0, 1.0)
        found = least_squares(decay, measured, {"size": 1.0, "rate": 1.0}, loss=loss)
        rows.append(holds(found, DECAY))
    return np.mean(rows, axis=0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--trials", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    rng = np.random.default_rng(given.seed)
    spread = 100 * np.sqrt(0.95 * 0.05 / given.trials)
    print(f"{given.trials} trials: a true 95 % shows with a standard deviation of {spread:.2f} %")
    print("tube, c1 and fibre stiffness:", " ".join(f"{100 * share:.2f} %" for share in tube_trials(given.trials, rng)))
    for loss in ("square", "huber", "cauchy"):
        shares = decay_trials(given.trials, rng, loss)
        print(f"decay, {loss}:", " ".join(f"{100 * share:.2f} %" for share in shares))
    for loss in ("square", "huber", "cauchy"):
        shares = decay_trials(given.trials, rng, loss, outliers=0.1)
        print(f"decay with one outlier in ten, {loss}:", " ".join(f"{100 * share:.2f} %" for share in shares))


if __name__ == "__main__":
    main()
