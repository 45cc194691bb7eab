"""A static posture and what it can be asked: curves, wrenches, stability, clearance, derivatives, verification."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb import _core
from softlimb._core import Section
from softlimb.arguments import finite_array, shown
from softlimb.derivatives import Derivative, Each, Gradient, derivative, gradient, tip_by_pressures
from softlimb.tube import SectionModel, Valve

if TYPE_CHECKING:
    from softlimb.limb import Limb

__all__ = ["Posture", "RodPosture", "Verification"]

Array = NDArray[np.float64]

_MOST_POINTS = 10_000_000  # a gigabyte of poses
_CLEARANCE_POINTS = 25  # pieces of a twenty-fourth: the gap's error is below 0.1 % of a rod
_CURVE_POINTS = 101  # of the arrays along a rod; curves ask for as many as they want


@dataclass(frozen=True)
class Verification:
    """What an independent re-integration of every rod and re-balance of every plate found.

    Parameters
    ----------
    position_error : float
        Largest distance between where a rod ends and where its plate holds it, relative to the limb's length.
    rotation_error : float
        The same for rotations [rad].
    force_error, moment_error : float
        Largest imbalance of a plate or of a point inside a rod, relative to the largest internal force or moment.
    hold_error : float
        Largest departure of a held freedom from its hold (relative length, or rad).
    tolerance : float
        What the posture was asked for.
    """

    position_error: float
    rotation_error: float
    force_error: float
    moment_error: float
    hold_error: float
    tolerance: float

    @property
    def largest_error(self) -> float:
        """The largest of all errors; NaN if any is."""
        errors = (self.position_error, self.rotation_error, self.force_error, self.moment_error, self.hold_error)
        return float(np.max(errors))

    @property
    def success(self) -> bool:
        """True when no error exceeds ten times the tolerance, which bounds the tip's error and not each residual."""
        return bool(self.largest_error <= 10.0 * self.tolerance)


class _CentrelinePart(NamedTuple):
    """Points of the centreline on the rods of a segment (even numbers) or through the plate after them (odd)."""

    number: int
    inside: NDArray[np.intp]  # of the centreline's points
    share: Array  # of the part, from its beginning
    ends: list[tuple[int, list[float]]]  # segments and fractions whose mean, or between whose means, they are


class _CentrelinePlaces(NamedTuple):
    owner: NDArray[np.intp]  # the point of the centreline that each material point is part of
    rods: list[int]
    fractions: list[float]
    weight: Array
    tangent: Array  # (n, 3): by the share of the part that each point stands in
    by_bounds: Array  # (n, 2 segments): that share by where parts end, with the whole's end at the last rods'


