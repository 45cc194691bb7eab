"""Messages of rows in a file: blocks of an index and texts, and the journal that they are appended to.

A block is: u64 number M, u64 length of all texts, u32 CRC of the next two, u32 0, M rows (u64), M ends of their texts
(u64), the texts in UTF-8 one after the other.
"""

from __future__ import annotations

import os
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

__all__ = ["HEAD_SIZE", "Index", "TextsInFile", "index_bytes", "pieces", "read_index", "read_journal", "texts_between"]

HEAD_SIZE = 24  # bytes of a block before its rows
_TEXTS = 16384  # that are copied at once: a megabyte or two


@dataclass(frozen=True)
class Index:
    """Where messages stand in a file: rows, and first and last + 1 byte of their texts."""

    rows: NDArray[np.int64]
    starts: NDArray[np.int64]
    ends: NDArray[np.int64]

    @classmethod
    def joined(cls, parts: Sequence[Index]) -> Index:
        """One index of all."""
        fields = [[getattr(part, name) for part in parts] for name in ("rows", "starts", "ends")]
        return cls(*(np.concatenate(arrays) if arrays else np.zeros(0, dtype=np.int64) for arrays in fields))

    def latest(self) -> Index:
        """Rows rising, of each only its last message."""
        order = np.argsort(self.rows, kind="stable")
        last = np.append(self.rows[order][1:] != self.rows[order][:-1], True)[: len(order)]
        return self.taken(order[last])

    def taken(self, which: NDArray[Any]) -> Index:
        """Some of the messages."""
        return Index(self.rows[which], self.starts[which], self.ends[which])


def index_bytes(rows: NDArray[np.int64], lengths: NDArray[np.int64]) -> bytes:
    """What stands before the texts of a block of messages."""
    ends = np.cumsum(lengths, dtype="<i8")
    index = rows.astype("<i8").tobytes() + ends.tobytes()
    sizes = np.array([len(rows), ends[-1] if len(ends) else 0], dtype="<u8").tobytes()
    return sizes + np.array([zlib.crc32(index), 0], dtype="<u4").tobytes() + index


def read_index(file: BinaryIO, at: int, size: int) -> tuple[Index, int] | None:
    """Index of the block of messages at a place, and where the block ends; None where there is no whole block."""
    file.seek(at)
    head = file.read(HEAD_SIZE)
    if len(head) < HEAD_SIZE:
        return None
    count, length = (int(n) for n in np.frombuffer(head[:16], dtype="<u8"))
    texts_at = at + HEAD_SIZE + 16 * count
    if texts_at + length > size:
        return None
    index = file.read(16 * count)
    if zlib.crc32(index) != int.from_bytes(head[16:20], "little"):
        return None
    rows, ends = np.frombuffer(index, dtype="<i8").reshape(2, count).astype(np.int64)
    if count and (ends[-1] != length or (np.diff(ends, prepend=0) < 0).any()):
        return None
    return Index(rows, texts_at + np.concatenate([[0], ends[:-1]])[:count], texts_at + ends), texts_at + length


def read_journal(file: BinaryIO) -> tuple[Index, int]:
    """Latest message of every row that a journal has, and where its last whole block ends."""
    parts: list[Index] = []
    end, size = 0, os.fstat(file.fileno()).st_size
    while (found := read_index(file, end, size)) is not None:
        parts.append(found[0])
        end = found[1]
    return Index.joined(parts).latest(), end


def pieces(index: Index) -> Iterator[tuple[int, int]]:
    """Messages whose texts are neighbours in the file, as (first, last + 1); a few megabytes at most."""
    apart = np.flatnonzero(index.starts[1:] != index.ends[:-1]) + 1
    for first, stop in zip([0, *apart.tolist()], [*apart.tolist(), len(index.rows)], strict=True):
        for at in range(first, stop, _TEXTS):
            yield at, min(at + _TEXTS, stop)


def texts_between(file: BinaryIO, index: Index, first: int, stop: int) -> bytes:
    """The texts of a piece as they stand in the file."""
    file.seek(int(index.starts[first]))
    return file.read(int(index.ends[stop - 1] - index.starts[first]))


class TextsInFile:
    """Messages that stay in their file until they are asked for.

    Parameters
    ----------
    path : Path
        A sealed file of a sweep, or a journal.
    first_block : int
        Where its first block of messages stands.
    index : Index
    """

    def __init__(self, path: Path, first_block: int, index: Index) -> None:
        self.path = path.absolute()  # who asks may be in another folder by then
        self.index = index
        self._first_block = first_block
        self._seal = self._head() if len(index.rows) else b""

    def _head(self) -> bytes:
        """Numbers, lengths and CRC of the first block: another one where the messages are others."""
        with self.path.open("rb") as file:
            file.seek(self._first_block)
            return file.read(HEAD_SIZE)

    def read(self, first: int, stop: int) -> list[str]:
        """The texts number `first` to `stop` - 1.

        Raises
        ------
        RuntimeError
            Somebody has gone on with the sweep since.
        """
        part = self.index.taken(np.arange(first, stop))
        try:
            if first < stop and self._head() != self._seal:
                raise FileNotFoundError
            with self.path.open("rb") as file:
                texts = []
                for one, end in pieces(part):
                    piece, base = texts_between(file, part, one, end), int(part.starts[one])
                    bounds = zip(part.starts[one:end] - base, part.ends[one:end] - base, strict=True)
                    texts += [piece[low:high].decode() for low, high in bounds]
                return texts
        except (FileNotFoundError, UnicodeDecodeError):
            raise RuntimeError(f"{self.path} has changed since it was loaded: load the sweep again") from None
