"""A sweep in one file: filled block by block, whole after any end of the process, the same bits whatever the way.

`file_layout` has the form. While a file is being filled its messages are appended to a second one, NAME.journal. A
row's mark is written when its numbers and its message are on the disk: what is not marked is solved again.
"""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from softlimb.rows import NOT_RUN, Rows
from softlimb.sweep.file_layout import (
    BUILDS_AT,
    TAIL_AT,
    Head,
    Layout,
    builds_bytes,
    head_bytes,
    mapped,
    opened,
    read_head,
    write_at,
)
from softlimb.sweep.message_blocks import (
    Index,
    TextsInFile,
    index_bytes,
    pieces,
    read_index,
    read_journal,
    texts_between,
)
from softlimb.sweep.record import SweepRecord
from softlimb.sweep.row_table import Columns, Messages, Statuses, columns_of, runs_of

__all__ = ["Content", "SweepFile", "journal_of", "read", "save"]

_COMMIT = 0.5  # [s] of work that a killed process may lose; a disk takes milliseconds to say that it has it
_BLOCK_ROWS = 16384  # rows that are copied at once: some ten megabytes
_NOT_RUN, _SOLVED, _SOLVED_WITH_MESSAGE, _EXPLAINED, _BEGUN = range(5)  # marks
_Block = Callable[[str, int, int], NDArray[Any]]  # name of a column, first row, last row + 1 -> its values


@dataclass(frozen=True)
class Content:
    """What a file of a sweep holds.

    Parameters
    ----------
    record : SweepRecord
    columns : mapping of str to array
        Views of the file.
    messages : Messages
    builds : tuple of str
    sealed : bool
        False while the file is being filled, and when who filled it was killed.
    """

    record: SweepRecord
    columns: Columns
    messages: Messages
    builds: tuple[str, ...]
    sealed: bool = True


def journal_of(path: Path) -> Path:
    """The file beside it with the messages, as long as it is being filled."""
    return path.with_name(f"{path.name}.journal")


def read(path: Path) -> Content:
    """Open a sweep to look at; its columns are mapped and not loaded.

    Where the sweep is still being filled, or was killed, rows without a mark are shown as not run; poses of rows that
    are solved after that come into view, their status does not.

    Raises
    ------
    FileNotFoundError
        There is no such file.
    ValueError
        It is a folder, no sweep, or damaged; the message names the file.
    """
    with opened(path, "rb") as file:
        head = read_head(path, file)
        layout, tail = head.layout, head.tail
        if tail:
            found = read_index(file, tail, os.fstat(file.fileno()).st_size)
            if found is None:
                raise ValueError(f"file {path} is damaged: its messages are not whole")
    columns = mapped(path, layout, "r" if tail else "c")
    marks = columns.pop("mark")
    if tail:
        assert found is not None
        return Content(
            layout.record,
            columns,
            Messages(Statuses(columns["status"]), found[0].rows, TextsInFile(path, tail, found[0])),
            head.builds,
        )
    # Somebody may be at work: what is marked now is whole, and the same for as long as one looks at it.
    marks = marks.copy()
    columns |= {name: columns[name].copy() for name in ("status", "success")}
    # A private copy of the pages that change: the file stays as it is.
    for first, stop in runs_of(_not_whole(marks, columns)):
        for name, blank in _blank(layout.record).items():
            columns[name][first:stop] = blank
    journal, index = journal_of(path), Index.joined([])
    if journal.exists():
        with journal.open("rb") as file:
            index, _ = read_journal(file)
        index = index.taken(_has_message(marks, index))
    messages = Messages(Statuses(columns["status"]), index.rows, TextsInFile(journal, 0, index))
    return Content(layout.record, columns, messages, head.builds, sealed=False)


def _blank(record: SweepRecord) -> dict[str, NDArray[Any]]:
    """A row that nobody has come to, column by column."""
    return columns_of(Rows.not_run(1, record.plates))


def _without_mark(marks: NDArray[np.uint8]) -> NDArray[np.bool_]:
    return np.isin(marks, (_NOT_RUN, _EXPLAINED, _BEGUN))


