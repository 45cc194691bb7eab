"""What a scene does not need costs nothing: solves with something and without it, where the plan says it was left out.

A row stands here for each way of leaving something out that a solve may name in `Posture.plan`. "With" is the same
scene with the smallest trace of the thing, so that nothing can be left out and the answer still is the same. A build
whose plan has not a row's words does not have that way, and the row is not printed.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softlimb import presets
from softlimb.bench import checks, limbs
from softlimb.bench.clock import Clock, Samples, quartiles, seconds_of
from softlimb.limb import Limb
from softlimb.posture import Posture
from softlimb.units import us

__all__ = ["OMISSIONS", "Difference", "Omission"]

Array = NDArray[np.float64]

# As many scenes as make a mean: how much a way saves depends on how far its rods are apart.
_ROWS, _SEED = 20, 20261122
_APART = limbs.random_pressures(_ROWS, 9, _SEED)
_EQUAL = np.repeat(limbs.random_pressures(_ROWS, 3, _SEED), 3, axis=1)
_TRACE = 1e-12  # [N], [m/s^2], share of a pressure: moves the tip by far less than any tolerance


@dataclass(frozen=True)
class Omission:
    """Something that a scene may do without.

    Parameters
    ----------
    with_it, without_it : dict
        Arguments of `Limb.solve`, the one with a trace of it, the other without; ``pressures`` are rows of them, shape
        (n, A), one a scene.
    words : sequence of str
        All are in the plan of each solve without it, and not all in that of any solve with it.
    """

    name: str
    what: str
    with_it: dict[str, Any]
    without_it: dict[str, Any]
    words: Sequence[str]
    limb: Callable[[], Limb] = presets.reference_limb

    def is_named(self, posture: Posture) -> bool:
        """Whether the plan names it."""
        plan = " ".join(posture.plan)
        return all(word in plan for word in self.words)


OMISSIONS = (
    Omission(
        "no-gravity",
        "no gravity",
        {"pressures": _APART, "tip_force": limbs.TIP_FORCE, "gravity": (0.0, 0.0, _TRACE)},
        {"pressures": _APART, "tip_force": limbs.TIP_FORCE},
        ("no gravity",),
    ),
    Omission(
        "no-loads",
        "no loads at all",
        {"pressures": _APART, "gravity": (0.0, 0.0, _TRACE), "tip_force": (_TRACE, 0.0, 0.0)},
        {"pressures": _APART},
        ("no loads",),
    ),
    Omission(
        "equal-pressures",
        "equal pressures, no load across",
        {"pressures": _EQUAL * (1.0 + _TRACE * np.arange(9)), "gravity": limbs.HANGING},
        {"pressures": _EQUAL, "gravity": limbs.HANGING},
        ("equal pressures",),
    ),
)


@dataclass(frozen=True)
class Difference:
    """A row: times with and without, or in ``fault`` why there are none."""

    name: str
    what: str
    fault: str | None = None
    with_it: Samples | None = None
    without_it: Samples | None = None

    @property
    def saved(self) -> float | None:
        """Share of the time that leaving it out saves."""
        if self.with_it is None or self.without_it is None:
            return None
        return 1.0 - quartiles(self.without_it.seconds / self.with_it.seconds)[1]

    def to_dict(self) -> dict[str, Any]:
        """Everything, raw samples included, for a JSON file."""
        known: dict[str, Any] = {"name": self.name, "what": self.what}
        if self.with_it is None or self.without_it is None:
            return known | {"fault": self.fault}
        for name, samples in (("with", self.with_it), ("without", self.without_it)):
            known[name] = {
                "median_us": quartiles(samples.seconds)[1] / us,
                "ratio_to_yardstick": quartiles(samples.ratios)[1],
                "seconds": samples.seconds.tolist(),
                "yardstick_seconds": samples.yardsticks.tolist(),
            }
        return known | {"saved": self.saved}


def _solved(limb: Limb, options: dict[str, Any]) -> list[Posture]:
    loads = {name: given for name, given in options.items() if name != "pressures"}
    return [limb.solve(pressures, **loads) for pressures in options["pressures"]]


def difference_fault(omission: Omission, full: Posture, bare: Posture) -> str | None:
    """What forbids to compare two solves: a wrong one, different answers, or nothing left out."""
    if omission.is_named(full):
        return "left out where it is there"
    within = 2.0 * bare.tolerance * bare.limb.length  # each may be off by its tolerance
    return (
        checks.posture_fault(full)
        or checks.posture_fault(bare)
        or checks.distance_fault(bare.tip[:3, 3], full.tip[:3, 3], within, "the tip without it")
    )


def measure(omission: Omission, clock: Clock) -> Difference | None:
    """The row of an omission; None where this build does not leave it out."""
    limb = omission.limb()
    full, bare = (_solved(limb, options) for options in (omission.with_it, omission.without_it))
    if not all(map(omission.is_named, bare)):
        return None
    fault = checks.first(itertools.starmap(partial(difference_fault, omission), zip(full, bare, strict=True)))
    if fault is not None:
        return Difference(omission.name, omission.what, fault)

    # One solve after another, as in the rows of the first table: a solve alone, between yardsticks, finds its code
    # outside the caches, which takes longer than the rest of it.
    def timed(options: dict[str, Any]) -> float:
        return seconds_of(lambda: _solved(limb, options)) / len(options["pressures"])

    samples = clock.in_turn({"with": lambda: timed(omission.with_it), "without": lambda: timed(omission.without_it)})
    return Difference(omission.name, omission.what, None, samples["with"], samples["without"])
