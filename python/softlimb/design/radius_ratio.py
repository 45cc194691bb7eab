"""The study of the radius reduction ratio: payload against flexibility, and which ratio is best for whom."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb.arguments import finite_array, one_finite, one_not_negative, one_of, one_real
from softlimb.design.criteria import (
    SIX_DIRECTIONS,
    Bending,
    Compliance,
    Criterion,
    LawMargin,
    Mass,
    Payload,
    PressureSet,
    RingGap,
    WorkspaceVolume,
)
from softlimb.design.many import evaluate_many
from softlimb.design.parameters import HELD, Held, RadiusRatio
from softlimb.design.problem import Evaluation, Problem
from softlimb.limb import Limb
from softlimb.units import kPa

__all__ = ["FLEXIBILITIES", "RatioStudy", "radius_ratio"]

Array = NDArray[np.float64]
Flexibility = Literal["bending", "workspace", "compliance"]

FLEXIBILITIES: dict[str, str] = {
    "bending": "mean angle of the tip over the workspace's pressures [rad]",
    "workspace": "volume of the hull of the tip's positions there [m^3]",
    "compliance": "move of the tip along a small force, mean over its directions [m/N]",
}
"""What flexibility may mean; the answer depends on it."""

_STATED_RATIO = 0.5  # of Zhang et al.
_STUDY_TOLERANCE = 1e-4  # of the tip: what moves an optimum by less than the grid
_SHARE_OF_LENGTH = 0.1  # the largest deflection under the payload, of the limb's length


@dataclass(frozen=True)
class RatioStudy:
    """Designs along the radius ratio, with payload and flexibility of each.

    Parameters
    ----------
    held : {"proximal", "mass", "volume"}
    ratios : array, shape (N,)
        Of the designs that have values, ascending.
    payloads : array, shape (N, 6)
        Along +x, -x, +y, -y, +z, -z [N].
    flexibilities : mapping of str to array of shape (N,)
        As in `FLEXIBILITIES`.
    mass, gap, law_margin : array, shape (N,)
        [kg]; smallest gap between neighbours on a ring, unpressurised [m]; see `LawMargin`, at the workspace's largest
        pressure [1].
    failures : mapping of float to str
        Ratio of a design that failed, to the reason.
    assumptions : tuple of str
        What the numbers hold for, in words.
    """

    held: Held
    ratios: Array
    payloads: Array
    flexibilities: Mapping[str, Array]
    mass: Array
    gap: Array
    law_margin: Array
    failures: Mapping[float, str]
    assumptions: tuple[str, ...]

    @property
    def payload(self) -> Array:
        """The smallest of the six [N], shape (N,)."""
        smallest: Array = self.payloads.min(axis=1)
        return smallest

    def flexibility(self, kind: str = "bending") -> Array:
        """One of `FLEXIBILITIES`, shape (N,); ValueError for another name."""
        one_of("flexibility", kind, tuple(FLEXIBILITIES))
        return self.flexibilities[kind]

    def pareto(self, kind: str = "bending") -> NDArray[np.bool_]:
        """Which designs no other one beats in payload and flexibility at once, shape (N,)."""
        both = np.stack([self.payload, self.flexibility(kind)], axis=1)
        as_good = np.all(both[None] >= both[:, None], axis=2)
        better = np.any(both[None] > both[:, None], axis=2)
        beaten: NDArray[np.bool_] = np.any(as_good & better, axis=1)
        return ~beaten

    def merit(self, payload_weight: float, kind: str = "bending") -> Array:
        """payload^w flexibility^(1 - w), relative to its largest value, shape (N,).

        A product of powers: no unit and no range of ratios changes which design is best.
        """
        weight = _weight(payload_weight)
        logs = weight * np.log(self.payload) + (1.0 - weight) * np.log(self.flexibility(kind))
        relative: Array = np.exp(logs - logs.max())
        return relative

    def best(self, payload_weight: float = 0.5, kind: str = "bending") -> float:
        """The ratio of the largest merit; between ratios by the parabola through the best three.

        Raises
        ------
        ValueError
            The weight is not within 0 and 1, or flexibility is none of the three.
        """
        return float(self._best_of(np.array([_weight(payload_weight)]), kind)[0][0])

    def _best_of(self, weights: Array, kind: str) -> tuple[Array, NDArray[np.bool_]]:
        """The best ratio for each weight, and whether others on both sides of it are worse, shape (weights,)."""
        logs = np.outer(weights, np.log(self.payload)) + np.outer(1.0 - weights, np.log(self.flexibility(kind)))
        each, k = np.arange(len(weights)), np.argmax(logs, axis=1)
        found: Array = self.ratios[k].copy()
        inside = (k > 0) & (k < len(self.ratios) - 1)
        each, k = each[inside], k[inside]
        before, after = self.ratios[k - 1] - self.ratios[k], self.ratios[k + 1] - self.ratios[k]
        # Slopes of the chords to both neighbours: the parabola's slope at the middle, and its curvature.
        left, right = (logs[each, k - 1] - logs[each, k]) / before, (logs[each, k + 1] - logs[each, k]) / after
        curvature = (right - left) / (after - before)
        slope = left - curvature * before
        falls = curvature < 0.0
        found[each[falls]] -= 0.5 * slope[falls] / curvature[falls]
        return found, inside

    def weights_for(self, ratio: float, kind: str = "bending", within: float = 0.05) -> tuple[float, float] | None:
        """Smallest and largest weight of the payload for which the best ratio is within a distance of one; or None.

        Weights are tried in steps of a thousandth. A best ratio at an end of those studied does not count: farther out
        there may be a better one.

        Raises
        ------
        ValueError
            Ratio or distance is no finite number, or flexibility is none of the three.
        """
        ratio, within = one_finite("ratio", ratio), one_not_negative("within", within)
        weights = np.linspace(0.0, 1.0, 1001)
        best, inside = self._best_of(weights, kind)
        found = weights[inside & (np.abs(best - ratio) <= within)]
        return (float(found[0]), float(found[-1])) if found.size else None

    def verdict(self, kind: str = "bending") -> str:
        """Whether the paper's ratio of 0.5 comes out, in a sentence."""
        one_of("flexibility", kind, tuple(FLEXIBILITIES))
        if not self.ratios[0] <= _STATED_RATIO <= self.ratios[-1]:
            return f"the paper's ratio {_STATED_RATIO:g} is outside the ratios studied"
        weights = self.weights_for(_STATED_RATIO, kind)
        best, inside = self._best_of(np.array([0.0, 0.5, 1.0]), kind)
        said = [f"{b:.2f}{'' if i else ', an end of the ratios studied,'}" for b, i in zip(best, inside, strict=True)]
        text = f"{self.held} held, flexibility by {kind}: best ratio {said[1]} for equal weights"
        text += f" ({said[0]} for flexibility alone, {said[2]} for payload alone); "
        if weights is None and _STATED_RATIO in (self.ratios[0], self.ratios[-1]):
            return text + f"{_STATED_RATIO:g} is an end of the ratios studied: whether it is best cannot be told"
        if weights is None:
            return text + f"{_STATED_RATIO:g} does not come out for any weight"
        low, high = weights
        which = f"a payload's weight of {low:.3f}" if low == high else f"payload's weights of {low:.3f}..{high:.3f}"
        return text + f"{_STATED_RATIO:g} (to 0.05) comes out for {which}"


