"""The table that a sweep fills: one column a quantity, statuses and messages as sequences of texts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Protocol, overload

import numpy as np
from numpy.typing import NDArray

from softlimb.rows import CONVERGED, INVALID, NOT_RUN, Rows

Columns = Mapping[str, NDArray[Any]]

NOT_RUN_MESSAGE = "the sweep was interrupted before this row"

_STATUS = "S24"  # the longest status, singular_jacobian, has 17 letters
_BLOCK = 4096  # texts that are made at once when a sequence of a million is walked through


def column_types(actuators: int, plates: int) -> dict[str, tuple[str, tuple[int, ...]]]:
    """Type and shape of a row's entry in each column; the same in memory and in a file."""
    return {
        "pressures": ("<f8", (actuators,)),
        "tip": ("<f8", (4, 4)),
        "plates": ("<f8", (plates, 4, 4)),
        "success": ("|b1", ()),
        "status": (f"|{_STATUS}", ()),
        "stable": ("|b1", ()),
        "unstable_modes": ("<i8", ()),
        "clearance": ("<f8", ()),
        "iterations": ("<i8", ()),
        "residual": ("<f8", ()),
    }


def columns_of(rows: Rows) -> dict[str, NDArray[Any]]:
    """Rows as columns, pressures left out.

    Raises
    ------
    ValueError
        A status is no short ASCII text.
    """
    status = np.array([text.encode("ascii") for text in rows.status], dtype=np.bytes_)
    if status.dtype.itemsize > np.dtype(_STATUS).itemsize:
        raise ValueError(f"a status has at most 24 letters, got {max(rows.status, key=len)!r}")
    arrays = {
        name: np.asarray(getattr(rows, name), dtype=kind)
        for name, (kind, _) in column_types(0, 0).items()
        if name not in ("pressures", "status")
    }
    return arrays | {"status": status.astype(_STATUS)}


def runs_of(rows: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Neighbours that are true, as (first, last + 1)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], rows, [False]]).astype(np.int8)))
    return [(int(first), int(stop)) for first, stop in edges.reshape(-1, 2)]


class Table(Protocol):
    """Where the rows of a sweep go."""

    columns: Columns
    builds: tuple[str, ...]

    def missing(self) -> NDArray[np.bool_]:
        """Which rows are still to be solved, shape (N,)."""

    def put(self, first: int, rows: Rows) -> None:
        """Keep rows from number `first` on; those not run stay missing."""

    def explain(self, first: int, stop: int, text: str) -> None:
        """Say of rows that are not run why."""

    def add_build(self, build: str) -> None:
        """Note by what rows were solved."""


class MemoryTable:
    """A table of arrays.

    Parameters
    ----------
    pressures : array of float, shape (N, A)
        Gauge pressures [Pa]; kept, not copied.
    plates : int
        Number of plates of the limb.
    """

    def __init__(self, pressures: NDArray[np.float64], plates: int) -> None:
        self.columns: Columns = {"pressures": pressures, **columns_of(Rows.not_run(len(pressures), plates))}
        self.texts: dict[int, str] = {}
        self.builds: tuple[str, ...] = ()

    @classmethod
    def of(cls, columns: Columns, messages: Messages, builds: tuple[str, ...]) -> MemoryTable:
        """A table that goes on where another stopped; nothing is shared."""
        table = cls(columns["pressures"].copy(), columns["plates"].shape[1])
        for name, values in table.columns.items():
            values[:] = columns[name]
        table.texts, table.builds = dict(messages.own()), builds
        return table

    def missing(self) -> NDArray[np.bool_]:
        """Which rows are still to be solved, shape (N,)."""
        found: NDArray[np.bool_] = self.columns["status"] == NOT_RUN.encode()
        return found

    def put(self, first: int, rows: Rows) -> None:
        """Keep rows from number `first` on."""
        columns = columns_of(rows)
        done = np.flatnonzero(columns["status"] != NOT_RUN.encode())
        for name, values in columns.items():
            self.columns[name][first + done] = values[done]
        for row in done.tolist():
            self.texts.pop(first + row, None)
            if row in rows.message:
                self.texts[first + row] = rows.message[row]

    def explain(self, first: int, stop: int, text: str) -> None:
        """Say of rows that are not run why."""
        self.texts.update(dict.fromkeys((first + np.flatnonzero(self.missing()[first:stop])).tolist(), text))

    def add_build(self, build: str) -> None:
        """Note by what rows were solved."""
        if build not in self.builds:
            self.builds = tuple(sorted((*self.builds, build)))

    def messages(self) -> Messages:
        """Message of every row."""
        rows = np.array(sorted(self.texts), dtype=np.int64)
        texts = [self.texts[row] for row in rows.tolist()]
        return Messages(Statuses(self.columns["status"]), rows, ListOfTexts(texts))


