"""The outcome of a sweep: arrays with one row a posture, in memory or in a file, and the tables made of them."""

from __future__ import annotations

import csv
import dataclasses
import os
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from softlimb.arguments import shown
from softlimb.rows import NOT_RUN
from softlimb.sweep.pose_angles import bending_angle, rotation_vector
from softlimb.sweep.record import SweepRecord, normal_options
from softlimb.sweep.row_table import Columns, ListOfTexts, Messages, Statuses, column_types
from softlimb.sweep.sweep_file import Content, read, save
from softlimb.units import deg, kPa, mm

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray

    from softlimb.limb import Limb

__all__ = ["Batch", "actuator_names", "file_path", "scene_text"]

_BLOCK = 16384  # rows of a table that are texts at the same time


@dataclass(frozen=True, kw_only=True, eq=False)
class Batch:
    """The outcome of a sweep, one row a posture.

    Where a row did not succeed its poses are NaN: a table that is plotted without a look at `success` shows a gap and
    not a wrong point. A batch that stands in a file has views of the file: what is not looked at takes no memory.

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
    status, message : sequence of str, length N
        Why a row ended as it did.
    stable : array of bool, shape (N,)
        False as well where the stability of a row is not known.
    unstable_modes : array of int, shape (N,)
        -1 where not known.
    clearance : array of float, shape (N,)
        Smallest gap between tubes [m], NaN when their radii are not known.
    iterations : array of int, shape (N,)
    residual : array of float, shape (N,)
    interrupted : bool
        True when rows are missing; these have status "not_run".
    ordered : bool
        Rows were solved in groups of 32, each row from those before it.
    builds : tuple of str
        Versions, cores and instruction sets that solved the rows; one, unless workers or sessions differed.
    file : Path, optional
        Where the rows stand.
    """

    limb: Limb
    scene: Mapping[str, Any]
    pressures: NDArray[np.float64]
    tip: NDArray[np.float64]
    plates: NDArray[np.float64]
    success: NDArray[np.bool_]
    status: Sequence[str]
    message: Sequence[str]
    stable: NDArray[np.bool_]
    unstable_modes: NDArray[np.int64]
    clearance: NDArray[np.float64]
    iterations: NDArray[np.int64]
    residual: NDArray[np.float64]
    interrupted: bool = False
    ordered: bool = False
    builds: tuple[str, ...] = ()
    file: Path | None = None

    @classmethod
    def of_columns(
        cls, limb: Limb, scene: Mapping[str, Any], columns: Columns, messages: Messages, **about: Any
    ) -> Batch:
        """A batch of the table that a sweep has filled.

        Parameters
        ----------
        columns : mapping of str to array
            As `softlimb.sweep.row_table.column_types` lists them.
        messages : Messages
        **about
            ``ordered``, ``builds``, ``file``.
        """
        arrays: dict[str, Any] = {name: values for name, values in columns.items() if name != "status"}
        status = messages.statuses
        interrupted = bool(status.are(NOT_RUN).any())
        return cls(limb=limb, scene=scene, **arrays, status=status, message=messages, interrupted=interrupted, **about)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Batch:
        """Open the file of a sweep, finished or not.

        Parameters
        ----------
        path : str or path
            As given to ``limb.sweep(..., file=)`` or `save`.

        Returns
        -------
        Batch
            The same bits as when it was written. Rows that nobody came to have status "not_run"; `resume` solves them.

        Raises
        ------
        FileNotFoundError
            There is no such file.
        ValueError
            It is a folder, no sweep, or damaged; the message names the file.
        """
        file = file_path("path", path)
        content = read(file)
        try:
            limb = content.record.make_limb()
            scene = content.record.make_options(limb)
        except (ValueError, TypeError, KeyError) as error:
            raise ValueError(f"file {file} is damaged: {error}") from None
        return cls.of_columns(
            limb,
            scene,
            content.columns,
            content.messages,
            ordered=content.record.ordered,
            builds=content.builds,
            file=file.absolute(),
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write everything into one file, bit for bit; a file of that name is replaced.

        Parameters
        ----------
        path : str or path

        Raises
        ------
        ValueError
            The scene starts from a posture, which has no form in a file; or the path is a folder.
        OSError
            The file cannot be written.
        """
        record = SweepRecord.of(self.limb, self.scene, self.ordered, len(self))
        save(file_path("path", path), Content(record, self.as_columns(), self.as_messages(), self.builds))

    def resume(
        self,
        *,
        threads: int | None = None,
        executor: Executor | Callable[[], Executor] | None = None,
        progress: bool = True,
    ) -> Batch:
        """Solve the rows that are missing; arguments and errors as for ``limb.sweep``.

        Returns
        -------
        Batch
            Complete, unless it is interrupted again. Rows in memory are copied and this batch stays as it is; rows in a
            file go there, and this batch's views of it show them.
        """
        from softlimb.sweep.run import resume

        return resume(self, threads=threads, executor=executor, progress=progress)

    def head(self, count: int) -> Batch:
        """The first rows, as views of this batch."""
        columns = {name: values[:count] for name, values in self.as_columns().items()}
        own = [(row, text) for row, text in self.as_messages().own() if row < count]
        return self._of_texts(columns, own, self.builds)

    def followed_by(self, other: Batch) -> Batch:
        """The rows of this batch and then those of another, in memory.

        Parameters
        ----------
        other : Batch
            Of the same limb and scene.

        Raises
        ------
        ValueError
            Limb, scene or order of solving differ.
        """
        if SweepRecord.of(self.limb, self.scene, self.ordered, 0) != SweepRecord.of(
            other.limb, other.scene, other.ordered, 0
        ):
            raise ValueError("batches can be joined only where limb, scene and ordered are the same")
        mine, theirs = self.as_columns(), other.as_columns()
        columns = {name: np.concatenate([mine[name], theirs[name]]) for name in mine}
        own = [*self.as_messages().own(), *((len(self) + row, text) for row, text in other.as_messages().own())]
        return self._of_texts(columns, own, tuple(sorted({*self.builds, *other.builds})))

    def _of_texts(self, columns: Columns, own: list[tuple[int, str]], builds: tuple[str, ...]) -> Batch:
        """Other rows of the same limb and scene, with the messages that are their own."""
        rows = np.array([row for row, _ in own], dtype=np.int64)
        messages = Messages(Statuses(columns["status"]), rows, ListOfTexts([text for _, text in own]))
        return Batch.of_columns(self.limb, self.scene, columns, messages, ordered=self.ordered, builds=builds)

    def __len__(self) -> int:
        return len(self.pressures)

    def __repr__(self) -> str:
        stopped = ", interrupted" if self.interrupted else ""
        return f"Batch({len(self)} postures, {int(self.success.sum())} successful{stopped})"

    @property
    def build(self) -> str:
        """What solved the rows: version, core and instruction set, "unknown" where no row says so."""
        return "; ".join(self.builds) or "unknown"

    @property
    def bending(self) -> NDArray[np.float64]:
        """Angle between the tip's axis and the base's axis [rad], shape (N,)."""
        return bending_angle(self.tip)

    @property
    def failures(self) -> dict[int, str]:
        """Row number to message of every row that did not succeed."""
        return dict(self.as_messages().at(np.flatnonzero(~self.success)))

    @property
    def remarks(self) -> NDArray[np.int64]:
        """Numbers of the rows that succeeded and whose message says more than that."""
        told = self.as_messages().rows
        found: NDArray[np.int64] = told[self.success[told]]
        return found

    def having(self, status: str) -> NDArray[np.int64]:
        """Numbers of the rows with this status."""
        return np.flatnonzero(self.as_messages().statuses.are(status))

    def columns(self) -> dict[str, list[Any]]:
        """The table as columns whose names carry their units.

        Returns
        -------
        dict of str to list
            ``pressure_1_1_kPa`` (segment and actuator from 1) ..., ``tip_x_mm`` ..., ``tip_rotation_x_deg`` (rotation
            vector) ..., ``bending_deg``, ``clearance_mm``, ``success``, ``stable``, ``status``, ``message``.
        """
        return self._rows_as_columns(0, len(self))

    def _rows_as_columns(self, first: int, stop: int) -> dict[str, list[Any]]:
        rows, tip = slice(first, stop), self.tip[first:stop]
        table: dict[str, list[Any]] = {
            f"pressure_{name}_kPa": (self.pressures[rows, i] / kPa).tolist()
            for i, name in enumerate(actuator_names(self.limb))
        }
        rotation = rotation_vector(tip) / deg
        for i, axis in enumerate("xyz"):
            table[f"tip_{axis}_mm"] = (tip[:, i, 3] / mm).tolist()
        for i, axis in enumerate("xyz"):
            table[f"tip_rotation_{axis}_deg"] = rotation[:, i].tolist()
        table["bending_deg"] = (bending_angle(tip) / deg).tolist()
        table["clearance_mm"] = (self.clearance[rows] / mm).tolist()
        table["success"] = self.success[rows].tolist()
        table["stable"] = self.stable[rows].tolist()
        return table | {"status": list(self.status[rows]), "message": list(self.message[rows])}

    def to_csv(self, path: str | Path) -> None:
        """Write `columns` as a comma-separated table; an unknown number is an empty cell.

        Parameters
        ----------
        path : str or Path
        """
        with Path(path).open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            for first in range(0, max(len(self), 1), _BLOCK):
                table = self._rows_as_columns(first, min(first + _BLOCK, len(self)))
                if first == 0:
                    writer.writerow(table)
                writer.writerows([_cell(entry) for entry in row] for row in zip(*table.values(), strict=True))

    def to_xarray(self) -> xarray.Dataset:
        """The table as a dataset in SI, with units as attributes and the scene inside.

        Returns
        -------
        xarray.Dataset
            ``pressure`` (row, actuator), ``tip_position`` (row, axis), ``tip_rotation`` (row, axis, frame_axis),
            ``plate_position``, ``plate_rotation``, ``bending``, ``clearance``, ``success``, ``stable``,
            ``unstable_modes``, ``status``, ``message``, ``iterations``, ``residual``; attribute ``scene`` is a TOML
            document, ``build`` says what solved the rows. Numbers are views: those of a batch in a file are read when
            they are needed.

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
        modes = {"units": "1", "long_name": "number of unstable modes, -1 where not known"}
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
            "unstable_modes": (("row",), self.unstable_modes, modes),
            "status": (("row",), np.array(list(self.status), dtype=object), {}),
            "message": (("row",), np.array(list(self.message), dtype=object), {}),
        }
        coordinates = {
            "actuator": actuator_names(self.limb),
            "plate": np.arange(1, self.plates.shape[1] + 1),
            "axis": list("xyz"),
            "frame_axis": list("xyz"),
        }
        attributes = {
            "scene": scene_text(self.limb, self.scene),
            "reference_length_m": float(self.limb.length),
            "interrupted": int(self.interrupted),
            "ordered": int(self.ordered),
            "build": self.build,
            "source": f"softlimb {version('softlimb')}",
        }
        if left_out(self.scene):
            attributes["scene_left_out"] = ", ".join(left_out(self.scene))
        return xarray.Dataset(variables, coords=coordinates, attrs=attributes)

    def as_columns(self) -> Columns:
        """The arrays as a sweep's table has them."""
        status = self.as_messages().statuses.codes
        names = (name for name in column_types(0, 0) if name != "status")
        return {name: getattr(self, name) for name in names} | {"status": status}

    def as_messages(self) -> Messages:
        """The messages as a sweep's table has them."""
        if isinstance(self.message, Messages) and self.message.statuses is self.status:
            return self.message
        # Made by hand: lists of texts.
        statuses = Statuses(np.array([text.encode("ascii") for text in self.status], dtype="S24"))
        told = [row for row, text in enumerate(self.message) if text != self.status[row]]
        return Messages(statuses, np.array(told, dtype=np.int64), ListOfTexts([self.message[row] for row in told]))


