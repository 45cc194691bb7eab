"""What a scene is measured with: what is true there, and methods with their settings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "CONSTANT_CURVATURE",
    "LEAST_SQUARES",
    "OURS",
    "PAPER",
    "PAPER_CONSTANTS",
    "QUICK_STEPS",
    "SHOOTING",
    "SOLVE_BVP",
    "STEPS",
    "Method",
    "NoAnswer",
    "Prepared",
    "Reference",
    "Scene",
    "Setting",
    "power",
]

Array = NDArray[np.float64]

OURS = "softlimb"
SHOOTING = "single shooting, RK4"
SOLVE_BVP = "scipy solve_bvp"
LEAST_SQUARES = "scipy least_squares"
PAPER = "the paper's algorithm"
PAPER_CONSTANTS = "the paper's constants and algorithm"
CONSTANT_CURVATURE = "constant curvature"

STEPS = (5, 10, 20, 40, 80)
"""RK4 steps that are tried."""
QUICK_STEPS = (10, 40)


def power(tolerance: float) -> str:
    """A power of ten as short as it can be written: "1e-6"."""
    return f"{tolerance:.0e}".replace("e-0", "e-")


class NoAnswer(Exception):
    """Why a method has no answer, in a few words."""


@dataclass(frozen=True)
class Reference:
    """What is true, by two methods that share no code.

    Parameters
    ----------
    values : (array, array)
        The tip's position, or a tube's length as the only number [m].
    names : (str, str)
        Of the two methods.
    length : float
        What errors are relative to [m].
    """

    values: tuple[Array, Array]
    names: tuple[str, str]
    length: float

    @property
    def agreement(self) -> float:
        """Distance between the two, over the length."""
        return float(np.linalg.norm(self.values[0] - self.values[1])) / self.length

    def error(self, value: Array) -> float:
        """The larger of the distances from both, over the length: never below half of what they differ by."""
        return max(float(np.linalg.norm(value - true)) for true in self.values) / self.length


@dataclass(frozen=True)
class Setting:
    """One way to run a method.

    Parameters
    ----------
    name, mark : str
        Such as "40 steps", and "40" in a picture; empty for a method that has nothing to set.
    run : callable
        Finds an answer within a time [s]; this is timed.
    value : callable
        What of the answer is compared with the reference [m]. Raises NoAnswer where there is none.
    asked : float, optional
        Error that the method promises not to exceed.
    """

    name: str
    mark: str
    run: Callable[[float], Any]
    value: Callable[[Any], Array]
    asked: float | None = None


@dataclass(frozen=True)
class Method:
    """A method on a scene.

    Parameters
    ----------
    settings : sequence of Setting
        From coarse to fine: where one runs out of time those after it are not tried.
    unable : str
        Why the method has nothing to say on the scene, instead of settings.
    needs : str, optional
        A module that may be missing; imported before anything is timed.
    where : callable, optional
        What is where an answer ended that is far from the truth, in a few words. A method that solves other equations
        has none: its error is its model's.
    """

    name: str
    settings: Sequence[Setting] = ()
    unable: str = ""
    needs: str | None = None
    where: Callable[[Any], str] | None = None


@dataclass(frozen=True)
class Prepared:
    """A scene ready to be measured; ``remarks`` are what to know of its answer, in sentences."""

    reference: Reference
    methods: Sequence[Method]
    remarks: Sequence[str]


class Scene(Protocol):
    """What is asked of all methods."""

    @property
    def name(self) -> str:
        """Kind and grade: "tube-mild"."""

    @property
    def what(self) -> str:
        """In words."""

    def prepare(self, quick: bool) -> Prepared:
        """Find what is true and list the methods; raises NoAnswer where the package itself has no right answer."""
