"""Many postures of one limb under one scene: rows of pressures in, a table out."""

from __future__ import annotations

import csv
import dataclasses
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb.arguments import real_array, truth
from softlimb.units import deg, kPa, mm

if TYPE_CHECKING:
    import xarray

    from softlimb.limb import Limb

NOT_RUN = "not_run"
"""Status of a row that an interrupted sweep did not come to."""

INVALID = "invalid"
"""Status of a row whose pressures the limb refuses; the message has the reason."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Batch:
    """The outcome of a sweep, one row a posture.

    Where a row did not succeed its poses are NaN: a table that is plotted without a look at `success` shows a gap and
    not a wrong point.

    Parameters
    ----------
    limb : Limb
    scene : mapping
        Loads and options that all rows share, as `Limb.solve` takes them.
    pressures : array of float, shape (N, A)
        Gauge pressures [Pa], flat order.
    tip : array of float, shape (N, 4, 4)
        Pose of the tip in the base frame [m].
    plates : array of float, shape (N, J, 4, 4)
        Pose of every plate in the base frame [m].
    success : array of bool, shape (N,)
    status, message : list of str, length N
        Why a row ended as it did.
    stable : array of bool, shape (N,)
        False as well where the stability of a row is not known.
    clearance : array of float, shape (N,)
        Smallest gap between tubes [m], NaN when their radii are not known.
    iterations : array of int, shape (N,)
    residual : array of float, shape (N,)
    interrupted : bool
        True when the sweep was stopped; the rows not come to have status "not_run".
    """

    limb: Limb
    scene: Mapping[str, Any]
    pressures: NDArray[np.float64]
    tip: NDArray[np.float64]
    plates: NDArray[np.float64]
    success: NDArray[np.bool_]
    status: list[str]
    message: list[str]
    stable: NDArray[np.bool_]
    clearance: NDArray[np.float64]
    iterations: NDArray[np.int64]
    residual: NDArray[np.float64]
    interrupted: bool = False

    def __len__(self) -> int:
        return len(self.pressures)

    def __repr__(self) -> str:
        stopped = ", interrupted" if self.interrupted else ""
        return f"Batch({len(self)} postures, {int(self.success.sum())} successful{stopped})"

    @property
    def bending(self) -> NDArray[np.float64]:
        """Angle between the tip's axis and the base's axis [rad], shape (N,)."""
        return bending_angle(self.tip)

    @property
    def failures(self) -> dict[int, str]:
        """Row number to message of every row that did not succeed."""
        return {row: self.message[row] for row in np.flatnonzero(~self.success).tolist()}

    def columns(self) -> dict[str, list[Any]]:
        """The table as columns whose names carry their units.

        Returns
        -------
        dict of str to list
            ``pressure_1_1_kPa`` (segment and actuator from 1) ..., ``tip_x_mm`` ..., ``tip_rotation_x_deg`` (rotation
            vector) ..., ``bending_deg``, ``clearance_mm``, ``success``, ``stable``, ``status``, ``message``.
        """
        names = _actuator_names(self.limb)
        table: dict[str, list[Any]] = {
            f"pressure_{name}_kPa": (self.pressures[:, i] / kPa).tolist() for i, name in enumerate(names)
        }
        rotation = rotation_vector(self.tip) / deg
        for i, axis in enumerate("xyz"):
            table[f"tip_{axis}_mm"] = (self.tip[:, i, 3] / mm).tolist()
        for i, axis in enumerate("xyz"):
            table[f"tip_rotation_{axis}_deg"] = rotation[:, i].tolist()
        table["bending_deg"] = (self.bending / deg).tolist()
        table["clearance_mm"] = (self.clearance / mm).tolist()
        table["success"] = self.success.tolist()
        table["stable"] = self.stable.tolist()
        return table | {"status": self.status, "message": self.message}

    def to_csv(self, path: str | Path) -> None:
        """Write `columns` as a comma-separated table; an unknown number is an empty cell.

        Parameters
        ----------
        path : str or Path
        """
        table = self.columns()
        with Path(path).open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(table)
            writer.writerows([_cell(entry) for entry in row] for row in zip(*table.values(), strict=True))

    def to_xarray(self) -> xarray.Dataset:
        """The table as a dataset in SI, with units as attributes and the scene inside.

        Returns
        -------
        xarray.Dataset
            ``pressure`` (row, actuator), ``tip_position`` (row, axis), ``tip_rotation`` (row, axis, frame_axis),
            ``plate_position``, ``plate_rotation``, ``bending``, ``clearance``, ``success``, ``stable``, ``status``,
            ``message``, ``iterations``, ``residual``; attribute ``scene`` is a TOML document.

        Raises
        ------
        ModuleNotFoundError
            xarray is missing: install ``softlimb[sweep]``.
        """
        try:
            import xarray
        except ModuleNotFoundError:
            raise ModuleNotFoundError("this needs xarray: pip install 'softlimb[sweep]'") from None
        from importlib.metadata import version

        position, rotation = ("axis",), ("axis", "frame_axis")
        metres, turned = {"units": "m"}, {"units": "1", "long_name": "rotation matrix, base axes by frame axes"}
        variables = {
            "pressure": (("row", "actuator"), self.pressures, {"units": "Pa", "long_name": "gauge pressure"}),
            "tip_position": (("row", *position), self.tip[:, :3, 3], metres),
            "tip_rotation": (("row", *rotation), self.tip[:, :3, :3], turned),
            "plate_position": (("row", "plate", *position), self.plates[:, :, :3, 3], metres),
            "plate_rotation": (("row", "plate", *rotation), self.plates[:, :, :3, :3], turned),
            "bending": (("row",), self.bending, {"units": "rad", "long_name": "angle of the tip's to the base's axis"}),
            "clearance": (("row",), self.clearance, {"units": "m", "long_name": "smallest gap between tubes"}),
            "residual": (("row",), self.residual, {"units": "1"}),
            "iterations": (("row",), self.iterations, {"units": "1"}),
            "success": (("row",), self.success, {}),
            "stable": (("row",), self.stable, {}),
            "status": (("row",), np.array(self.status, dtype=object), {}),
            "message": (("row",), np.array(self.message, dtype=object), {}),
        }
        coordinates = {
            "actuator": _actuator_names(self.limb),
            "plate": np.arange(1, self.plates.shape[1] + 1),
            "axis": list("xyz"),
            "frame_axis": list("xyz"),
        }
        attributes = {
            "scene": scene_text(self.limb, self.scene),
            "reference_length_m": float(self.limb.length),
            "interrupted": int(self.interrupted),
            "source": f"softlimb {version('softlimb')}",
        }
        return xarray.Dataset(variables, coords=coordinates, attrs=attributes)


def sweep(limb: Limb, pressures: ArrayLike, *, progress: bool = True, **scene: Any) -> Batch:
    """Solve one posture for each row of pressures.

    Each row starts from its own fixed rule, so it depends neither on the other rows nor on their order.

    Parameters
    ----------
    limb : Limb
    pressures : array_like, shape (N, A) or (N, J, n)
        Gauge pressures [Pa], flat order.
    progress : bool
        Show a progress bar when tqdm is installed.
    **scene
        Loads and options of `Limb.solve`, the same for all rows.

    Returns
    -------
    Batch
        Complete whatever happens to single rows: each has its status and message. Ctrl-C keeps the rows done so far.

    Raises
    ------
    ValueError
        Pressures of a wrong shape, not finite or not real numbers, or loads that `Limb.solve` refuses.
    """
    rows, shows = real_array("pressures", pressures), truth("progress", progress)
    actuators = len(_actuator_names(limb))
    counts = {len(segment.actuators) for segment in limb.segments}
    if rows.ndim == 3 and len(counts) == 1 and rows.shape[1:] == (len(limb.segments), *counts):
        rows = rows.reshape(len(rows), actuators)
    if rows.ndim != 2 or rows.shape[1] != actuators:
        raise ValueError(
            f"pressures has shape {rows.shape} but the limb has {actuators} actuators: expected (N, {actuators})"
        )
    broken = np.flatnonzero(~np.isfinite(rows).all(axis=1))
    if broken.size:
        raise ValueError(f"pressures must be finite; row {broken[0]} is {rows[broken[0]].tolist()}")
    count, plates = len(rows), len(limb.segments)
    batch = Batch(
        limb=limb,
        scene=scene,
        pressures=rows,
        tip=np.full((count, 4, 4), np.nan),
        plates=np.full((count, plates, 4, 4), np.nan),
        success=np.zeros(count, dtype=bool),
        status=[NOT_RUN] * count,
        message=["the sweep was interrupted before this row"] * count,
        stable=np.zeros(count, dtype=bool),
        clearance=np.full(count, np.nan),
        iterations=np.zeros(count, dtype=int),
        residual=np.full(count, np.nan),
    )
    refused: ValueError | None = None
    try:
        for row in _with_progress(range(count), shows):
            try:
                _solve_row(batch, row)
            except ValueError as error:
                refused = error
                batch.status[row], batch.message[row] = INVALID, str(error)
    except KeyboardInterrupt:
        batch = dataclasses.replace(batch, interrupted=True)
    # Refused everywhere: the fault is not in the rows but in what they share.
    if refused is not None and all(status == INVALID for status in batch.status):
        raise refused
    return batch


def _solve_row(batch: Batch, row: int) -> None:
    posture = batch.limb.solve(batch.pressures[row], **batch.scene)
    batch.status[row], batch.message[row] = str(posture.status), posture.message
    batch.iterations[row], batch.residual[row] = posture.iterations, posture.residual
    batch.success[row] = posture.success
    if posture.success:
        batch.tip[row], batch.plates[row] = posture.tip, posture.plates
        batch.stable[row] = bool(posture.stable)
        batch.clearance[row] = np.nan if posture.clearance is None else posture.clearance


def _with_progress(rows: Iterable[int], progress: bool) -> Iterable[int]:
    if not progress:
        return rows
    try:
        from tqdm import tqdm  # type: ignore[import-untyped, unused-ignore]
    except ModuleNotFoundError:
        return rows
    bar: Iterable[int] = tqdm(rows, unit="posture")
    return bar


def bending_angle(pose: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angle between a pose's z axis and the base's z axis [rad], in [0, pi].

    Parameters
    ----------
    pose : array of float, shape (..., 4, 4)

    Returns
    -------
    array of float, shape (...)
    """
    # atan2 keeps its digits near 0 and pi, where the arc cosine of z loses half of them.
    return np.arctan2(np.hypot(pose[..., 0, 2], pose[..., 1, 2]), pose[..., 2, 2])


