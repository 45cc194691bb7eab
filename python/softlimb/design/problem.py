"""A design problem: what may change, what is to be large or small, and what must stay within limits."""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb.arguments import finite_of_shape, one_finite, one_of, shown
from softlimb.design.criteria import Criterion
from softlimb.design.numbers import LimbNumbers
from softlimb.design.parameters import Parameter, at_values, slopes_at
from softlimb.limb import Limb

__all__ = ["Constraint", "Evaluation", "Problem"]

Array = NDArray[np.float64]
Sense = Literal["maximise", "minimise"]

# Of a parameter's range: differences of answers that are good to 1e-9 then have errors of 1e-6 by rounding, and by
# curvature as much where the answer changes by its own size over the range.
_DIFFERENCE = 1e-3


@dataclass(frozen=True)
class Constraint:
    """A limit of a criterion.

    Parameters
    ----------
    criterion : Criterion
    at_least, at_most : float, optional
        In the criterion's unit; exactly one of the two.

    Raises
    ------
    ValueError
        Not exactly one limit, or one that is not finite.
    """

    criterion: Criterion
    at_least: float | None = None
    at_most: float | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.criterion, Criterion):
            raise TypeError(f"criterion of a constraint must be a Criterion, got {shown(self.criterion)}")
        if (self.at_least is None) == (self.at_most is None):
            raise ValueError(f"a constraint on {self.criterion.name} takes either at_least or at_most")
        one_finite(f"limit of {self.criterion.name}", self.limit)

    @property
    def limit(self) -> float:
        """The one that was given."""
        limit = self.at_least if self.at_least is not None else self.at_most
        assert limit is not None
        return limit

    @property
    def sign(self) -> float:
        """1 where the value may not be larger, -1 where it may not be smaller."""
        return 1.0 if self.at_least is None else -1.0

    def __str__(self) -> str:
        relation = "<=" if self.at_least is None else ">="
        return f"{self.criterion.name} {relation} {self.limit:g} {self.criterion.unit}"


@dataclass(frozen=True)
class Evaluation:
    """What is known of one design.

    Parameters
    ----------
    values : tuple of float
        Of the parameters.
    objective : float
        NaN where the design failed.
    constraints : tuple of float
        Values of the constraints' criteria; empty where the design failed.
    also : tuple of float
        Values of the criteria that are only recorded; empty where the design failed.
    gradients : tuple of tuples of float, or None
        Objective first, then constraints, by each parameter; None where not asked for.
    by_differences : tuple of str
        Criteria whose gradient came from differences, because the core has no exact one here.
    failure : str
        Why the design has no values; empty where it has.
    """

    values: tuple[float, ...]
    objective: float
    constraints: tuple[float, ...] = ()
    also: tuple[float, ...] = ()
    gradients: tuple[tuple[float, ...], ...] | None = None
    by_differences: tuple[str, ...] = ()
    failure: str = ""

    @property
    def success(self) -> bool:
        """True when the design has values."""
        return not self.failure