def file_path(name: str, value: str | os.PathLike[str]) -> Path:
    """A path to a file that is no folder.

    Raises
    ------
    TypeError
        It is neither a text nor a path.
    ValueError
        It is empty, or a folder.
    """
    if not isinstance(value, (str, os.PathLike)) or isinstance(os.fspath(value), bytes):
        raise TypeError(f"{name} must be a path, got {shown(value)}")
    if not os.fspath(value) or "\0" in os.fspath(value):
        raise ValueError(f"{name} must be the name of a file, got {os.fspath(value)!r}")
    path = Path(value)
    if path.is_dir():
        raise ValueError(f"{name} {path} is a folder: a sweep is one file")
    return path


def scene_text(limb: Limb, options: Mapping[str, Any]) -> str:
    """A limb with its loads and options as a TOML document; `left_out` names what has no such form."""
    import tomli_w

    from softlimb.scenes import Scene

    known = {name: value for name, value in options.items() if value is not None and name in _scene_fields()}
    return tomli_w.dumps(Scene(limb=limb, **normal_options(limb, known)).to_dict())


def left_out(options: Mapping[str, Any]) -> list[str]:
    """Names of the options that a scene has no form for: a start, plates that are held."""
    return sorted(name for name, value in options.items() if value is not None and name not in _scene_fields())


def _scene_fields() -> set[str]:
    from softlimb.scenes import Scene

    return {entry.name for entry in dataclasses.fields(Scene)} - {"limb"}


def actuator_names(limb: Limb) -> list[str]:
    """Segment and actuator of every pressure, both counted from 1: "2_1"."""
    return [f"{j}_{i}" for j, s in enumerate(limb.segments, 1) for i in range(1, len(s.actuators) + 1)]


def _cell(entry: Any) -> Any:
    if isinstance(entry, float):
        # Twelve digits: a picometre in a metre; NaN becomes an empty cell, which every reader takes for missing.
        return "" if np.isnan(entry) else f"{entry:.12g}"
    return entry