def rotation_vector(pose: NDArray[np.float64]) -> NDArray[np.float64]:
    """Axis times angle of a pose's rotation [rad], shape (..., 3).

    Parameters
    ----------
    pose : array of float, shape (..., 4, 4)
    """
    r = pose[..., :3, :3]
    twice_sine = np.stack([r[..., 2, 1] - r[..., 1, 2], r[..., 0, 2] - r[..., 2, 0], r[..., 1, 0] - r[..., 0, 1]], -1)
    norm = np.linalg.norm(twice_sine, axis=-1, keepdims=True)
    twice_cosine = np.trace(r, axis1=-2, axis2=-1)[..., None] - 1.0
    angle = np.arctan2(norm, twice_cosine)
    # Towards half a turn the sine vanishes, but (r + r^T)/2 - cos 1 = (1 - cos) a a^T still holds the axis a.
    symmetric = 0.5 * (r + np.swapaxes(r, -1, -2) - twice_cosine[..., None] * np.eye(3))
    largest = np.argmax(np.nan_to_num(np.diagonal(symmetric, axis1=-2, axis2=-1)), axis=-1)
    column = np.take_along_axis(symmetric, largest[..., None, None], axis=-1)[..., 0]
    sign = np.where(np.sum(column * twice_sine, axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    near_half_turn = angle > 3.0  # [rad]; within 0.14 of pi, where the sine has lost one digit
    with np.errstate(invalid="ignore", divide="ignore"):
        from_column = sign * column / np.linalg.norm(column, axis=-1, keepdims=True)
        from_sine = np.where(norm > 0.0, twice_sine / norm, 0.0)
    return np.where(np.isnan(norm), np.nan, np.where(near_half_turn, from_column, from_sine) * angle)


def scene_text(limb: Limb, options: Mapping[str, Any]) -> str:
    """A limb with its loads and options as a TOML document; a start posture has no such form and is left out."""
    import tomli_w

    from softlimb.scenes import Scene

    fields = {entry.name for entry in dataclasses.fields(Scene)} - {"limb"}
    known = {name: value for name, value in options.items() if name in fields and value is not None}
    vectors = {"gravity", "tip_force", "tip_moment", "plate_wrenches", "tip_pose"} & known.keys()
    known |= {name: np.asarray(known[name], dtype=float) for name in vectors}
    return tomli_w.dumps(Scene(limb=limb, **known).to_dict())


def _actuator_names(limb: Limb) -> list[str]:
    return [f"{j}_{i}" for j, s in enumerate(limb.segments, 1) for i in range(1, len(s.actuators) + 1)]


def _cell(entry: Any) -> Any:
    if isinstance(entry, float):
        # Twelve digits: a picometre in a metre; NaN becomes an empty cell, which every reader takes for missing.
        return "" if np.isnan(entry) else f"{entry:.12g}"
    return entry