class RodPosture:
    """One rod of a posture: its curve and what acts inside it.

    Arrays ``force``, ``moment`` (base axes [N], [N m]), ``strain`` and ``curvature`` (section axes; v [1] and u [1/m])
    have shape (101, 3): equal steps of rest length from base to end, at the fractions ``fractions``. `along` gives them
    at any other number of points.
    """

    def __init__(self, posture: Posture, segment: int, number: int, flat: int) -> None:
        self.posture = posture
        self.segment = segment
        self.number = number
        self._flat = flat

    @property
    def section(self) -> Section:
        """Section at the rod's pressure."""
        return self.posture._scene.sections[self._flat]

    @property
    def length(self) -> float:
        """Rest length [m]."""
        return self.posture._scene.rest_lengths[self._flat]

    @property
    def radius(self) -> float | None:
        """Outer radius of the unpressurised actuator [m], or None when it is not known."""
        return self.posture.limb.segments[self.segment].members[self.number].outer_radius

    @property
    def success(self) -> bool:
        """True when the posture is in equilibrium to its tolerance."""
        return self.posture.success

    @property
    def status(self) -> str:
        """Outcome of the solve."""
        return self.posture.status

    @property
    def message(self) -> str:
        """Outcome in words."""
        return self.posture.message

    @property
    def iterations(self) -> int:
        """Newton iterations of the solve."""
        return self.posture.iterations

    @property
    def residual(self) -> float:
        """Relative residual of the solve."""
        return self.posture.residual

    @property
    def stable(self) -> bool:
        """As for the posture."""
        return self.posture.stable

    @property
    def unstable_modes(self) -> int | None:
        """As for the posture."""
        return self.posture.unstable_modes

    @property
    def tip(self) -> Array:
        """Pose of the rod's end, shape (4, 4)."""
        end: Array = self._curve[0][-1]
        return end

    @property
    def base_wrench(self) -> Array:
        """Internal force and moment at the base, base axes, shape (6,) [N, N m]."""
        return self.posture._solved.rod_base_wrench(self._flat)

    def along(self, n: int = _CURVE_POINTS) -> tuple[Array, Array, Array, Array, Array]:
        """Poses (n, 4, 4), forces, moments, strains and curvatures (n, 3 each) at equal steps of rest length.

        Raises
        ------
        ValueError
            ``n`` is below 2.
        """
        return self.posture._solved.rod(self._flat, np.linspace(0.0, 1.0, _points(n)).tolist())

    @cached_property
    def _curve(self) -> tuple[Array, Array, Array, Array, Array]:
        return self.along(_CURVE_POINTS)

    def centreline(self, n: int = _CURVE_POINTS) -> Array:
        """Points of the centreline at equal steps of rest length, shape (n, 3) [m]."""
        points: Array = self.along(n)[0][:, :3, 3].copy()
        return points

    @property
    def fractions(self) -> Array:
        """Fractions of the rest length at which the arrays are given."""
        return np.linspace(0.0, 1.0, _CURVE_POINTS)

    @property
    def force(self) -> Array:
        """Internal force, base axes [N], shape (101, 3)."""
        return self._curve[1]

    @property
    def moment(self) -> Array:
        """Internal moment, base axes [N m], shape (101, 3)."""
        return self._curve[2]

    @property
    def strain(self) -> Array:
        """v: two shears and the stretch per rest length, section axes, shape (101, 3)."""
        return self._curve[3]

    @property
    def curvature(self) -> Array:
        """u: two curvatures and the twist per rest length, section axes [1/m], shape (101, 3)."""
        return self._curve[4]

    def verify(self) -> Verification:
        """As `Posture.verify`."""
        return self.posture.verify()

    def __repr__(self) -> str:
        place = np.array2string(self.tip[:3, 3], precision=5)
        return f"RodPosture({self.status}, length={self.length:.6g}, tip={place})"


def _points(n: int) -> int:
    if not isinstance(n, (int, np.integer)) or isinstance(n, bool) or not 2 <= n <= _MOST_POINTS:
        raise ValueError(f"a curve needs a whole number of points n, from 2 to {_MOST_POINTS}, got {shown(n)}")
    return int(n)


def _shares(n: int, at: ArrayLike | None) -> Array:
    if at is None:
        return np.linspace(0.0, 1.0, _points(n))
    shares = finite_array("at", at)
    if shares.ndim != 1 or not shares.size:
        raise ValueError(f"at must be a list of shares of the centreline, got shape {shares.shape}")
    if (shares < 0.0).any() or (shares > 1.0).any():
        raise ValueError(f"at must be shares of the centreline, within 0 and 1, got {shares.tolist()}")
    return shares


