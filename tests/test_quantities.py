"""Units in names: what is written comes back bit for bit, and mistakes are named."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from softlimb.quantities import ANGLE, DIMENSIONS, LENGTH, PRESSURE, explain_unknown, named_quantity

numbers = st.floats(allow_nan=False, allow_infinity=False, min_value=-1e12, max_value=1e12)


@given(numbers, st.sampled_from(DIMENSIONS))
def test_a_written_quantity_comes_back_bit_for_bit(value: float, dimension) -> None:
    key, number = named_quantity("thing", value, dimension)
    factor = dimension.factors[key.removeprefix("thing_")]
    assert isinstance(number, float)
    assert number * factor == value
    # -0.0 == 0.0, so the sign of a zero needs its own look.
    assert math.copysign(1.0, number * factor) == math.copysign(1.0, value)


@given(st.lists(st.lists(numbers, max_size=3), max_size=3))
def test_nested_lists_share_one_unit_and_come_back(values: list[list[float]]) -> None:
    key, rows = named_quantity("lengths", values, LENGTH)
    factor = LENGTH.factors[key.removeprefix("lengths_")]
    assert [[entry * factor for entry in row] for row in rows] == values


@pytest.mark.parametrize(
    ("value", "dimension", "expected"),
    [
        (20.5 * 1e-3, LENGTH, ("q_mm", 20.5)),
        (1.33 * math.pi / 180.0, ANGLE, ("q_deg", 1.33)),
        (55e3, PRESSURE, ("q_kPa", 55.0)),
    ],
)
def test_customary_units_give_the_numbers_that_people_typed(value, dimension, expected) -> None:
    assert named_quantity("q", value, dimension) == expected


def test_every_dimension_has_exactly_one_unit_of_size_one() -> None:
    for dimension in DIMENSIONS:
        assert list(dimension.factors.values()).count(1.0) == 1, dimension.name


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("presures_kPa", "unknown key `presures_kPa` in [scene]: did you mean `pressures_kPa`?"),
        ("pressures", "key `pressures` in [scene] needs its unit in the name: `pressures_kPa`, `pressures_Pa`"),
        ("pressures_mm", "key `pressures_mm` in [scene]: `mm` is not a unit of pressure; use `pressures_kPa`"),
        ("zzz", "unknown key `zzz` in [scene]: known are `frame`, `pressures_kPa`"),
    ],
)
def test_an_unknown_key_is_explained(name: str, message: str) -> None:
    assert explain_unknown(name, "in [scene]", {"pressures": PRESSURE}, ["frame"]).startswith(message)
