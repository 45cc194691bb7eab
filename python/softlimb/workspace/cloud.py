"""The workspace of a limb: where its tip gets to, how many postures lead there, and how the tip is turned."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb.arguments import one_finite, one_of, one_positive, one_real, one_whole
from softlimb.reach import bounds_of
from softlimb.sweep import NOT_RUN, Batch, file_path, sweep
from softlimb.units import deg, kPa, mm
from softlimb.workspace.edges import directions, edge_pressures
from softlimb.workspace.explore import pressures_nearby
from softlimb.workspace.hull import convex_hull
from softlimb.workspace.samples import Sampling, pressure_samples
from softlimb.workspace.voxels import Cells, Occupancy, cells_of, occupancy

if TYPE_CHECKING:
    import xarray

    from softlimb.limb import Limb

__all__ = ["ReachableVolume", "Regions", "Slice", "Workspace", "workspace"]

Array = NDArray[np.float64]
AxisName = Literal["x", "y", "z"]

_ROUNDS = 8  # of exploring; each starts from all postures before it
_SLICE = 0.05  # thickness of a slice, as a part of the box


@dataclass(frozen=True, eq=False)
class Regions:
    """What is known of each part of the workspace, one entry a voxel.

    Parameters
    ----------
    cell : float
        Edge of the voxels [m].
    centres : array of float, shape (M, 3)
        Base frame [m].
    counts : array of int, shape (M,)
        Postures whose tip is there.
    tilt_min, tilt_max : array of float, shape (M,)
        Range of the angle between the tip's and the base's axis [rad].
    spread : array of float, shape (M,)
        Largest angle of a tip's axis to the mean of the axes there [rad]: how far the tip can be turned while it
        stays.
    """

    cell: float
    centres: Array
    counts: NDArray[np.int64]
    tilt_min: Array
    tilt_max: Array
    spread: Array

    @property
    def density(self) -> Array:
        """Share of all postures per volume [1/m^3], shape (M,)."""
        found: Array = self.counts / (max(int(self.counts.sum()), 1) * self.cell**3)
        return found


@dataclass(frozen=True, eq=False)
class Slice:
    """The tips in a slab across the workspace.

    Parameters
    ----------
    axis : {"x", "y", "z"}
        Normal of the slab.
    at, thickness : float
        Where its middle is, and how thick it is [m].
    rows : array of int, shape (K,)
        Numbers of the postures in the batch.
    points : array of float, shape (K, 2)
        Their tips along the other two axes, in their order [m].
    area : Occupancy
        Of the points seen along the axis.
    """

    axis: AxisName
    at: float
    thickness: float
    rows: NDArray[np.int64]
    points: Array
    area: Occupancy


@dataclass(frozen=True)
class ReachableVolume:
    """Volume by asking of random points of the box whether the tip gets there.

    Parameters
    ----------
    box_volume : float
        [m^3]
    points, reached : int
        How many were asked, and how many are reached.
    """

    box_volume: float
    points: int
    reached: int

    @property
    def value(self) -> float:
        """Share of the points that are reached, times the box [m^3]."""
        return self.box_volume * self.reached / self.points

    @property
    def standard_error(self) -> float:
        """Of the share alone, binomial [m^3]; of a share of 0 or 1 that of half a point."""
        share = min(max(self.reached, 0.5), self.points - 0.5) / self.points
        return float(self.box_volume * np.sqrt(share * (1.0 - share) / self.points))


@dataclass(frozen=True, eq=False)
class Workspace:
    """A cloud of tips, and what is asked of it.

    Only rows that succeeded and are stable count, see `message` for the others. Everything is that of these postures:
    where pressures were not tried, nothing is known.

    Parameters
    ----------
    batch : Batch
        The postures.
    edge_rows : int
        How many of its last rows were searched for on the edge; the rows before are samples.
    min_clearance : float, optional
        Rows whose tubes come nearer than this do not count [m]. Contact is no part of the model.
    """

    batch: Batch
    edge_rows: int = 0
    min_clearance: float | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.batch, Batch):
            raise TypeError(f"batch must be a Batch, got {type(self.batch).__name__}")
        if one_whole("edge_rows", self.edge_rows, 0) > len(self.batch):
            raise ValueError(f"edge_rows must be at most the {len(self.batch)} rows, got {self.edge_rows}")
        if self.min_clearance is not None:
            object.__setattr__(self, "min_clearance", one_finite("min_clearance", self.min_clearance))

    # --- rows -----------------------------------------------------------------------------------------------------

    @cached_property
    def rows(self) -> NDArray[np.int64]:
        """Numbers of the rows that count, shape (M,)."""
        return np.flatnonzero(self._counts & self._clear)

    @property
    def _counts(self) -> NDArray[np.bool_]:
        found: NDArray[np.bool_] = self.batch.success & self.batch.stable
        return found

    @property
    def _clear(self) -> NDArray[np.bool_]:
        """Rows whose tubes keep their distance; of unknown radii nothing is known, and they count."""
        if self.min_clearance is None:
            return np.ones(len(self.batch), dtype=bool)
        found: NDArray[np.bool_] = ~(self.batch.clearance < self.min_clearance)
        return found

    @property
    def samples(self) -> int:
        """Rows of the batch that are no edge rows."""
        return len(self.batch) - self.edge_rows

    @property
    def failed(self) -> int:
        """Rows without a posture."""
        return int((~self.batch.success).sum()) - len(self.batch.having(NOT_RUN))

    @property
    def unstable(self) -> int:
        """Rows with a posture that is not stable, or not known to be."""
        return int((self.batch.success & ~self.batch.stable).sum())

    @property
    def touching(self) -> int:
        """Rows that count although two tubes touch or overlap, which the model does not feel."""
        return int((self.batch.clearance[self.rows] <= 0.0).sum())

    @cached_property
    def message(self) -> str:
        """Which rows count and which do not, in words."""
        parts = [f"{len(self.rows)} of {len(self.batch)} postures count"]
        if len(self.rows) and not self.volume.dense:
            parts.append("they are too few for their volume: it misses more than its error says")
        if self.failed:
            row, reason = next((row, text) for row, text in self.batch.failures.items() if text != NOT_RUN)
            parts.append(f"{self.failed} failed (row {row}: {reason})")
        if self.unstable:
            parts.append(f"{self.unstable} are not stable")
        not_run = len(self.batch.having(NOT_RUN))
        if not_run:
            parts.append(f"{not_run} were not run")
        near = int((self._counts & ~self._clear).sum())
        if near:
            assert self.min_clearance is not None
            parts.append(f"{near} have tubes nearer than {self.min_clearance / mm:.4g} mm")
        if self.touching:
            parts.append(f"tubes touch in {self.touching} of those that count: contact is not in the model")
        if not len(self.rows):
            parts.append("an empty workspace has no size")
        return "; ".join(parts)

    @cached_property
    def positions(self) -> Array:
        """Tips that count, base frame [m], shape (M, 3)."""
        found: Array = self.batch.tip[self.rows, :3, 3]
        return found

    @cached_property
    def axes(self) -> Array:
        """Directions of the tips' z axes, base frame, shape (M, 3)."""
        found: Array = self.batch.tip[self.rows, :3, 2]
        return found

    @cached_property
    def tilt(self) -> Array:
        """Angle between the tip's and the base's axis [rad], shape (M,)."""
        return self.batch.bending[self.rows]

    @property
    def pressure_range(self) -> tuple[Array, Array]:
        """Smallest and largest pressure of each actuator among all rows [Pa], shape (A,) each."""
        return self.batch.pressures.min(axis=0), self.batch.pressures.max(axis=0)

    def first(self, samples: int) -> Workspace:
        """The workspace of the first samples alone, without edge rows: what the same run had shown by then.

        Parameters
        ----------
        samples : int

        Raises
        ------
        ValueError
            There are not so many.
        """
        if one_whole("samples", samples, 1) > self.samples:
            raise ValueError(f"samples must be at most {self.samples}, got {samples}")
        return Workspace(self.batch.head(samples), 0, self.min_clearance)

    # --- sizes ----------------------------------------------------------------------------------------------------

    @cached_property
    def box(self) -> Array:
        """Lowest and highest x, y, z of the tip, base frame [m], shape (2, 3); NaN where no row counts."""
        if not len(self.rows):
            return np.full((2, 3), np.nan)
        return np.stack([self.positions.min(axis=0), self.positions.max(axis=0)])

    @property
    def extents(self) -> Array:
        """Sides of the box [m], shape (3,)."""
        sides: Array = self.box[1] - self.box[0]
        return sides

    @cached_property
    def reach(self) -> float:
        """Largest distance of the tip from the base frame's origin [m]; NaN where no row counts."""
        return float(np.linalg.norm(self.positions, axis=1).max()) if len(self.rows) else float("nan")

    @cached_property
    def tilt_range(self) -> tuple[float, float]:
        """Smallest and largest angle between the tip's and the base's axis [rad]; NaN where no row counts."""
        if not len(self.rows):
            return float("nan"), float("nan")
        return float(self.tilt.min()), float(self.tilt.max())

    @cached_property
    def volume(self) -> Occupancy:
        """Volume by voxels of the size that `voxel_volume` chooses."""
        return self.voxel_volume()

    def voxel_volume(self, cell: float | None = None) -> Occupancy:
        """Volume by voxels: with ``size``, ``error``, ``lower``, ``upper`` [m^3] and the edge ``cell`` [m].

        Parameters
        ----------
        cell : float, optional
            Edge [m]. Default: as fine as the number of postures allows.

        Raises
        ------
        ValueError
            The edge is not positive, or below a millionth of the cloud.

        Notes
        -----
        The error covers resolution and the voxels that more postures of the same kind would add; MECHANICS,
        "Workspace".
        """
        return occupancy(self.positions, cell)

    @cached_property
    def hull_volume(self) -> float:
        """Volume of the convex hull of all tips [m^3]; zero for a flat cloud, NaN where no row counts.

        It counts hollows and notches as full, and grows with every posture that lies farther out.

        Raises
        ------
        ModuleNotFoundError
            scipy is missing: install ``softlimb[workspace]``.
        """
        if not len(self.rows):
            return float("nan")
        hull = convex_hull(self.positions)
        return 0.0 if hull is None else float(hull.volume)

    def volume_by_reach(self, points: int = 200, *, seed: int = 0) -> ReachableVolume:
        """Volume by `Limb.reach`: an estimate that does not depend on how densely the postures lie.

        Parameters
        ----------
        points : int
            Random points of the box that are asked for; each takes some tens of milliseconds.
        seed : int

        Returns
        -------
        ReachableVolume
            Too small where a search misses an answer, and where the workspace goes beyond the box.

        Raises
        ------
        ValueError
            No row counts, or the number of points is not positive.
        """
        points, seed = one_whole("points", points, 1), one_whole("seed", seed, 0)
        if not len(self.rows):
            raise ValueError(f"an empty workspace has no box: {self.message}")
        scene = {name: value for name, value in self.batch.scene.items() if name not in ("start", "prefer_stable")}
        limb, (lower, upper) = self.batch.limb, self.pressure_range
        reached = 0
        for target in self.box[0] + self.extents * np.random.default_rng(seed).random((points, 3)):
            near = self.rows[np.argmin(np.linalg.norm(self.positions - target, axis=1))]
            start = limb.solve(self.batch.pressures[near], **scene)
            reached += limb.reach(position=target, min_pressure=lower, max_pressure=upper, start=start, **scene).reached
        return ReachableVolume(float(np.prod(self.extents)), points, reached)

    # --- inside ---------------------------------------------------------------------------------------------------

    def regions(self, cell: float | None = None) -> Regions:
        """Density and orientation, voxel by voxel.

        Parameters
        ----------
        cell : float, optional
            Edge of the voxels [m]. Default: that of `volume`.
        """
        found: Cells = cells_of(self.positions, self.volume.cell if cell is None else cell)
        if not len(found.counts):
            none = np.empty(0)
            return Regions(found.cell, found.centres, found.counts, none, none, none)
        order = np.argsort(found.of_point, kind="stable")
        starts = np.cumsum(found.counts) - found.counts
        tilt, axes = self.tilt[order], self.axes[order]
        mean = np.add.reduceat(axes, starts, axis=0)
        of = np.repeat(np.arange(len(starts)), found.counts)
        # atan2 keeps small angles, which the arc cosine loses.
        angle = np.arctan2(np.linalg.norm(np.cross(mean[of], axes), axis=1), np.einsum("ij,ij->i", mean[of], axes))
        return Regions(
            found.cell,
            found.centres,
            found.counts,
            np.minimum.reduceat(tilt, starts),
            np.maximum.reduceat(tilt, starts),
            np.maximum.reduceat(angle, starts),
        )

    def slice(
        self,
        axis: AxisName = "z",
        at: float | None = None,
        *,
        thickness: float | None = None,
        cell: float | None = None,
    ) -> Slice:
        """The tips in a slab.

        Parameters
        ----------
        axis : {"x", "y", "z"}
            Its normal.
        at : float, optional
            Its middle [m]. Default: that of the box.
        thickness : float, optional
            [m] Default: a twentieth of the box.
        cell : float, optional
            Edge of the squares that measure its area [m]. Default: as fine as its postures allow.

        Raises
        ------
        ValueError
            The axis is none of the three, a length is not finite and positive, or no row counts.
        """
        one_of("axis", axis, ("x", "y", "z"))
        if not len(self.rows):
            raise ValueError(f"an empty workspace has no slice: {self.message}")
        normal = "xyz".index(axis)
        middle = float(self.box[:, normal].mean()) if at is None else one_finite("at", at)
        thick = _SLICE * float(self.extents[normal]) if thickness is None else thickness
        thick = one_positive("thickness", thick)
        inside = np.abs(self.positions[:, normal] - middle) <= 0.5 * thick
        points = np.delete(self.positions[inside], normal, axis=1)
        return Slice(axis, middle, thick, self.rows[inside], points, occupancy(points, cell))

    # --- files ----------------------------------------------------------------------------------------------------

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the postures as the file of a sweep; errors as for `Batch.save`."""
        self.batch.save(path)

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, edge_rows: int = 0, min_clearance: float | None = None) -> Workspace:
        """The workspace of the postures in the file of a sweep; errors as for `Batch.load`.

        Parameters
        ----------
        path : str or path
        edge_rows, min_clearance
            As for the class: the file does not tell edge rows from samples, which matters for `first` alone.
        """
        return cls(Batch.load(path), edge_rows, min_clearance)

    def to_xarray(self) -> xarray.Dataset:
        """The dataset of the batch, with ``counts`` (row), and sizes as attributes.

        Raises
        ------
        ModuleNotFoundError
            xarray is missing: install ``softlimb[sweep]``.
        """
        data = self.batch.to_xarray()
        counts = np.zeros(len(self.batch), dtype=bool)
        counts[self.rows] = True
        data["counts"] = (("row",), counts)
        data.attrs |= {
            "volume_m3": self.volume.size,
            "volume_error_m3": self.volume.error,
            "voxel_m": self.volume.cell,
            "box_m": self.box.ravel(),
            "reach_m": self.reach,
            "edge_rows": self.edge_rows,
        }
        return data

    def __len__(self) -> int:
        return len(self.rows)

    def __repr__(self) -> str:
        low, high = self.pressure_range if len(self.batch) else (np.zeros(1), np.zeros(1))
        x, y, z = self.extents / mm
        volume = self.volume
        return (
            f"Workspace({len(self)} postures at {low.min() / kPa:.4g} to {high.max() / kPa:.4g} kPa, "
            f"box {x:.4g} x {y:.4g} x {z:.4g} mm, {volume.size:.3g} +- {volume.error:.2g} m^3, "
            f"tilt to {self.tilt_range[1] / deg:.3g} deg)"
        )


def workspace(
    limb: Limb,
    *,
    max_pressure: ArrayLike | Sequence[ArrayLike],
    min_pressure: ArrayLike | Sequence[ArrayLike] = 0.0,
    samples: int = 100_000,
    sampling: Sampling = "halton",
    at_bounds: float = 0.5,
    explore: float = 0.75,
    edge_directions: int = 64,
    seed: int = 0,
    min_clearance: float | None = None,
    threads: int | None = None,
    executor: Executor | Callable[[], Executor] | None = None,
    progress: bool = True,
    file: str | os.PathLike[str] | None = None,
    **scene: Any,
) -> Workspace:
    """See `Limb.workspace`."""
    if not sum(len(segment.actuators) for segment in limb.segments):
        raise ValueError("the limb has no actuators: no pressure moves its tip")
    if "ordered" in scene:
        raise TypeError("ordered does not apply: the postures of a workspace are no path")
    lower, upper, _ = bounds_of(limb, min_pressure, max_pressure)
    along = one_whole("edge_directions", edge_directions, 0)
    if min_clearance is not None:
        min_clearance = one_finite("min_clearance", min_clearance)
    share, total = one_real("explore", explore), one_whole("samples", samples, 1)
    if not 0.0 <= share < 1.0:
        raise ValueError(f"explore must be within [0, 1), got {share!r}")
    path = None if file is None else file_path("file", file)
    options: dict[str, Any] = {"threads": threads, "executor": executor, "progress": progress, **scene}

    explored = int(share * total)
    if sampling == "grid" and total - explored < 2 ** len(lower):
        raise ValueError(
            f"samples must be at least {2 ** len(lower)} for a grid of two pressures in each of {len(lower)} "
            f"actuators, got {total}, of which explore={share:g} leaves {total - explored} to the grid"
        )
    pressures = pressure_samples(lower, upper, total - explored, sampling=sampling, seed=seed, at_bounds=at_bounds)
    batch = sweep(limb, pressures, file=path, **options)
    for number, rows in enumerate(np.array_split(np.arange(explored), _ROUNDS), start=1):
        if batch.interrupted or not len(rows):
            break
        rng = np.random.default_rng((seed, number))
        pressures = pressures_nearby(batch, lower, upper, len(rows), rng)
        beside = None if path is None else path.with_name(f"{path.name}.{number}")
        batch = batch.followed_by(sweep(limb, pressures, file=beside, **options))
    if batch.interrupted or not along:
        return Workspace(batch, 0, min_clearance)
    edge = edge_pressures(batch, lower, upper, directions(along), threads)
    if not len(edge):
        return Workspace(batch, 0, min_clearance)
    found = sweep(limb, edge, threads=threads, progress=False, **scene)
    return Workspace(batch.followed_by(found), len(found), min_clearance)