class Posture:
    """A static posture: poses, internal wrenches, outcome, stability, and answers computed when asked for.

    Where ``success`` is false the poses are the best point found and no equilibrium; ``message`` has the cause.

    Parameters
    ----------
    limb : Limb
    pressures : array, shape (A,), or None
        Gauge pressures [Pa].
    rest_lengths : array, shape (R,)
        Of all rods [m].
    loads : dict
        ``gravity``, ``tip_force``, ``tip_moment``, ``plate_wrenches``, ``frame``, ``rod_forces``, ``rod_moments``.
    tolerance : float
        Tip error asked for, relative to ``limb.length``.
    """

    def __init__(
        self,
        limb: Limb,
        solved: _core.Posture,
        tolerance: float,
        model: tuple[SectionModel, Valve],
        given: dict[str, Any] | None = None,
    ) -> None:
        self.limb = limb
        self.tolerance = tolerance
        self._solved = solved
        self._model = model
        if given is not None:
            self.__dict__.update(given)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_linear"}

    # What a posture from plain numbers was given is read out of the core when it is first asked for.

    @cached_property
    def _solved_pressures(self) -> Array | None:
        return self._solved.pressures

    @cached_property
    def pressures(self) -> Array | None:
        """Gauge pressures [Pa], shape (A,); None where the rods were given otherwise."""
        # A copy: derivatives are those at the pressures that were solved, whatever is written into this one.
        return None if self._solved_pressures is None else self._solved_pressures.copy()

    @cached_property
    def rest_lengths(self) -> Array:
        """Rest lengths of all rods [m], shape (R,)."""
        return np.array(self._scene.rest_lengths)

    @cached_property
    def loads(self) -> dict[str, Any]:
        """Loads as `Limb.solve` takes them, all there."""
        scene, rods = self._scene, len(self.limb._members)
        wrenches = scene.wrenches
        return {
            "gravity": scene.gravity,
            "tip_force": wrenches[-1, :3].copy(),
            "tip_moment": wrenches[-1, 3:].copy(),
            "plate_wrenches": np.zeros_like(wrenches),
            "frame": "plate" if scene.following else "base",
            "rod_forces": np.zeros((rods, 3)),
            "rod_moments": np.zeros((rods, 3)),
        }

    @property
    def success(self) -> bool:
        """True when the posture is in equilibrium to the tolerance asked for."""
        return self._solved.status == "converged"

    @property
    def status(self) -> str:
        """Outcome: converged, max_iterations, no_progress, singular_jacobian, not_finite or limit_point."""
        return self._solved.status

    @property
    def message(self) -> str:
        """Outcome in words, with the warnings."""
        return "; ".join([self._solved.message, *self.warnings])

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """What to know before trusting the answer: a law or an axial curve left its range, tubes touch or lock."""
        if not self.success:
            return ()
        gap, first, *_ = self._nearest
        return tuple(self._solved.remarks(gap, first))

    @property
    def plan(self) -> tuple[str, ...]:
        """Which way the solve took and what it left out, in words."""
        return tuple(self._solved.plan)

    @property
    def iterations(self) -> int:
        """Newton iterations of the exact rods."""
        return self._solved.iterations

    @property
    def descent_iterations(self) -> int:
        """Iterations of the energy descent that came before."""
        return self._solved.descent_iterations

    @property
    def residual(self) -> float:
        """Largest mismatch of a rod and imbalance of a plate before the last step, relative."""
        return self._solved.residual

    @property
    def error_estimate(self) -> float:
        """Last correction, by an integration with half the step: relative to ``limb.length``."""
        return self._solved.error_estimate

    @property
    def stable(self) -> bool:
        """True for a stable equilibrium; without a potential (see `conservative`) it speaks of divergence only."""
        return self._solved.stable

    @property
    def unstable_modes(self) -> int | None:
        """Number of unstable modes, conjugate points of the rods included; None where no potential exists."""
        return self._solved.unstable_modes

    @property
    def conservative(self) -> bool:
        """True when all loads have a potential."""
        return self._solved.conservative

    @cached_property
    def plates(self) -> Array:
        """Pose of each plate in the base frame, shape (J, 4, 4)."""
        return self._solved.plates

    @property
    def tip(self) -> Array:
        """Pose of the last plate, shape (4, 4)."""
        last: Array = self.plates[-1]
        return last

    @property
    def base_wrench(self) -> Array:
        """Force and moment that the ground exerts on the limb, about the base origin, shape (6,) [N, N m]."""
        return self._solved.base_wrench

    @property
    def reactions(self) -> Array:
        """Wrench that the holds exert on each plate, about its origin, base axes, shape (J, 6) [N, N m]."""
        return self._solved.reactions

    @property
    def tip_reaction(self) -> Array:
        """Wrench that the hold exerts on the tip, about its origin, base axes, shape (6,) [N, N m]."""
        reaction: Array = self.reactions[-1]
        return reaction

    @cached_property
    def rods(self) -> tuple[tuple[RodPosture, ...], ...]:
        """``rods[j][i]`` is rod i of segment j."""
        rods, flat = [], 0
        for j, segment in enumerate(self.limb.segments):
            row = []
            for i in range(len(segment.members)):
                row.append(RodPosture(self, j, i, flat))
                flat += 1
            rods.append(tuple(row))
        return tuple(rods)

    def centreline(self, n: int = _CURVE_POINTS, *, at: ArrayLike | None = None) -> Array:
        """The limb's centreline: the mean of a segment's rods at equal fractions, straight through the plates.

        Parameters
        ----------
        n : int
            Number of points, spread evenly over the rest lengths and the plates between segments.
        at : array_like, shape (n,), optional
            Shares of these lengths, from 0 at the base to 1 at the tip, instead of even ones.

        Returns
        -------
        array of float, shape (n, 3)
            From the mean of the first rods' bases to the mean of the last rods' ends [m].

        Raises
        ------
        ValueError
            ``n`` is below 2, or a share is not within 0 and 1.
        """
        shares = _shares(n, at)
        points = np.empty((len(shares), 3))
        for part in self._centreline_parts(shares)[1]:
            ends = [self._positions(j, fractions) for j, fractions in part.ends]
            points[part.inside] = ends[0] if len(ends) == 1 else ends[0] + part.share[:, None] * (ends[1] - ends[0])
        return points

    def _positions(self, segment: int, fractions: list[float]) -> Array:
        """Mean of a segment's rods at fractions of their lengths, shape (fractions, 3)."""
        row = self.rods[segment]
        mean: Array = np.mean([self._solved.rod(rod._flat, fractions)[0][:, :3, 3] for rod in row], axis=0)
        return mean

    def _centreline_parts(self, shares: Array) -> tuple[Array, list[_CentrelinePart]]:
        """Where rods and plates begin and end along the centreline [m], and which of its points are on which."""
        segments = self.limb.segments
        bounds = [0.0]
        for j, row in enumerate(self.rods):
            bounds.append(bounds[-1] + float(np.mean([rod.length for rod in row])))
            if j + 1 < len(segments):
                bounds.append(bounds[-1] + segments[j].plate.thickness)
        path = shares * bounds[-1]
        parts = []
        for k, (start, end) in enumerate(pairwise(bounds)):
            if k % 2 == 0:
                inside = np.flatnonzero((path >= start) & (path <= end))
            else:
                inside = np.flatnonzero((path > start) & (path < end))
            if not inside.size:
                continue
            share = np.clip((path[inside] - start) / (end - start), 0.0, 1.0)
            j = k // 2
            ends = [(j, share.tolist())] if k % 2 == 0 else [(j, [1.0]), (j + 1, [0.0])]
            parts.append(_CentrelinePart(k, inside, share, ends))
        return np.array(bounds), parts

    def _centreline_places(self, shares: Array) -> _CentrelinePlaces:
        """The centreline's points as combinations of points of rods, and how they slide as rods and plates lengthen."""
        bounds, parts = self._centreline_parts(shares)
        tangent, by_bounds = np.zeros((len(shares), 3)), np.zeros((len(shares), 2 * len(self.limb.segments)))
        placed: dict[int, list[tuple[int, float, float]]] = {}
        for part in parts:
            along = bounds[part.number + 1] - bounds[part.number]
            for point, share in zip(part.inside.tolist(), part.share.tolist(), strict=True):
                # share = (share of the whole * whole - start) / (end - start)
                by_bounds[point] = 0.0
                by_bounds[point, len(bounds) - 2] = shares[point] / along
                by_bounds[point, part.number] -= share / along
                if part.number > 0:
                    by_bounds[point, part.number - 1] -= (1.0 - share) / along
                placed[point] = []
            for end, (j, fractions) in enumerate(part.ends):
                row = self.rods[j]
                for rod in row:
                    poses, _, _, strains, _ = self._solved.rod(rod._flat, fractions)
                    if part.number % 2 == 0:
                        slope = rod.length * np.einsum("nij,nj->ni", poses[:, :3, :3], strains)
                        tangent[part.inside] += slope / len(row)
                    for k, point in enumerate(part.inside.tolist()):
                        one = len(part.ends) == 1
                        weight = 1.0 if one else (part.share[k] if end else 1.0 - part.share[k])
                        placed[point].append((rod._flat, fractions[k] if one else fractions[0], weight / len(row)))
            if part.number % 2 == 1:
                first, last = (self._positions(j, fractions) for j, fractions in part.ends)
                tangent[part.inside] = last - first
        flat = [(point, *place) for point, places in sorted(placed.items()) for place in places]
        return _CentrelinePlaces(
            np.array([point for point, *_ in flat]),
            [rod for _, rod, _, _ in flat],
            [fraction for _, _, fraction, _ in flat],
            np.array([weight for *_, weight in flat]),
            tangent,
            by_bounds,
        )

    @cached_property
    def _nearest(self) -> tuple[float, int, int, float, float]:
        radii = [member.outer_radius or 0.0 for member in self.limb._members]
        return self._solved.clearance(radii, _CLEARANCE_POINTS)

    @property
    def clearance(self) -> float | None:
        """Smallest gap between two tubes along the limb [m]; negative where they overlap, None without two radii.

        Unpressurised outer radii are used: fibres keep an FRA's radius to about a per cent.
        """
        gap, first, *_ = self._nearest
        return None if first < 0 else gap

    @property
    def touching(self) -> bool:
        """True when two tubes touch or overlap; contact is not part of the model, so the posture is then in doubt."""
        return self.clearance is not None and self.clearance <= 0.0

    @cached_property
    def energy(self) -> float:
        """Potential energy [J]: the rods' strain energy, less the work of dead forces and weights.

        Of the rods against their rest at their pressures; of forces and weights on the way from the base's origin.

        Raises
        ------
        RuntimeError
            The posture is no equilibrium, or its loads have no potential (a moment on a plate that may turn, a
            following wrench, a moment along a rod).
        """
        self._require_success("an energy")
        return _core.potential_energy(self._solved)

    @cached_property
    def _linear(self) -> _core.Derivatives:
        """The balance, linearised once for compliance, stiffness and all derivatives."""
        return _core.linearised(self._solved, self.tolerance)

    def derivative(
        self,
        of: str | Sequence[str] = "tip",
        to: str | Sequence[str] = "pressures",
        *,
        each: Each = "segment",
        n: int = _CURVE_POINTS,
        at: ArrayLike | None = None,
    ) -> Derivative:
        """Exact derivatives of the posture to pressures, loads, and everything that the limb is made of.

        Parameters
        ----------
        of : str or sequence of str
            ``tip`` and ``plates``: translation and rotation of the last or of every plate; ``centreline``: its ``n``
            points, as `centreline` gives them; ``energy``.
        to : str or sequence of str
            ``pressures``; ``gravity``, ``tip_force``, ``tip_moment``, ``plate_wrenches``, ``rod_forces``; of segments
            ``ring_radius``, ``plate_mass``, ``plate_thickness``; of tubes ``length`` (unpressurised), ``radii`` (of the
            faces between layers, inside first), ``fibre_angle`` (of both families of a pair, apart),
            ``fibre_fraction`` (of one family; both of a pair change), ``fibre_modulus``, ``fibre_stiffness``, ``law``
            (all coefficients), ``density``, ``mass`` (where it was given), ``cap_length``; of rods given directly
            ``length`` and ``section``. Sets of names: `softlimb.derivatives.LOADS` and ``DESIGN``.
        each : {"segment", "actuator", "limb"}
            One column for each segment, whose tubes change together; for each tube; or for the whole limb.
        n, at
            Points of the centreline, as `centreline` takes them.

        Returns
        -------
        Derivative
            ``matrix``, with labels and units of rows and columns. Pressures stay where they are not the parameter, also
            where the posture was asked for by rest lengths; wrenches change in the axes of ``frame``.

        Raises
        ------
        ValueError
            A name is unknown or given twice, no part of the limb has it, or ``each`` or ``n`` is out of range.
        RuntimeError
            The posture is no equilibrium, stands at a fold, or its loads have no potential (``energy``).

        Notes
        -----
        Implicit differentiation of the converged posture, MECHANICS, "Derivatives". Errors are about those of the
        posture: for digits beyond its tolerance solve it to a finer one.
        """
        self._require_success("a derivative")
        return derivative(self, of, to, each, _shares(n, at))

    def gradient(
        self,
        to: str | Sequence[str] = "pressures",
        *,
        tip: ArrayLike | None = None,
        plates: ArrayLike | None = None,
        centreline: ArrayLike | None = None,
        energy: float | None = None,
        each: Each = "segment",
    ) -> Gradient:
        """Derivatives of one number, a combination of answers, at about the cost of one linearisation.

        Parameters
        ----------
        to, each
            As for `derivative`.
        tip, plates, centreline, energy : array_like, shapes (6,), (J, 6), (n, 3), and float, optional
            Derivatives of the number to the answers, in the order and axes of `derivative`; at least one.

        Returns
        -------
        Gradient
            ``values``, with labels and units of the columns.

        Raises
        ------
        ValueError, RuntimeError
            As for `derivative`; no weights, or weights of another shape or not finite.
        """
        self._require_success("a gradient")
        return gradient(self, to, each, tip, plates, centreline, energy)

    @cached_property
    def compliance(self) -> Array:
        """Tip displacement and rotation by tip force and moment, base axes at the tip's origin, shape (6, 6).

        Raises
        ------
        RuntimeError
            The posture is no equilibrium, or stands at a fold.
        """
        self._require_success("a compliance")
        return self._linear.compliance()

    @cached_property
    def plate_stiffness(self) -> Array:
        """Change of the plates' balance with their moves (dp, dtheta), base axes at their origins, shape (6J, 6J).

        Rods condensed; rows and columns of held freedoms are zero. Symmetric where the loads have a potential.

        Raises
        ------
        RuntimeError
            The posture is no equilibrium, or stands at a fold.
        """
        self._require_success("a stiffness")
        return self._linear.plate_stiffness()

    @cached_property
    def _softest(self) -> tuple[float, Array]:
        scale = np.tile([self.limb.length] * 3 + [1.0] * 3, len(self.limb.segments))
        scaled = scale[:, None] * self.plate_stiffness * scale
        values, vectors = np.linalg.eigh(0.5 * (scaled + scaled.T))
        # Held freedoms leave zero rows: their eigenvectors carry no stiffness at all and are no modes.
        free = np.abs(values) > 1e-12 * np.abs(values).max()
        if not free.any():
            raise RuntimeError("every plate is held: no freedom is left whose stiffness could be smallest")
        lowest = int(np.flatnonzero(free)[0])
        return float(values[lowest]), (scale * vectors[:, lowest]).reshape(-1, 6)

    @property
    def smallest_stiffness(self) -> float:
        """Smallest eigenvalue of the plates' stiffness, translations counted in limb lengths [N m]; negative: unstable.

        A rod that buckles between its plates is not in it: `unstable_modes` counts those as well.

        Errors as for `plate_stiffness`; RuntimeError as well where every plate is held.
        """
        return self._softest[0]

    @property
    def mode_shape(self) -> Array:
        """Moves (dp [m], dtheta [rad]) of the plates in the softest mode, shape (J, 6); errors as above."""
        return self._softest[1]

    @cached_property
    def jacobian(self) -> Array:
        """Change of the tip (translation, rotation; base axes at its origin) by each pressure, shape (6, A) [1/Pa].

        Raises
        ------
        RuntimeError
            The posture is no equilibrium, stands at a fold, or was not given by pressures.
        """
        self._require_success("a Jacobian")
        return tip_by_pressures(self)

    def _require_success(self, what: str) -> None:
        if not self.success:
            raise RuntimeError(f"{what} exists at an equilibrium only; this solve ended with {self.status!r}")

    def verify(self) -> Verification:
        """Check the posture by another formulation: quaternions and plain RK4, halved until the ends no longer move.

        Returns
        -------
        Verification
            ``success`` tells whether rods meet their plates and all forces balance. Where an actuator has no state at
            its pressure there is nothing to check, and every error is infinite.
        """
        if self.status == "limit_point":
            return Verification(np.inf, np.inf, np.inf, np.inf, np.inf, self.tolerance)
        return Verification(*self._solved.verify(), self.tolerance)

    @property
    def _scene(self) -> _core.Scene:
        return self._solved.scene

    def __repr__(self) -> str:
        place = np.array2string(1e3 * self.tip[:3, 3], precision=3, suppress_small=True)
        modes = "" if self.stable else ", unstable"
        return f"Posture({self.status}{modes}, tip at {place} mm)"
