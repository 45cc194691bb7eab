"""A solver of rows whose answers are known beforehand, and comparisons of sweeps bit by bit."""

from __future__ import annotations

import time

import numpy as np

from softlimb import presets, rows
from softlimb.rows import GROUP, INVALID, Rows


def small_limb():
    """One segment, three actuators: two milliseconds a posture."""
    return presets.reference_limb(["proximal"])


def some_pressures(count, seed=7, actuators=3):
    return np.random.default_rng(seed).uniform(0.0, 60e3, (count, actuators))


class KnownRows:
    """Stands in for `softlimb.rows.solve_rows`: the tip's height is the limb's length and 1 mm a kPa of the first row.

    Below 1 kPa the limb refuses, above 50 kPa there is no balance, and every row of 20 to 30 kPa has a remark. Ordered
    rows keep a tenth of the height above the one before, so that a group that is cut shows. Seconds a row may be asked
    for; `stop_at` stops before the row with this pressure, as a solver does that meets Ctrl-C.
    """

    def __init__(self, seconds=0.0, stop_at=None):
        self.seconds = seconds
        self.stop_at = stop_at
        self.solved = []  # first pressures of all rows that were solved

    def __call__(self, limb, pressures, *, threads, ordered, tick, **scene):
        if isinstance(scene.get("gravity"), str):
            raise ValueError("gravity must be three numbers")
        found = Rows.not_run(len(pressures), len(limb.segments))
        before = 0.0
        for row, pressure in enumerate(pressures[:, 0].tolist()):
            if pressure == self.stop_at or not tick(row):
                break
            if self.seconds:
                time.sleep(self.seconds)
            self.solved.append(pressure)
            before = 0.0 if not ordered or row % GROUP == 0 else before
            found.iterations[row], found.residual[row] = 3, 1e-12
            if pressure < 1e3:
                found.status[row], found.message[row] = INVALID, f"pressures must be at least 1 kPa, got {pressure} Pa"
            elif pressure > 50e3:
                found.status[row], found.message[row] = "max_iterations", "no balance after 50 iterations"
            else:
                before = 1e-6 * pressure + 0.1 * before
                found.plates[row] = np.eye(4)
                found.plates[row, :, 2, 3] = limb.length + before
                found.tip[row] = found.plates[row, -1]
                found.status[row], found.success[row], found.stable[row] = "converged", True, True
                found.unstable_modes[row] = 0
                if 20e3 <= pressure <= 30e3:
                    found.message[row] = f"converged; a remark at {pressure} Pa, in mm² and °"
        return found


def use_known_rows(seconds=0.0):
    """For processes that are started by a test."""
    rows.solve_rows = KnownRows(seconds)


def same_bits(one, other):
    """Two batches hold the same rows, bit for bit."""
    for name, values in one.as_columns().items():
        theirs = other.as_columns()[name]
        assert values.dtype == theirs.dtype and values.shape == theirs.shape, name
        assert values.tobytes() == theirs.tobytes(), name
    assert list(one.message) == list(other.message)
    assert one.interrupted == other.interrupted
    return True