class _Texts(Sequence[str]):
    """A sequence of texts that are made when they are asked for; equal to a list of the same texts."""

    def _block(self, first: int, stop: int) -> list[str]:
        raise NotImplementedError

    @overload
    def __getitem__(self, index: int) -> str: ...
    @overload
    def __getitem__(self, index: slice) -> list[str]: ...
    def __getitem__(self, index: int | slice) -> str | list[str]:
        if isinstance(index, slice):
            first, stop, step = index.indices(len(self))
            if step == 1:
                return self._block(first, max(first, stop))
            return [self[i] for i in range(first, stop, step)]
        row = int(index) + (len(self) if index < 0 else 0)
        if not 0 <= row < len(self):
            raise IndexError(f"row {index} of {len(self)}")
        return self._block(row, row + 1)[0]

    def __iter__(self) -> Iterator[str]:
        for first in range(0, len(self), _BLOCK):
            yield from self._block(first, min(first + _BLOCK, len(self)))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Sequence) or isinstance(other, str):
            return NotImplemented
        return len(self) == len(other) and all(mine == theirs for mine, theirs in zip(self, other, strict=True))

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        shown = ", ".join(repr(text) for text in self[:4])
        return f"[{shown}{', ...' if len(self) > 4 else ''}] ({len(self)} rows)"


class Statuses(_Texts):
    """Status of every row.

    Parameters
    ----------
    codes : array of bytes, shape (N,)
        The statuses as ASCII.
    """

    def __init__(self, codes: NDArray[Any]) -> None:
        self.codes = codes

    def __len__(self) -> int:
        return len(self.codes)

    def are(self, status: str) -> NDArray[np.bool_]:
        """Which rows have this status, shape (N,)."""
        found: NDArray[np.bool_] = self.codes == status.encode()
        return found

    def count(self, value: Any) -> int:
        """How many rows have this status."""
        return int(np.count_nonzero(self.are(value))) if isinstance(value, str) else 0

    def _block(self, first: int, stop: int) -> list[str]:
        known = {
            code: _KNOWN.get(code) or code.decode("ascii", "replace")
            for code in np.unique(self.codes[first:stop]).tolist()
        }
        return [known[code] for code in self.codes[first:stop].tolist()]


_KNOWN = {text.encode(): text for text in (CONVERGED, NOT_RUN, INVALID)}  # one object for a million rows


class TextSource(Protocol):
    """Texts by number, from wherever they are kept."""

    def read(self, first: int, stop: int) -> list[str]:
        """The texts number `first` to `stop` - 1."""


class ListOfTexts:
    """Texts in memory."""

    def __init__(self, texts: list[str]) -> None:
        self.texts = texts

    def read(self, first: int, stop: int) -> list[str]:
        """The texts number `first` to `stop` - 1."""
        return self.texts[first:stop]


class Messages(_Texts):
    """Message of every row: its own where it has one, or else its status in words.

    Parameters
    ----------
    statuses : Statuses
    rows : array of int, shape (M,)
        Rows with a message of their own, rising.
    source : TextSource
        These messages, in the same order.
    """

    def __init__(self, statuses: Statuses, rows: NDArray[np.int64], source: TextSource) -> None:
        self.statuses = statuses
        self.rows = rows
        self.source = source

    def __len__(self) -> int:
        return len(self.statuses)

    def _block(self, first: int, stop: int) -> list[str]:
        texts = [NOT_RUN_MESSAGE if status == NOT_RUN else status for status in self.statuses[first:stop]]
        low, high = np.searchsorted(self.rows, [first, stop]).tolist()
        if low < high:
            for row, text in zip(self.rows[low:high].tolist(), self.source.read(low, high), strict=True):
                texts[row - first] = text
        return texts

    def at(self, rows: NDArray[np.int64]) -> Iterator[tuple[int, str]]:
        """Rows, rising, with their messages."""
        for block in np.unique(rows // _BLOCK).tolist():
            first = block * _BLOCK
            texts = self[first : first + _BLOCK]
            low, high = np.searchsorted(rows, [first, first + _BLOCK]).tolist()
            yield from ((row, texts[row - first]) for row in rows[low:high].tolist())

    def own(self) -> Iterator[tuple[int, str]]:
        """Rows with a message of their own, with it."""
        for first in range(0, len(self.rows), _BLOCK):
            stop = min(first + _BLOCK, len(self.rows))
            yield from zip(self.rows[first:stop].tolist(), self.source.read(first, stop), strict=True)
