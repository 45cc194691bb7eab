"""One table of a TOML document, read with its types, units and names checked."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softlimb.quantities import Dimension, Nested, explain_unknown, scaled

_TYPE_NAMES = {
    bool: "a boolean",
    int: "an integer",
    float: "a number",
    str: "a string",
    list: "a list",
    dict: "a table",
}


_DEEPEST = 8  # lists in lists; what a file can hold needs three


def _described(value: object) -> str:
    kind = next((name for kind, name in _TYPE_NAMES.items() if type(value) is kind), f"a {type(value).__name__}")
    return kind if isinstance(value, (dict, list)) else f"{kind}, {value!r}"


class Table:
    """A table whose keys are all declared: what is not declared is an error that names the nearest key.

    Parameters
    ----------
    content : mapping
        As the TOML reader gives it.
    where : str
        Path of the table, such as "limb.tubes.proximal", for messages; empty for the top of the document.
    quantities : mapping of str to Dimension
        Keys that take a unit, without it.
    others : sequence of str
        Keys that take none.

    Raises
    ------
    ValueError
        A key is unknown, lacks its unit, has the unit of another dimension, or is given in two units.
    """

    def __init__(
        self,
        content: Mapping[str, Any],
        where: str,
        *,
        quantities: Mapping[str, Dimension] | None = None,
        others: Sequence[str] = (),
    ) -> None:
        self.content = content
        self.where = where
        self.quantities = dict(quantities or {})
        self.others = tuple(others)
        self.place = f"in [{where}]" if where else "at the top of the file"
        found: dict[str, str] = {}
        for key in content:
            quantity = self._quantity_of(key)
            if quantity is None and key not in self.others:
                raise ValueError(explain_unknown(key, self.place, self.quantities, self.others))
            if quantity in found:
                raise ValueError(f"keys `{found[quantity]}` and `{key}` {self.place} give the same thing: keep one")
            if quantity is not None:
                found[quantity] = key
        self._key_of = found

    def _quantity_of(self, key: str) -> str | None:
        for quantity, dimension in self.quantities.items():
            if any(key == f"{quantity}_{unit}" for unit in dimension.factors):
                return quantity
        return None

    def __contains__(self, name: str) -> bool:
        return name in self._key_of or (name in self.others and name in self.content)

    def error(self, message: str) -> ValueError:
        """An error that says where."""
        return ValueError(f"{message} {self.place}")

    def _missing(self, name: str) -> ValueError:
        if name in self.quantities:
            return self.error(f"missing key `{name}_{next(iter(self.quantities[name].factors))}`")
        return self.error(f"missing key `{name}`")

    def _number(self, key: str, value: object) -> float:
        # A TOML boolean is a Python int; 1 kPa and true kPa are not the same claim.
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise self.error(f"`{key}` must be a number, got {_described(value)},")
        try:
            number = float(value)
        except OverflowError:  # an integer beyond 1.8e308
            raise self.error(f"`{key}` is too large") from None
        if not math.isfinite(number):
            raise self.error(f"`{key}` must be finite, got {value}")
        return number

    def _numbers(self, key: str, value: object, depth: int = 0) -> Nested:
        if not isinstance(value, list):
            return self._number(key, value)
        if depth == _DEEPEST:
            raise self.error(f"`{key}` is nested too deeply: more than {_DEEPEST} lists inside each other,")
        return [self._numbers(key, entry, depth + 1) for entry in value]

    def _require_finite(self, key: str, number: Nested) -> None:
        """ValueError where the unit has made a number infinite."""
        if isinstance(number, list):
            for entry in number:
                self._require_finite(key, entry)
        elif not math.isfinite(number):
            raise self.error(f"`{key}` is too large")

    def key(self, name: str) -> str:
        """The key as the file has it, with its unit."""
        return self._key_of.get(name, name)

    def _factor(self, name: str) -> float:
        return self.quantities[name].factors[self._key_of[name][len(name) + 1 :]]

    def quantity(self, name: str, default: float | None = None) -> float:
        """A number with its unit, in SI.

        Raises
        ------
        ValueError
            Not a finite number, or missing while `default` is None.
        """
        if name not in self:
            if default is None:
                raise self._missing(name)
            return default
        key = self._key_of[name]
        number = self._number(key, self.content[key]) * self._factor(name)
        self._require_finite(key, number)
        return number

    def nested(self, name: str) -> Nested:
        """A number or nested lists of numbers, in SI when the key takes a unit."""
        if name not in self:
            raise self._missing(name)
        key = self._key_of.get(name, name)
        numbers = self._numbers(key, self.content[key])
        if name in self.quantities:
            numbers = scaled(numbers, self._factor(name))
            self._require_finite(key, numbers)
        return numbers

    def array(self, name: str, shape: tuple[int, ...], default: Sequence[float] | None = None) -> NDArray[np.float64]:
        """Numbers of the given shape (-1: any length), in SI when the key takes a unit.

        Raises
        ------
        ValueError
            Wrong shape, not finite numbers, or missing while `default` is None.
        """
        if name not in self and default is not None:
            return np.array(default, dtype=float)
        numbers = self.nested(name)
        try:
            array = np.array(numbers, dtype=float)
        except ValueError:  # lists of different lengths
            raise self.error(f"`{self.key(name)}` must have shape {shape}, got lists of different lengths,") from None
        if array.ndim != len(shape) or any(n not in (-1, m) for n, m in zip(shape, array.shape, strict=True)):
            expected = str(shape).replace("-1", "n")
            raise self.error(f"`{self.key(name)}` has shape {array.shape}, expected {expected},")
        return array

    def number(self, name: str, default: float | None = None) -> float:
        """A finite number without unit."""
        if name not in self:
            if default is None:
                raise self._missing(name)
            return default
        return self._number(name, self.content[name])

    def integer(self, name: str, default: int | None = None) -> int:
        """A whole number."""
        if name not in self:
            if default is None:
                raise self._missing(name)
            return default
        value = self.content[name]
        if isinstance(value, bool) or not isinstance(value, int):
            raise self.error(f"`{name}` must be an integer, got {_described(value)},")
        return value

    def boolean(self, name: str, default: bool | None = None) -> bool:
        """True or false."""
        if name not in self:
            if default is None:
                raise self._missing(name)
            return default
        value = self.content[name]
        if not isinstance(value, bool):
            raise self.error(f"`{name}` must be true or false, got {_described(value)},")
        return value

    def text(self, name: str, default: str | None = None, choices: Sequence[str] = ()) -> str:
        """A string, one of `choices` when there are any."""
        if name not in self:
            if default is None:
                raise self._missing(name)
            return default
        value = self.content[name]
        if not isinstance(value, str):
            raise self.error(f"`{name}` must be a string, got {_described(value)},")
        if choices and value not in choices:
            raise self.error(f"`{name}` must be one of {', '.join(repr(c) for c in choices)}, got {value!r},")
        return value

    def texts(self, name: str) -> list[str]:
        """A list of strings."""
        if name not in self:
            raise self._missing(name)
        value = self.content[name]
        if not isinstance(value, list):
            raise self.error(f"`{name}` must be a list of strings, got {_described(value)},")
        for entry in value:
            if not isinstance(entry, str):
                raise self.error(f"`{name}` must be a list of strings, but holds {_described(entry)},")
        return list(value)

    def mapping(self, name: str) -> Mapping[str, Any]:
        """The content of a table inside this one; empty when it is missing."""
        value = self.content.get(name, {})
        if not isinstance(value, dict):
            raise self.error(f"`{name}` must be a table, got {_described(value)},")
        return value

    def mappings(self, name: str) -> list[tuple[Mapping[str, Any], str]]:
        """Content and path of each table of an array of tables; empty when it is missing."""
        value = self.content.get(name, [])
        if not isinstance(value, list) or not all(isinstance(entry, dict) for entry in value):
            raise self.error(f"`{name}` must be an array of tables, got {_described(value)},")
        return [(entry, f"{self.path(name)}, {i} of {len(value)}") for i, entry in enumerate(value, start=1)]

    def path(self, name: str) -> str:
        """Path of the table `name` inside this one."""
        return f"{self.where}.{name}" if self.where else name


def read_document(path: str | Path) -> dict[str, Any]:
    """Parse a TOML file.

    Raises
    ------
    FileNotFoundError
        There is no such file.
    ValueError
        The file is not TOML, or not UTF-8; the message names the file and the line.
    """
    try:
        import tomllib
    except ModuleNotFoundError:  # Python 3.10
        import tomli as tomllib  # type: ignore[no-redef, import-not-found, unused-ignore]
    path = Path(path)
    try:
        with path.open("rb") as file:
            return tomllib.load(file)
    except FileNotFoundError:
        raise FileNotFoundError(f"there is no file {path}") from None
    except IsADirectoryError:
        raise ValueError(f"{path} is a folder, not a TOML file") from None
    except RecursionError:
        raise ValueError(f"{path} is nested too deeply") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{path} is not valid TOML: {error}") from None


def write_document(content: Mapping[str, Any], path: str | Path, comment: str = "") -> None:
    """Write a TOML file, `comment` above it as `#` lines."""
    import tomli_w

    lines = "".join(f"# {line}".rstrip() + "\n" for line in comment.splitlines())
    text = tomli_w.dumps(content)
    # The writer gives every entry of a list its own line, which makes a matrix 20 lines long. Strings hold no line
    # breaks here, so a bracket, a line break and plain entries are a list.
    simple = re.compile(r"\[\n\s+((?:(?:[-+.\w]+|\"[-\w]+\"|\[[^][{}\n]*\]),\n\s*)+)\]")
    for _ in range(3):  # pressures are lists in a list, rotations too: innermost first
        text = simple.sub(lambda match: "[" + ", ".join(re.findall(_ENTRY, match[1])) + "]", text)
    Path(path).write_text(lines + ("\n" if lines else "") + text, encoding="utf-8")


_ENTRY = re.compile(r"\[[^][{}\n]*\]|\"[-\w]+\"|[-+.\w]+")
