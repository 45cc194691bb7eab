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
        Anything but real numbers: texts, truth values, dates and complex numbers, also where numpy would convert them;
        masked numbers.
    """
    # The usual kinds first: the full check takes longer than a tube's equilibrium.
    if type(value) is float or (type(value) is np.ndarray and value.dtype.kind == "f" and value.dtype.itemsize <= 8):
        return np.array(value, dtype=np.float64)
    rule = f"{name} must be a number or an array of numbers, got {shown(value)}"
    if np.ma.is_masked(value):  # what lies under a mask is not meant
        raise ValueError(f"{name} must have no masked numbers, got {shown(value)}")
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


def one_positive(name: str, value: Any) -> float:
    """As `one_real`, finite and positive."""
    number = one_real(name, value)
    if not (np.isfinite(number) and number > 0.0):
        raise ValueError(f"{name} must be finite and positive, got {number}")
    return number


def one_not_negative(name: str, value: Any) -> float:
    """As `one_real`, finite and not negative."""
    number = one_real(name, value)
    if not (np.isfinite(number) and number >= 0.0):
        raise ValueError(f"{name} must be finite and not negative, got {number}")
    return number


def one_whole(name: str, value: object, least: int, most: int | None = None) -> int:
    """A whole number of at least ``least``, and at most ``most``; ValueError for anything else."""
    is_whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
    number = int(value) if is_whole else least - 1  # type: ignore[call-overload]
    if number < least or (most is not None and number > most):
        end = "" if most is None else f" and at most {most}"
        raise ValueError(f"{name} must be a whole number of at least {least}{end}, got {shown(value)}")
    return int(number)


def of_type(name: str, value: object, *kinds: type) -> None:
    """TypeError unless the value is one of the types."""
    if not isinstance(value, kinds):
        known = " or ".join(kind.__name__ for kind in kinds)
        raise TypeError(f"{name} must be of type {known}, got {shown(value)}")


def function(name: str, value: object) -> None:
    """TypeError unless the value can be called."""
    if not callable(value):
        raise TypeError(f"{name} must be a function, got {shown(value)}")


def finite_of_shape(name: str, value: ArrayLike, shape: tuple[int, ...]) -> Array:
    """A copy as finite floats of exactly this shape; errors as for `real_array`."""
    try:
        array = real_array(name, value)
    except ValueError:
        raise ValueError(f"{name} must be numbers of shape {shape}, got {shown(value)}") from None
    if array.shape != shape:
        raise ValueError(f"{name} has shape {array.shape}: expected {shape}")
    return finite_array(name, array)


def joined(name: str, value: Any) -> Array:
    """Flat or regular numbers as an array; a list of arrays of different lengths one after the other."""
    try:
        return real_array(name, value)
    except ValueError:
        pass
    try:
        return np.concatenate([real_array(name, part) for part in value])
    except (TypeError, ValueError):
        rule = "numbers: flat, (segments, n), or one array a segment"
        raise ValueError(f"{name} must be {rule}, got {shown(value)}") from None


def real_list(name: str, value: Any) -> list[float]:
    """Real numbers in a row as a list; errors as for `real_array`."""
    array = real_array(name, value)
    if array.ndim != 1:
        raise ValueError(f"{name} must be a list of numbers, got shape {array.shape}")
    return [float(number) for number in array]


def is_rotation(matrix: Array) -> bool:
    """Is a 3x3 matrix orthogonal, without reflection? To 1e-5: typed by hand or read from a file it has six digits."""
    if not (np.abs(matrix) < 1.1).all():  # before products of its entries overflow
        return False
    orthogonal = np.allclose(matrix @ matrix.T, np.eye(3), rtol=0.0, atol=1e-5)
    return bool(orthogonal and np.linalg.det(matrix) > 0.0)


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


def truths(name: str, value: ArrayLike, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """A copy as booleans of exactly this shape; ValueError for anything but True and False."""
    try:
        given = np.array(value)
    except ValueError:  # lists of different lengths
        given = np.empty(0)
    if given.shape != shape or given.dtype != np.bool_:
        raise ValueError(f"{name} must be True or False in shape {shape}, got {shown(value)}")
    return given
