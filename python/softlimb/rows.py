"""Rows of pressures in, rows of postures out: the solver behind a sweep.

What a sweep is made of besides (chunks, files, workers of other machines, progress) stands on `solve_rows` alone.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from softlimb import _core
from softlimb.arguments import finite_of_shape, shown, truth

if TYPE_CHECKING:
    from softlimb.limb import Limb

__all__ = ["GROUP", "INVALID", "NOT_RUN", "Atlas", "Rows", "build", "solve_rows", "survey_rows"]

CONVERGED = "converged"
"""Status of a row in equilibrium to the tolerance asked for."""

NOT_RUN = "not_run"
"""Status of a row that an interrupted sweep did not come to."""

INVALID = "invalid"
"""Status of a row whose pressures the limb refuses; the message has the reason."""

GROUP = _core.CHUNK_ROWS
"""Rows in which an ordered sweep chains neighbours; the first of each starts by itself."""

Atlas = _core.Atlas
"""Where the rows of a long sweep start: see `survey_rows`. It may travel to other processes."""

_STATUS = dict(enumerate(_core.status_names())) | {-1: NOT_RUN}


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
            unstable_modes=np.full(count, -1, dtype=np.int64),
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
    atlas: Atlas | None = None,
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
        Rows 0..31, 32..63, ... are groups in which a row starts from where those before it lead that succeeded.
        Otherwise a row depends on itself alone.
    tick : callable
        Called about ten times a second, from the thread of the caller, with the number of rows done; false stops, and
        so does Ctrl-C. Rows not come to have status "not_run".
    atlas : Atlas, optional
        Where rows start from; not with a start. A row depends on itself (or its group) and on the atlas then.
    **scene
        Loads and options of `Limb.solve`, the same for all rows. What it refuses, it refuses for all: every row then
        has status "invalid".

    Returns
    -------
    Rows

    Raises
    ------
    ValueError
        Pressures of another shape or not finite, ``threads`` below 1, an atlas with a start.
    TypeError
        `Limb.solve` has no such option.
    """
    rows = Rows.not_run(len(pressures), len(limb.segments))
    given = _checked(limb, pressures, threads)
    try:
        common = limb._common_scene(**scene)
    except ValueError as error:
        rows.status[:] = [INVALID] * len(rows)
        rows.message.update(dict.fromkeys(range(len(rows)), str(error)))
        return rows
    if atlas is not None and not common.from_nothing:
        raise ValueError("atlas must be None where rows have a start, or may be unstable")
    status = np.full(len(rows), -1, dtype=np.int8)
    try:
        _core.sweep_rows(
            limb._geometry,
            limb._core_members,
            common.core,
            given,
            tolerance=common.tolerance,
            prefer_stable=common.prefer_stable,
            section=common.model[0],
            valve=common.model[1],
            ordered=truth("ordered", ordered),
            atlas=atlas,
            threads=threads,
            start=common.start,
            start_plates=common.start_plates,
            tip=rows.tip,
            plates=rows.plates,
            status=status,
            success=rows.success,
            stable=rows.stable,
            unstable_modes=rows.unstable_modes,
            clearance=rows.clearance,
            iterations=rows.iterations,
            residual=rows.residual,
            message=rows.message,
            tick=tick,
        )
    except KeyboardInterrupt:
        pass
    rows.status[:] = [_STATUS[number] for number in status.tolist()]
    return rows


def survey_rows(
    limb: Limb, pressures: NDArray[np.float64], *, threads: int, tick: Callable[[int], bool], **scene: Any
) -> Atlas | None:
    """Solve some rows of a long sweep, the first ones from nothing, and fit to them where the others may start.

    Parameters
    ----------
    limb : Limb
    pressures : array of float, shape (N, A)
        Gauge pressures [Pa], flat order, finite; the same rows in another order give another atlas, by rounding.
    threads, tick, **scene
        As for `solve_rows`.

    Returns
    -------
    Atlas or None
        None where rows had better start by themselves: they have a start, may be unstable, or the limb refuses the
        scene; a plate is held; too few of the rows succeed, or one has another stable posture; or the work was stopped.

    Raises
    ------
    ValueError
        Pressures of another shape or not finite, ``threads`` below 1.
    TypeError
        `Limb.solve` has no such option.
    """
    given = _checked(limb, pressures, threads)
    try:
        common = limb._common_scene(**scene)
    except ValueError:
        return None  # which every row will say
    if not common.from_nothing:
        return None
    return _core.survey_rows(
        limb._geometry,
        limb._core_members,
        common.core,
        given,
        tolerance=common.tolerance,
        section=common.model[0],
        valve=common.model[1],
        threads=threads,
        tick=tick,
    )


def _checked(limb: Limb, pressures: NDArray[np.float64], threads: int) -> NDArray[np.float64]:
    given = np.ascontiguousarray(finite_of_shape("pressures", pressures, (len(pressures), len(limb._tubes))))
    if isinstance(threads, bool) or not isinstance(threads, int) or threads < 1:
        raise ValueError(f"threads must be a whole number of at least 1, got {shown(threads)}")
    return given


def build() -> str:
    """What solves here: version, fingerprint of the compiled core, instruction set. The same text, the same bits."""
    return f"{_compiled()}, instruction set {_core.instruction_set()}"


@cache
def _compiled() -> str:
    from importlib.metadata import version

    core = hashlib.sha256(Path(_core.__file__).read_bytes()).hexdigest()[:12]
    return f"softlimb {version('softlimb')}, core {core}"