def radius_ratio(
    limb: Limb | None = None,
    ratios: ArrayLike | None = None,
    held: Held = "proximal",
    *,
    pressures: ArrayLike | None = None,
    max_deflection: float | None = None,
    max_pressure: float = 60.0 * kPa,
    postures: int = 512,
    seed: int = 0,
    gravity: Sequence[float] = (0.0, 0.0, 9.81),
    workers: int = 1,
    history: str | os.PathLike[str] | None = None,
    progress: Callable[[Evaluation, int], None] | None = None,
) -> RatioStudy:
    """Payload and flexibility of a limb whose radius reduction ratio changes.

    Parameters
    ----------
    limb : Limb, optional
        Of tubes, two segments or more. Default: the reference limb.
    ratios : array_like, shape (N,), optional
        Inner radius of the last segment's tubes over that of the first's, see `RadiusRatio`. Default: 36 from 0.3 to 1.
    held : {"proximal", "mass", "volume"}
        What stays the same.
    pressures : array_like, shape (A,), optional
        Of the posture that is loaded [Pa]. Default: 30 kPa everywhere, the straight limb.
    max_deflection : float, optional
        Under the payload [m]. Default: a tenth of the limb's length.
    max_pressure, postures, seed
        Of the workspace, see `PressureSet`.
    gravity : sequence of 3 float
        [m/s^2]. Default: hanging.
    workers, history, progress
        As for `evaluate_many`.

    Returns
    -------
    RatioStudy

    Raises
    ------
    ValueError
        Ratios not positive or fewer than three, an argument that a criterion refuses, no design has values.
    """
    from softlimb import presets

    one_of("held", held, HELD)
    template = presets.reference_limb() if limb is None else limb
    grid = np.unique(finite_array("ratios", np.linspace(0.3, 1.0, 36) if ratios is None else ratios))
    if grid.ndim != 1 or len(grid) < 3 or grid[0] <= 0.0:
        raise ValueError(f"ratios must be three positive numbers or more, got {grid.tolist()}")
    loaded = np.full(len(template._tubes), 30.0 * kPa) if pressures is None else pressures
    deflection = _SHARE_OF_LENGTH * template.length if max_deflection is None else max_deflection
    problem = study_problem(
        template, held, (float(grid[0]), float(grid[-1])), loaded, deflection, max_pressure, postures, seed, gravity
    )
    found = evaluate_many(problem, grid[:, None], workers=workers, history=history, progress=progress)
    good = [each for each in found if each.success]
    failures = {each.values[0]: each.failure for each in found if not each.success}
    if len(good) < 3:
        raise ValueError(f"fewer than three ratios have values: {failures}")
    table = np.array([each.also for each in good])
    columns = dict(zip(_columns(len(template)), table.T, strict=True))
    gaps = np.min([columns[f"gap {j}"] for j in range(len(template))], axis=0)
    return RatioStudy(
        held,
        np.array([each.values[0] for each in good]),
        table[:, :6],
        {kind: columns[kind] for kind in FLEXIBILITIES},
        columns["mass"],
        gaps,
        columns["law margin"],
        failures,
        (
            _what_is_held(held),
            "a straight taper of all radii and rings; lengths, laws, wall proportions, thread and pitch stay",
            f"payload: smallest of six directions, tip moved by {1e3 * deflection:.1f} mm or stability lost",
            f"workspace: {postures} postures, 0 to {max_pressure / kPa:g} kPa, seed {seed}",
            f"gravity ({', '.join(f'{g:g}' for g in gravity)}) m/s^2; tip to {_STUDY_TOLERANCE:g} of the length",
        ),
    )


