"""The form of a sweep's file. All numbers are little endian:

0       "softlimb-sweep-1"
16      u64 length of the description, u64 place of the messages: 0 while the file is being filled
32      JSON list of the builds that solved the rows, padded with zeros
4096    description: JSON with limb, options, number of rows, and type, unit and place of every column
...     columns, one after the other, each from a multiple of 64 on, the first from a multiple of 4096 on; the last
        one, `mark`, has a byte a row: 0 not run, 1 solved, 2 solved with a message, 3 not run for a reason, 4 being
        written
...     one block of messages (`message_blocks`), rows rising
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, BinaryIO, Literal

import numpy as np
from numpy.typing import NDArray

from softlimb.sweep.message_blocks import HEAD_SIZE
from softlimb.sweep.record import SweepRecord
from softlimb.sweep.row_table import column_types

__all__ = ["Head", "Layout", "builds_bytes", "head_bytes", "mapped", "opened", "read_head", "write_at"]

_MAGIC = b"softlimb-sweep-1"
_LENGTH_AT, TAIL_AT, BUILDS_AT, DESCRIPTION_AT = 16, 24, 32, 4096
_PAGE, _LINE = 4096, 64
_UNITS = {"pressures": "Pa", "clearance": "m"}
_POSES = "rotation [1] and position [m] in the base frame"


@dataclass(frozen=True)
class Layout:
    """Where the columns of a sweep's file stand.

    Parameters
    ----------
    record : SweepRecord
    """

    record: SweepRecord

    @cached_property
    def types(self) -> dict[str, tuple[str, tuple[int, ...]]]:
        """Type and shape of a row's entry in each column."""
        return column_types(self.record.actuators, self.record.plates) | {"mark": ("|u1", ())}

    @cached_property
    def sizes(self) -> dict[str, int]:
        """Bytes of a row in each column."""
        return {name: np.dtype(kind).itemsize * int(np.prod(shape)) for name, (kind, shape) in self.types.items()}

    @cached_property
    def offsets(self) -> dict[str, int]:
        """Place of each column after the description."""
        offsets, end = {}, 0
        for name, size in self.sizes.items():
            offsets[name] = end
            end = _up(end + size * self.record.count, _LINE)
        return offsets

    @cached_property
    def description(self) -> bytes:
        """The JSON of the file."""
        columns = [
            {
                "name": name,
                "type": kind,
                "shape": list(shape),
                "offset": self.offsets[name],
                "unit": _POSES if name in ("tip", "plates") else _UNITS.get(name, "1"),
            }
            for name, (kind, shape) in self.types.items()
        ]
        return json.dumps(self.record.to_dict() | {"columns": columns}, indent=1, sort_keys=True).encode()

    @cached_property
    def start(self) -> int:
        """Where the columns start in the file."""
        return _up(DESCRIPTION_AT + len(self.description), _PAGE)

    @cached_property
    def end(self) -> int:
        """Where the columns end and the messages start."""
        # At least one byte, so that a sweep of no rows can be mapped as well.
        return self.start + max(_up(self.offsets["mark"] + self.record.count, _LINE), _LINE)


def _up(number: int, multiple: int) -> int:
    return -(-number // multiple) * multiple


@dataclass(frozen=True)
class Head:
    layout: Layout
    tail: int
    builds: tuple[str, ...]


def opened(path: Path, mode: str) -> Any:
    if path.is_dir():
        raise ValueError(f"file {path} is a folder, not a sweep")
    try:
        return path.open(mode, buffering=-1 if mode == "rb" else 0)
    except FileNotFoundError:
        raise FileNotFoundError(f"there is no file {path}") from None
    except OSError as error:
        raise type(error)(error.errno, f"file {path} cannot be opened: {error.strerror}") from None


def read_head(path: Path, file: BinaryIO) -> Head:
    head = file.read(DESCRIPTION_AT)
    if head[: len(_MAGIC)] != _MAGIC:
        if head.startswith(_MAGIC[:-1]):
            raise ValueError(f"file {path} was written by another version of softlimb, in a form this one cannot read")
        raise ValueError(f"file {path} is no sweep of softlimb")
    length = int.from_bytes(head[_LENGTH_AT:TAIL_AT], "little")
    tail = int.from_bytes(head[TAIL_AT:BUILDS_AT], "little")
    size = os.fstat(file.fileno()).st_size
    try:
        if length > size:
            raise ValueError("its description is cut short")
        text = file.read(length)
        layout = Layout(SweepRecord.from_dict(json.loads(text)))
        if layout.description != text:
            raise ValueError("its description contradicts itself")
        if tail not in (0, layout.end) or size < layout.end + (HEAD_SIZE if tail else 0):
            raise ValueError(f"it has {size} bytes, too few for {layout.record.count} rows")
        builds = json.loads(head[BUILDS_AT:].rstrip(b"\0") or b"[]")
        if not isinstance(builds, list) or not all(isinstance(build, str) for build in builds):
            raise ValueError("its builds are no texts")
    except (ValueError, KeyError, TypeError, RecursionError, OverflowError) as error:
        raise ValueError(f"file {path} is damaged: {error}") from None
    return Head(layout, tail, tuple(builds))


def mapped(path: Path, layout: Layout, mode: Literal["r", "c"]) -> dict[str, NDArray[Any]]:
    whole = np.memmap(path, dtype=np.uint8, mode=mode, offset=layout.start, shape=(layout.end - layout.start,))
    data = np.asarray(whole)  # a plain view: results of arithmetic are arrays and not maps
    columns = {}
    for name, (kind, shape) in layout.types.items():
        at = layout.offsets[name]
        column = data[at : at + layout.sizes[name] * layout.record.count]
        columns[name] = column.view(kind).reshape((layout.record.count, *shape))
    return columns


def write_at(file: BinaryIO, at: int, data: bytes | NDArray[Any]) -> None:
    """All bytes at a place: unbuffered files may take a part only."""
    rest = memoryview(data if isinstance(data, bytes) else np.ascontiguousarray(data).tobytes())
    file.seek(at)
    while len(rest):
        rest = rest[file.write(rest) :]


def builds_bytes(builds: Sequence[str]) -> bytes:
    room = DESCRIPTION_AT - BUILDS_AT
    for count in range(len(builds), -1, -1):  # some fifty fit
        listed = [*builds[:count], *(["and others"] if count < len(builds) else [])]
        text = json.dumps(listed).encode()
        if len(text) <= room:
            return text.ljust(room, b"\0")
    raise AssertionError


def head_bytes(layout: Layout, builds: Sequence[str]) -> bytes:
    """Everything before the columns, of a file without messages."""
    sizes = len(layout.description).to_bytes(8, "little") + bytes(8)
    return (_MAGIC + sizes + builds_bytes(builds) + layout.description).ljust(layout.start, b"\0")
