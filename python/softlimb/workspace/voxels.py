"""How large a cloud of points is: the cells of a grid that it occupies, and how far that can be trusted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softlimb.arguments import one_positive

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

# Cells hit by a single point may be this share of all. The estimate of unseen cells is a lower bound, which must stay
# a correction: for a cloud of even density, one in ten means 3.6 points a cell, and 3 % of the cells unseen.
_HIT_ONCE = 0.1
_CELLS_AN_AXIS = (2, 256)  # along the longest side of the cloud, coarsest and finest
_STEP = 2.0**0.25  # from one cell to the next finer one
_SMALLEST = 1e-6  # [m]; a cloud that is smaller counts as one of this size
_MOST_CELLS = 10**6  # along an axis, so that the cells of three axes can be numbered in 64 bits


@dataclass(frozen=True, eq=False)
class Cells:
    """The cells of a grid through the origin that hold points.

    Parameters
    ----------
    cell : float
        Edge [m].
    index : array of int, shape (M, d)
        Cell k spans ``index * cell`` to ``(index + 1) * cell``.
    counts : array of int, shape (M,)
        Points in each.
    of_point : array of int, shape (N,)
        Which of the M cells each point is in.
    inside : array of bool, shape (M,)
        All of its 2d neighbours hold points as well.
    """

    cell: float
    index: Numbers
    counts: Numbers
    of_point: Numbers
    inside: NDArray[np.bool_]

    @property
    def centres(self) -> Array:
        """Shape (M, d) [m]."""
        middle: Array = (self.index.astype(np.float64) + 0.5) * self.cell
        return middle


@dataclass(frozen=True)
class Occupancy:
    """Volume of a cloud in space, or area of one in a plane, out of the cells that it occupies.

    The bracket from ``lower`` to ``upper`` has ``size`` in its middle: a cell whose neighbours are all occupied counts
    in full, one at the edge from nothing to all, and so do cells that no point has hit yet.

    Parameters
    ----------
    cell : float
        Edge of the cells [m].
    dimensions : int
        3 for a volume, 2 for an area.
    points, occupied, inside : int
        Points in the cloud; cells with points; those among them with all neighbours occupied.
    once, twice : int
        Cells with exactly one and exactly two points.
    """

    cell: float
    dimensions: int
    points: int
    occupied: int
    inside: int
    once: int
    twice: int

    @property
    def unseen(self) -> float:
        """Estimated number of cells that no point has hit yet.

        Chao's lower bound f1 (f1 - 1) / (2 (f2 + 1)), and no less than the cells hit once: that many twice as many
        points would add at most, in the mean.
        """
        return max(self.once * (self.once - 1) / (2.0 * (self.twice + 1)), float(self.once))

    @property
    def dense(self) -> bool:
        """At most one occupied cell in ten was hit once only; else more is unseen than the error covers."""
        return self.once <= _HIT_ONCE * self.occupied

    @property
    def _no_volume(self) -> float:
        """NaN of no points in space, of which nothing is known; a plane without points may cross a cloud's outside."""
        return float("nan") if not self.points and self.dimensions == 3 else 0.0

    @property
    def lower(self) -> float:
        """Cells inside the cloud alone [m^3 or m^2]."""
        return self._no_volume or float(self.inside * self.cell**self.dimensions)

    @property
    def upper(self) -> float:
        """All occupied cells and those estimated unseen [m^3 or m^2]."""
        return self._no_volume or float((self.occupied + self.unseen) * self.cell**self.dimensions)

    @property
    def size(self) -> float:
        """Volume [m^3] or area [m^2]: the middle of the bracket."""
        return 0.5 * (self.lower + self.upper)

    @property
    def error(self) -> float:
        """Half the bracket [m^3 or m^2]: resolution and number of points together."""
        return 0.5 * (self.upper - self.lower)


def cells_of(points: Array, cell: float) -> Cells:
    """Sort points into cells.

    Parameters
    ----------
    points : array of float, shape (N, d)
        [m]
    cell : float
        Edge [m].

    Raises
    ------
    ValueError
        The edge is not positive, or so short that an axis would have more than a million cells.
    """
    cell = one_positive("cell", cell)
    if not len(points):
        none = np.empty(0, dtype=np.int64)
        return Cells(cell, np.empty(points.shape, dtype=np.int64), none, none, np.empty(0, dtype=bool))
    if float(np.ptp(points, axis=0).max()) > _MOST_CELLS * cell:
        raise ValueError(f"cell must be at least a millionth of the cloud's size, got {cell!r} m")
    number = np.floor(points / cell).astype(np.int64)
    low = number.min(axis=0) - 1
    shape = number.max(axis=0) - low + 2  # an empty cell on every side
    strides = np.array([np.prod(shape[axis + 1 :], dtype=np.int64) for axis in range(points.shape[1])])
    keys, first, of_point, counts = np.unique(
        (number - low) @ strides, return_index=True, return_inverse=True, return_counts=True
    )
    inside = np.ones(len(keys), dtype=bool)
    for stride in strides:
        inside &= _among(keys, keys - stride) & _among(keys, keys + stride)
    return Cells(cell, number[first], counts, of_point.reshape(-1), inside)


def _among(keys: Numbers, wanted: Numbers) -> NDArray[np.bool_]:
    """Which of the wanted numbers are among sorted keys."""
    place = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
    found: NDArray[np.bool_] = keys[place] == wanted
    return found


def occupancy(points: Array, cell: float | None = None) -> Occupancy:
    """Volume or area of a cloud.

    Parameters
    ----------
    points : array of float, shape (N, d)
        [m]
    cell : float, optional
        Edge of the cells [m]. Default: the finest of a row of edges at which the cells are `Occupancy.dense`; where
        none is, the one with the smallest share of cells that were hit once.

    Returns
    -------
    Occupancy

    Notes
    -----
    Chao, "Nonparametric estimation of the number of classes in a population" (1984), in its bias-corrected form;
    MECHANICS, "Workspace".
    """
    if cell is not None:
        return _measured(points, cell)
    if not len(points):
        return _measured(points, _SMALLEST)
    longest = max(float(np.ptp(points, axis=0).max()), _SMALLEST)
    best = _measured(points, longest / _CELLS_AN_AXIS[0])
    for edge in _edges(longest, len(points)):
        found = _measured(points, edge)
        if found.dense:
            return found
        if found.once * best.occupied < best.once * found.occupied:
            best = found
    return best


def _edges(longest: float, points: int) -> Sequence[float]:
    """Edges of cells from fine to coarse; no finer than what a line of so many points could fill."""
    coarsest, finest = _CELLS_AN_AXIS
    steps = int(np.log(min(finest, max(points, coarsest)) / coarsest) / np.log(_STEP))
    return [longest / (coarsest * _STEP**step) for step in range(steps, -1, -1)]


def _measured(points: Array, cell: float) -> Occupancy:
    found = cells_of(points, cell)
    return Occupancy(
        cell=found.cell,
        dimensions=points.shape[1],
        points=len(points),
        occupied=len(found.counts),
        inside=int(found.inside.sum()),
        once=int((found.counts == 1).sum()),
        twice=int((found.counts == 2).sum()),
    )