def _not_whole(marks: NDArray[np.uint8], columns: Columns) -> NDArray[np.bool_]:
    """Rows of which some numbers may be written and others not."""
    begun = (marks == _BEGUN) | (columns["status"] != NOT_RUN.encode())
    found: NDArray[np.bool_] = _without_mark(marks) & begun
    return found


def _has_message(marks: NDArray[np.uint8], index: Index) -> NDArray[np.bool_]:
    found: NDArray[np.bool_] = (index.rows >= 0) & (index.rows < len(marks))
    found[found] = np.isin(marks[index.rows[found]], (_SOLVED_WITH_MESSAGE, _EXPLAINED))
    return found


# --- writing -----------------------------------------------------------------------------------------------------


@contextlib.contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Say which file the system's error is about."""
    try:
        yield
    except OSError as error:
        raise type(error)(error.errno, f"file {path} cannot be written: {error.strerror}") from None


def _write_new(
    path: Path, layout: Layout, builds: Sequence[str], block: _Block, after: Callable[[BinaryIO], None]
) -> None:
    """A file under its name only when it is whole; `after` adds what follows the columns."""
    part = path.with_name(f"{path.name}.part")
    try:
        with _naming(path), part.open("w+b", buffering=0) as file:
            write_at(file, 0, head_bytes(layout, builds))
            for name in layout.types:
                for first in range(0, layout.record.count, _BLOCK_ROWS):
                    stop = min(first + _BLOCK_ROWS, layout.record.count)
                    values = block(name, first, stop).astype(layout.types[name][0], copy=False)
                    write_at(file, layout.start + layout.offsets[name] + layout.sizes[name] * first, values)
            file.truncate(layout.end)
            after(file)
            os.fsync(file.fileno())
        with _naming(path):
            os.replace(part, path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def _write_tail(file: BinaryIO, layout: Layout, source: BinaryIO, index: Index) -> None:
    """Messages in the order of the rows behind the columns, and only then the word that they are there."""
    at = layout.end
    head = index_bytes(index.rows, index.ends - index.starts)
    write_at(file, at, head)
    at += len(head)
    for first, stop in pieces(index):
        texts = texts_between(source, index, first, stop)
        write_at(file, at, texts)
        at += len(texts)
    os.fsync(file.fileno())
    write_at(file, TAIL_AT, layout.end.to_bytes(8, "little"))
    os.fsync(file.fileno())


def save(path: Path, content: Content) -> None:
    """Write a sweep that is at hand as one file, over one of the same name.

    Raises
    ------
    OSError
        It cannot be written; the message names the file.
    ValueError
        The name is that of a folder.
    """
    if path.is_dir():
        raise ValueError(f"file {path} is a folder: a sweep is one file")
    if not path.parent.is_dir():
        raise FileNotFoundError(f"file {path} cannot be written: there is no folder {path.parent}")
    layout, messages = Layout(content.record), content.messages
    marks = np.where(messages.statuses.are(NOT_RUN), _NOT_RUN, _SOLVED).astype(np.uint8)
    marks[messages.rows] = np.where(marks[messages.rows] == _NOT_RUN, _EXPLAINED, _SOLVED_WITH_MESSAGE)

    def block(name: str, first: int, stop: int) -> NDArray[Any]:
        values: NDArray[Any] = marks[first:stop] if name == "mark" else content.columns[name][first:stop]
        return values

    def after(file: BinaryIO) -> None:
        # Lengths come first in the file: the texts are encoded twice rather than kept.
        lengths = np.fromiter((len(text.encode()) for _, text in messages.own()), np.int64, len(messages.rows))
        head, at = index_bytes(messages.rows, lengths), layout.end
        write_at(file, at, head)
        at += len(head)
        for _, text in messages.own():
            write_at(file, at, text.encode())
            at += len(text.encode())
        write_at(file, TAIL_AT, layout.end.to_bytes(8, "little"))

    _write_new(path, layout, content.builds, block, after)


class SweepFile:
    """A table on the disk that is being filled: use it in a ``with`` statement, and `seal` it when the work is over.

    Parameters
    ----------
    path : Path
        An existing file of a sweep; `create` makes one.

    Raises
    ------
    ValueError
        No sweep, or damaged.
    OSError
        The file cannot be opened for writing, or another process is filling it.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._file: BinaryIO = opened(path, "r+b")
        self._journal: BinaryIO | None = None
        try:
            # Locks are the journal's: a process loses one when it closes any of its doors to the file.
            self._journal = _locked(path)
            head = read_head(path, self._file)
            self.layout, self.builds = head.layout, head.builds
            with _naming(path):
                self._open_journal(head)
            self.columns: Columns = mapped(path, self.layout, "r")
        except BaseException:
            self.close()
            raise
        self._marks: list[tuple[int, NDArray[np.uint8]]] = []
        self._committed = time.monotonic()

    @classmethod
    def create(cls, path: Path, record: SweepRecord, pressures: NDArray[np.float64]) -> SweepFile:
        """A new file in which no row is solved; all of its room is taken now, so that a small disk says so now.

        Raises
        ------
        OSError
            It cannot be written; the message names the file.
        """
        blank = _blank(record) | {"mark": np.zeros(1, dtype=np.uint8)}

        def block(name: str, first: int, stop: int) -> NDArray[Any]:
            return pressures[first:stop] if name == "pressures" else np.repeat(blank[name], stop - first, axis=0)

        if not path.parent.is_dir():
            raise FileNotFoundError(f"file {path} cannot be written: there is no folder {path.parent}")
        journal_of(path).unlink(missing_ok=True)  # of a file that is gone
        _write_new(path, Layout(record), (), block, lambda _: None)
        return cls(path)

    def __enter__(self) -> SweepFile:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if kind is None:
                self._commit()
        finally:
            self.close()

    def _open_journal(self, head: Head) -> None:
        """Messages so far go back to the journal, so that those to come can follow."""
        assert self._journal is not None
        if head.tail:
            found = read_index(self._file, head.tail, os.fstat(self._file.fileno()).st_size)
            if found is None:
                raise ValueError(f"file {self.path} is damaged: its messages are not whole")
            self._journal.truncate(0)
            at = 0
            self._file.seek(head.tail)
            while part := self._file.read(1 << 22):
                write_at(self._journal, at, part)
                at += len(part)
            os.fsync(self._journal.fileno())
            write_at(self._file, TAIL_AT, bytes(8))
        self._file.truncate(self.layout.end)
        index, end = read_journal(self._journal)
        self._journal.truncate(end)
        self._journal_end = end
        # Without its message a row is not what was solved: it is solved again.
        marks = self._read_marks()
        known = np.zeros(len(marks), dtype=bool)
        known[index.rows[(index.rows >= 0) & (index.rows < len(marks))]] = True
        lost = np.isin(marks, (_SOLVED_WITH_MESSAGE, _EXPLAINED)) & ~known
        if lost.any():
            marks[lost] = _NOT_RUN
            self._write_column("mark", 0, marks)

    def _read_marks(self) -> NDArray[np.uint8]:
        self._file.seek(self.layout.start + self.layout.offsets["mark"])
        count, parts = self.layout.record.count, bytearray()
        while len(parts) < count and (part := self._file.read(count - len(parts))):
            parts += part
        return np.frombuffer(parts, dtype=np.uint8).copy()

    def _write_column(self, name: str, first: int, values: NDArray[Any]) -> None:
        write_at(self._file, self.layout.start + self.layout.offsets[name] + self.layout.sizes[name] * first, values)

    def missing(self) -> NDArray[np.bool_]:
        """Which rows are still to be solved, shape (N,)."""
        self._commit()
        return _without_mark(self._read_marks())

    def put(self, first: int, rows: Rows) -> None:
        """Keep rows from number `first` on; those not run stay as they are.

        Raises
        ------
        OSError
            The disk is full; what was marked before stays.
        """
        columns = columns_of(rows)
        # Success and status last: who looks at the file meanwhile sees a row as not run until its poses are there.
        names = [name for name in columns if name not in ("success", "status")] + ["success", "status"]
        told = np.array(sorted(rows.message), dtype=np.int64)
        marks = np.full(len(rows), _SOLVED, dtype=np.uint8)
        marks[told] = _SOLVED_WITH_MESSAGE
        for start, stop in runs_of(columns["status"] != NOT_RUN.encode()):
            mine = told[(told >= start) & (told < stop)]
            with _naming(self.path):
                self._write_column("mark", first + start, np.full(stop - start, _BEGUN, dtype=np.uint8))
                for name in names:
                    self._write_column(name, first + start, columns[name][start:stop])
                self._append(first + mine, [rows.message[row] for row in mine.tolist()])
            self._marks.append((first + start, marks[start:stop]))
        if time.monotonic() - self._committed > _COMMIT:
            self._commit()

    def explain(self, first: int, stop: int, text: str) -> None:
        """Say of rows that are not run why."""
        for start, end in runs_of(self.missing()[first:stop]):
            rows = np.arange(first + start, first + end)
            with _naming(self.path):
                self._append(rows, [text] * len(rows))
            self._marks.append((first + start, np.full(len(rows), _EXPLAINED, dtype=np.uint8)))

    def add_build(self, build: str) -> None:
        """Note by what rows were solved."""
        if build not in self.builds:
            self.builds = tuple(sorted((*self.builds, build)))
            with _naming(self.path):
                write_at(self._file, BUILDS_AT, builds_bytes(self.builds))

    def _append(self, rows: NDArray[np.int64], texts: list[str]) -> None:
        if not texts:
            return
        encoded = [text.encode() for text in texts]
        lengths = np.array([len(text) for text in encoded], dtype=np.int64)
        data = index_bytes(rows, lengths) + b"".join(encoded)
        assert self._journal is not None
        write_at(self._journal, self._journal_end, data)
        self._journal_end += len(data)

    def _commit(self) -> None:
        """Mark the rows since the last time, once they are on the disk."""
        if self._marks:
            assert self._journal is not None
            with _naming(self.path):
                os.fsync(self._journal.fileno())
                os.fsync(self._file.fileno())
                for first, marks in self._marks:
                    self._write_column("mark", first, marks)
            self._marks.clear()
        self._committed = time.monotonic()

    def seal(self) -> None:
        """End the work: messages move into the file, which then stands alone; its bits do not tell in what order."""
        self._commit()
        assert self._journal is not None
        marks = self._read_marks()
        with _naming(self.path):
            for first, stop in runs_of(_not_whole(marks, self.columns)):
                for name, blank in _blank(self.layout.record).items():
                    self._write_column(name, first, np.repeat(blank, stop - first, axis=0))
            marks[marks == _BEGUN] = _NOT_RUN
            self._write_column("mark", 0, marks)
            index, _ = read_journal(self._journal)
            _write_tail(self._file, self.layout, self._journal, index.taken(_has_message(marks, index)))
        self.close()
        journal_of(self.path).unlink(missing_ok=True)

    def discard(self) -> None:
        """Leave nothing behind."""
        self.close()
        journal_of(self.path).unlink(missing_ok=True)
        self.path.unlink(missing_ok=True)

    def close(self) -> None:
        """Let the files go as they are."""
        for file in (self._file, self._journal):
            if file is not None:
                file.close()


def _locked(path: Path) -> BinaryIO:
    """The journal of a file, which one process at a time may have; its lock ends with the process, whatever ends it."""
    journal = journal_of(path)
    try:
        file = os.fdopen(os.open(journal, os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0), 0o666), "r+b", 0)
    except OSError as error:
        raise type(error)(error.errno, f"file {journal} cannot be written: {error.strerror}") from None
    try:
        import fcntl

        fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except ModuleNotFoundError:  # Windows: two processes at once are the user's affair there
        pass
    except (BlockingIOError, PermissionError):
        file.close()
        raise BlockingIOError(f"file {path} is being filled by another process") from None
    except OSError:  # a file system without locks
        pass
    return file