def study_problem(
    limb: Limb,
    held: Held,
    bounds: tuple[float, float],
    pressures: ArrayLike,
    max_deflection: float,
    max_pressure: float,
    postures: int,
    seed: int,
    gravity: Sequence[float],
) -> Problem:
    """What `radius_ratio` evaluates: the smallest payload, and beside it all that the study shows."""
    scene: dict[str, Any] = {"gravity": tuple(gravity), "tolerance": _STUDY_TOLERANCE}
    workspace = PressureSet(max_pressure, postures, seed, scene=scene)
    also: list[Criterion] = [Payload(pressures, max_deflection, (along,), scene=scene) for along in SIX_DIRECTIONS]
    also += [Bending(workspace), WorkspaceVolume(workspace), Compliance(pressures, scene), Mass()]
    also += [LawMargin(max_pressure), *(RingGap(j) for j in range(len(limb)))]
    objective = Payload(pressures, max_deflection, scene=scene)
    return Problem(limb, [RadiusRatio(*bounds, held=held)], objective, also=also)


def _columns(segments: int) -> list[str]:
    along = [f"payload {k}" for k in range(len(SIX_DIRECTIONS))]
    return [*along, *FLEXIBILITIES, "mass", "law margin", *(f"gap {j}" for j in range(segments))]


def _what_is_held(held: Held) -> str:
    return {
        "proximal": "the proximal segment stays; mass and volume grow with the ratio",
        "mass": "the mass of the whole limb stays; the proximal radius shrinks as the ratio grows",
        "volume": "the volume of the tubes' outer cylinders stays; the proximal radius shrinks as the ratio grows",
    }[held]


def _weight(value: float) -> float:
    weight = one_real("payload_weight", value)
    if not 0.0 <= weight <= 1.0:
        raise ValueError(f"payload_weight must be within 0 and 1, got {weight}")
    return weight
