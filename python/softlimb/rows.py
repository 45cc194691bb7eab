"""Rows of pressures in, rows of postures out: the solver behind a sweep.

What a sweep is made of besides (chunks, files, workers of other machines, progress) stands on `solve_rows` alone.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from softlimb import _core

if TYPE_CHECKING:
    from softlimb.limb import Limb

__all__ = ["GROUP", "INVALID", "NOT_RUN", "Rows", "build", "solve_rows"]

CONVERGED = "converged"
"""Status of a row in equilibrium to the tolerance asked for."""

NOT_RUN = "not_run"
"""Status of a row that an interrupted sweep did not come to."""

INVALID = "invalid"
"""Status of a row whose pressures the limb refuses; the message has the reason."""

GROUP = 32
"""Rows in which an ordered sweep chains neighbours; the first of each starts by itself."""

_TICK = 0.1  # [s] between two looks at who wants to stop


@dataclass(frozen=True, kw_only=True, eq=False)
class Rows:
    """Postures as arrays, one row each.

    Parameters
    ----------
    tip : array of float, shape (N, 4, 4)
        Pose of the tip in the base frame [m]; NaN where the row did not succeed, as are `plates` and `clearance`.
    plates : array of float, shape (N, J, 4, 4)
        Pose of every plate in the base frame [m].
    success : array of bool, shape (N,)
    status : list of str, length N
        As of a posture; "not_run" where the solver was stopped before, "invalid" where the limb refuses the pressures.
    stable : array of bool, shape (N,)
        False as well where the stability of a row is not known.
    unstable_modes : array of int, shape (N,)
        -1 where not known.
    clearance : array of float, shape (N,)
        Smallest gap between tubes [m], NaN when their radii are not known.
    iterations : array of int, shape (N,)
    residual : array of float, shape (N,)
    message : dict of int to str
        By row, where it says more than the status.
    """

    tip: NDArray[np.float64]
    plates: NDArray[np.float64]
    success: NDArray[np.bool_]
    status: list[str]
    stable: NDArray[np.bool_]
    unstable_modes: NDArray[np.int64]
    clearance: NDArray[np.float64]
    iterations: NDArray[np.int64]
    residual: NDArray[np.float64]
    message: dict[int, str]

    def __len__(self) -> int:
        return len(self.status)

    @classmethod
    def not_run(cls, count: int, plates: int) -> Rows:
        """Rows that nobody has come to yet."""
        return cls(
            tip=np.full((count, 4, 4), np.nan),
            plates=np.full((count, plates, 4, 4), np.nan),
            success=np.zeros(count, dtype=bool),
            status=[NOT_RUN] * count,
            stable=np.zeros(count, dtype=bool),
            unstable_modes=np.full(count, -1),
            clearance=np.full(count, np.nan),
            iterations=np.zeros(count, dtype=np.int64),
            residual=np.full(count, np.nan),
            message={},
        )


def solve_rows(
    limb: Limb,
    pressures: NDArray[np.float64],
    *,
    threads: int,
    ordered: bool,
    tick: Callable[[int], bool],
    **scene: Any,
) -> Rows:
    """Solve one posture a row.

    Parameters
    ----------
    limb : Limb
    pressures : array of float, shape (N, A)
        Gauge pressures [Pa], flat order, finite.
    threads : int
        How many may work at once; no bit of the rows depends on it.
    ordered : bool
        Rows 0..31, 32..63, ... are groups in which a row starts from the posture before it. Otherwise a row depends on
        itself alone.
    tick : callable
        Called about ten times a second, from the thread of the caller, with the number of rows done; false stops.
    **scene
        Loads and options of `Limb.solve`, the same for all rows.

    Returns
    -------
    Rows

    Raises
    ------
    ValueError, TypeError
        `Limb.solve` has no such option.
    """
    rows = Rows.not_run(len(pressures), len(limb.segments))
    own_start, before, looked = scene.pop("start", None), None, time.monotonic()
    try:
        for row in range(len(pressures)):
            if time.monotonic() - looked > _TICK:
                looked = time.monotonic()
                if not tick(row):
                    break
            if not ordered or row % GROUP == 0:
                before = None
            try:
                posture = limb.solve(pressures[row], **scene, start=own_start if before is None else before)
            except ValueError as error:
                rows.status[row], rows.message[row] = INVALID, str(error)
                continue
            rows.iterations[row], rows.residual[row] = posture.iterations, posture.residual
            if posture.success:
                before = posture
                rows.tip[row], rows.plates[row] = posture.tip, posture.plates
                rows.stable[row] = posture.stable
                rows.unstable_modes[row] = -1 if posture.unstable_modes is None else posture.unstable_modes
                rows.clearance[row] = np.nan if posture.clearance is None else posture.clearance
                rows.success[row] = True
            if posture.message != posture.status:
                rows.message[row] = posture.message
            rows.status[row] = posture.status  # last: Ctrl-C leaves no row half done under a status
    except KeyboardInterrupt:
        pass
    return rows


@cache
def build() -> str:
    """What solves here: version, fingerprint of the compiled core, instruction set. The same text, the same bits."""
    from importlib.metadata import version

    instructions = getattr(_core, "instruction_set", "unknown")
    if callable(instructions):
        instructions = instructions()
    core = hashlib.sha256(Path(_core.__file__).read_bytes()).hexdigest()[:12]
    return f"softlimb {version('softlimb')}, core {core}, instruction set {instructions}"