class Problem:
    """What to design.

    Parameters
    ----------
    limb : Limb
        Where the design starts from; what no parameter changes stays as it is there.
    parameters : sequence of Parameter
        They act one after the other.
    objective : Criterion
    sense : {"maximise", "minimise"}
    constraints : sequence of Constraint
    also : sequence of Criterion
        Recorded with every design.

    Raises
    ------
    ValueError
        No parameters, two of one name, or a parameter or criterion of something that the limb does not have.
    TypeError
        A parameter, criterion or constraint is none.
    """

    def __init__(
        self,
        limb: Limb,
        parameters: Sequence[Parameter],
        objective: Criterion,
        sense: Sense = "maximise",
        constraints: Sequence[Constraint] = (),
        also: Sequence[Criterion] = (),
    ) -> None:
        self.numbers = LimbNumbers(limb)
        if not isinstance(parameters, Sequence):
            raise TypeError(f"parameters must be a sequence of parameters, got {type(parameters).__name__}")
        self.parameters = tuple(parameters)
        if not self.parameters:
            raise ValueError("parameters must be at least one, got none")
        for parameter in self.parameters:
            if not isinstance(parameter, Parameter):
                raise TypeError(f"parameters must each be a Parameter, got {shown(parameter)}")
        for criterion in (objective, *also):
            if not isinstance(criterion, Criterion):
                raise TypeError(f"objective and also must be made of criteria, got {shown(criterion)}")
        one_of("sense", sense, ("maximise", "minimise"))
        for constraint in constraints:
            if not isinstance(constraint, Constraint):
                raise TypeError(f"constraints must each be a Constraint, got {shown(constraint)}")
        self.objective, self.sense, self.constraints = objective, sense, tuple(constraints)
        self.also = tuple(also)
        names = [parameter.name for parameter in self.parameters]
        if len(set(names)) != len(names):
            raise ValueError(f"parameters must have different names, got {', '.join(names)}")
        for criterion in (*self.criteria, *self.also):
            criterion.require(limb)
        # Labels that the limb does not have are mistakes of the caller and no failed designs.
        at_values(self.numbers, self.parameters, self.start)

    @property
    def start(self) -> Array:
        """Values that leave the limb as it is, moved within the bounds; shape (parameters,)."""
        values = [parameter.start(self.numbers) for parameter in self.parameters]
        return np.clip(values, self.lower, self.upper)

    @property
    def lower(self) -> Array:
        """Lower bounds, shape (parameters,)."""
        return np.array([parameter.lower for parameter in self.parameters])

    @property
    def upper(self) -> Array:
        """Upper bounds, shape (parameters,)."""
        return np.array([parameter.upper for parameter in self.parameters])

    @property
    def criteria(self) -> tuple[Criterion, ...]:
        """The objective and those of the constraints."""
        return (self.objective, *(constraint.criterion for constraint in self.constraints))

    def limb(self, values: ArrayLike) -> Limb:
        """The limb of some values of the parameters.

        Raises
        ------
        ValueError
            Values of a wrong shape or not finite, or there is no such limb.
        """
        return at_values(self.numbers, self.parameters, self._checked(values)).limb()

    def evaluate(self, values: ArrayLike, *, gradients: bool = False) -> Evaluation:
        """Values of all criteria at some values of the parameters, and their gradients.

        A design that cannot be built, or whose criteria have no value, is an evaluation with its ``failure``.

        Parameters
        ----------
        values : array_like, shape (parameters,)
            Within the bounds or not.
        gradients : bool
            Exact where the core has them; else central differences, one-sided at a bound.

        Raises
        ------
        ValueError
            Values of a wrong shape or not finite.
        """
        x = self._checked(values)
        given = tuple(x.tolist())
        try:
            limb = self.limb(x)
            found = [criterion.evaluate(limb, gradients) for criterion in self.criteria]
            also = [criterion.value(limb) for criterion in self.also]
            rows, differenced = None, []
            if gradients:
                slopes = slopes_at(self.numbers, self.parameters, x)
                rows = np.zeros((len(found), len(x)))
                for k, (_, by_label) in enumerate(found):
                    if by_label is None:
                        differenced.append(k)
                        continue
                    for label, slope in by_label.items():
                        if label in slopes:
                            rows[k] += slope * slopes[label]
                if differenced:
                    rows[differenced] = self._differences(x, differenced, np.array([v for v, _ in found]))
        except (ValueError, RuntimeError) as error:
            return Evaluation(given, np.nan, failure=" ".join(str(error).split()))
        numbers_found = [float(value) for value, _ in found]
        judged = zip((*self.criteria, *self.also), (*numbers_found, *also), strict=True)
        wrong = [criterion.name for criterion, value in judged if not np.isfinite(value)]
        if wrong:
            return Evaluation(given, np.nan, failure=f"{wrong[0]} is not finite")
        return Evaluation(
            given,
            numbers_found[0],
            tuple(numbers_found[1:]),
            tuple(also),
            None if rows is None else tuple(tuple(row) for row in rows.tolist()),
            tuple(self.criteria[k].name for k in differenced),
        )

    def _differences(self, x: Array, chosen: Sequence[int], here: Array) -> Array:
        """Derivatives of some criteria by each parameter, shape (chosen, parameters)."""
        found = np.zeros((len(chosen), len(x)))

        def at(k: int, step: float) -> Array:
            moved = x.copy()
            moved[k] += step
            limb = self.limb(moved)
            return np.array([self.criteria[c].value(limb) for c in chosen])

        centre = here[list(chosen)]
        for k in range(len(x)):
            step = _DIFFERENCE * (self.upper[k] - self.lower[k])
            if x[k] + step > self.upper[k] or x[k] - step < self.lower[k]:
                inwards = -step if x[k] + step > self.upper[k] else step
                found[:, k] = (4.0 * at(k, inwards) - at(k, 2.0 * inwards) - 3.0 * centre) / (2.0 * inwards)
            else:
                found[:, k] = (at(k, step) - at(k, -step)) / (2.0 * step)
        return found

    def _checked(self, values: ArrayLike) -> Array:
        return finite_of_shape("values", values, (len(self.parameters),))

    def description(self) -> dict[str, Any]:
        """Everything that an evaluation depends on, as texts and numbers: what a file of evaluations is of."""
        return {
            "limb": repr(self.numbers.template),  # to six digits; the numbers have all
            "numbers": {label: self.numbers.given(label) for label in self.numbers.labels},
            "parameters": [_text(parameter) for parameter in self.parameters],
            "criteria": [_text(criterion) for criterion in (*self.criteria, *self.also)],
        }

    def __repr__(self) -> str:
        what = f"{self.sense} {self.objective.name}"
        return f"Problem({what}, {len(self.parameters)} parameters, {len(self.constraints)} constraints)"


def _text(thing: object) -> str:
    """A text with all digits that is the same in every session: functions by name and not by address."""
    with np.printoptions(threshold=sys.maxsize, floatmode="unique"):
        return re.sub(r" at 0x[0-9a-f]+", "", repr(thing))
