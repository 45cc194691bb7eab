"""Numbers that a caller gives: taken where they are real numbers, refused with the argument's name otherwise."""

from __future__ import annotations

from collections.abc import Iterable
from decimal import Decimal
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def shown(value: object) -> str:
    """Text of a value for a message, cut where it is long (an integer may have thousands of digits)."""
    try:
        text = repr(value)
    except ValueError:  # Python prints no integer of more than 4300 digits
        return f"a {type(value).__name__} of very many digits"
    return text if len(text) <= 80 else f"{text[:60]}... ({len(text)} characters)"


def real_array(name: str, value: ArrayLike) -> Array:
    """A copy as floats, infinite and NaN included.

    Raises
    ------
    ValueError
        Anything but real numbers: texts, truth values, dates and complex numbers, also where numpy would convert them.
    """
    # The usual kinds first: the full check takes longer than a tube's equilibrium.
    if type(value) is float or (type(value) is np.ndarray and value.dtype.kind == "f" and value.dtype.itemsize <= 8):
        return np.array(value, dtype=np.float64)
    rule = f"{name} must be a number or an array of numbers, got {shown(value)}"
    try:
        given = np.asarray(value)
        # A list that mixes numbers with truth values has become numbers already: its elements decide.
        if given.dtype.kind == "O" or not hasattr(value, "dtype"):
            _require_real(np.asarray(value, dtype=object).ravel().tolist())
    except (TypeError, ValueError) as error:
        raise ValueError(rule) from error
    if given.dtype.kind not in "iufO" and given.size:
        raise ValueError(rule)
    try:
        with np.errstate(over="ignore"):  # a long double beyond the range becomes infinite
            return np.array(given, dtype=np.float64)
    except OverflowError:
        raise ValueError(f"{name} must be finite, got {shown(value)}, beyond the range of a float") from None
    except (TypeError, ValueError) as error:
        raise ValueError(rule) from error


def _require_real(elements: Iterable[object]) -> None:
    for element in elements:
        number = element
        if isinstance(element, np.ndarray | np.generic):
            if element.ndim or element.dtype.kind not in "iuf":
                raise TypeError
        elif isinstance(number, bool) or not isinstance(number, Real | Decimal):
            raise TypeError


def finite_array(name: str, value: ArrayLike) -> Array:
    """As `real_array`, and every number finite."""
    array = real_array(name, value)
    if not np.all(np.isfinite(array)):
        bad = np.flatnonzero(~np.isfinite(array.ravel()))[0]
        where = f" at index {bad}" if array.ndim else ""
        raise ValueError(f"{name} must be finite, got {array.ravel()[bad]}{where}")
    return array


def positive_array(name: str, value: ArrayLike) -> Array:
    """As `finite_array`, and every number positive."""
    array = finite_array(name, value)
    if not np.all(array > 0.0):
        bad = np.flatnonzero(~(array.ravel() > 0.0))[0]
        raise ValueError(f"{name} must be positive, got {array.ravel()[bad]}")
    return array


def one_real(name: str, value: Any) -> float:
    """One real number, infinite and NaN included; errors as for `real_array`."""
    array = real_array(name, value)
    if array.ndim != 0:
        raise ValueError(f"{name} must be one number, got shape {array.shape}")
    return float(array)


def one_finite(name: str, value: Any) -> float:
    """As `one_real`, and finite."""
    number = one_real(name, value)
    if not np.isfinite(number):
        raise ValueError(f"{name} must be finite, got {number}")
    return number


def one_of(name: str, value: object, choices: tuple[str, ...]) -> None:
    """ValueError unless the value is one of the texts."""
    if not isinstance(value, str) or value not in choices:
        known = ", ".join(f'"{choice}"' for choice in choices)
        text = f'"{value}"' if isinstance(value, str) else shown(value)
        raise ValueError(f"{name} must be one of {known}, got {text}")


def truth(name: str, value: object) -> bool:
    """True or False; ValueError for anything else."""
    if not isinstance(value, bool | np.bool_):
        raise ValueError(f"{name} must be True or False, got {shown(value)}")
    return bool(value)
