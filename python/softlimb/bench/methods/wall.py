"""A tube's thick wall as a boundary value problem in the radius: balance of the Cauchy stress, shot or collocated.

The package makes an energy stationary by quadrature; here nothing of that is used. With the reference radius R as
coordinate, stretch l and twist per reference length tau, incompressibility and radial balance read

    r' = R/(r l),   s' = (hoop - radial) r'/r   with s the radial stress,
    N' = 2 pi r axial r',   M' = 2 pi r^2 shear r'

s runs from -P to 0, N from 0 to pi r_i^2 P (closed ends), M from 0 to 0. Three numbers are not known: l, tau and the
inner radius. Stresses of the silicone are 2 W'(I1) (B - B_rr 1), of a fibre family k (1 - 1/stretch) a a^T with the
deformed fibre direction a (MECHANICS, "Actuator", has them in other letters). Lengths count in R_i, stresses in a shear
modulus.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from softlimb import _core
from softlimb.bench.methods.least_squares import GaveUp
from softlimb.paper.problem import Array
from softlimb.tube import Layer, Tube

__all__ = ["STEPS", "Found", "Wall", "by_collocation", "by_least_squares", "by_shooting"]

STEPS = 40
"""RK4 steps a layer where nothing else is asked for."""

_COMPLEX_STEP = 1e-30
_LARGEST_STEP = 0.1  # of a stretch, or of the inner radius over its own: ballooning is a few of them away
_MOST_ITERATIONS = 50


@dataclass(frozen=True)
class Found:
    """Outcome of a method: ``stretch`` where it converged, and what it came from."""

    converged: bool
    outcome: str
    stretch: float = float("nan")
    iterations: int = 0
    residual: float = float("nan")


class Wall:
    """Layers of a tube as numbers.

    Parameters
    ----------
    tube : Tube
        Of Yeoh's law or neo-Hooke's, with fibres that act both ways, ends that turn freely and no caps.
    pressure : float
        Gauge pressure [Pa].

    Raises
    ------
    ValueError
        The tube has something that is not written down here.
    """

    def __init__(self, tube: Tube, pressure: float) -> None:
        for name, odd in (
            ("tension-only fibres", tube.tension_only),
            ("bonded ends", tube.ends != "free"),
            ("caps", tube.cap_length != 0.0),
        ):
            if odd:
                raise ValueError(f"the wall's equations are written for tubes without {name}")
        self.radius = tube.inner_radius
        self.faces = np.array([tube.layers[0].inner, *(layer.outer for layer in tube.layers)]) / self.radius
        first = tube.layers[0].law.shear_modulus
        self.pressure = pressure / first
        self.layers = [_Silicone.of(layer, first) for layer in tube.layers]

    def slope(self, number: int, reference: Array, state: Array, stretch: Array, twist: Array) -> Array:
        """Derivative of (r, s, N, M), first axis, to the reference radius within a layer."""
        r, radial = state[0], state[1]
        rate = reference / (r * stretch)
        hoop, axial, shear = self.layers[number].beyond_radial(r / reference, r * twist, stretch)
        slope = np.empty_like(state)
        slope[0] = rate
        slope[1] = hoop * rate / r
        slope[2] = 2.0 * np.pi * r * (radial + axial) * rate
        slope[3] = 2.0 * np.pi * r**2 * shear * rate
        return slope

    def shot(self, unknowns: Array, steps: int) -> Array:
        """What is left of the three conditions outside, shape (..., 3), for (l, r_i, tau) of shape (..., 3)."""
        stretch, inner, twist = np.moveaxis(unknowns, -1, 0)
        state = np.stack([inner, np.full_like(inner, -self.pressure), 0.0 * inner, 0.0 * inner])
        for number, (start, end) in enumerate(zip(self.faces[:-1], self.faces[1:], strict=True)):
            h = (end - start) / steps
            for k in range(steps):
                at = start + k * h
                k1 = self.slope(number, at, state, stretch, twist)
                k2 = self.slope(number, at + 0.5 * h, state + 0.5 * h * k1, stretch, twist)
                k3 = self.slope(number, at + 0.5 * h, state + 0.5 * h * k2, stretch, twist)
                k4 = self.slope(number, at + h, state + h * k3, stretch, twist)
                state = state + (h / 6.0) * (k1 + 2.0 * (k2 + k3) + k4)
        return np.stack([state[1], state[2] - np.pi * inner**2 * self.pressure, state[3]], axis=-1)


@dataclass(frozen=True)
class _Silicone:
    """A layer: coefficients of W in I1 - 3 times the silicone's share, fibres as (cos, sin, k)."""

    coefficients: tuple[float, float, float]
    fibres: tuple[tuple[float, float, float], ...]

    @classmethod
    def of(cls, layer: Layer, unit: float) -> _Silicone:
        law = layer.law
        if not isinstance(law, (_core.Yeoh, _core.NeoHookean)):
            raise ValueError(f"the wall's equations are written for Yeoh and NeoHookean, got {type(law).__name__}")
        c = (law.c1, law.c2, law.c3) if isinstance(law, _core.Yeoh) else (law.c1, 0.0, 0.0)
        c1, c2, c3 = (layer.silicone_fraction * value / unit for value in c)
        fibres = tuple((float(np.cos(f.angle)), float(np.sin(f.angle)), f.stiffness / unit) for f in layer.fibres)
        return cls((c1, c2, c3), fibres)

    def beyond_radial(self, widening: Array, turn: Array, stretch: Array) -> tuple[Array, Array, Array]:
        """Hoop and axial stress less the radial one, and the shear, where F = [[r/R, r tau], [0, l]] off the radius."""
        radial = 1.0 / (widening * stretch) ** 2
        hoop, axial, shear = widening**2 + turn**2, stretch**2, turn * stretch
        x = hoop + axial + radial - 3.0
        c1, c2, c3 = self.coefficients
        twice = 2.0 * (c1 + x * (2.0 * c2 + 3.0 * c3 * x))
        hoop, axial, shear = twice * (hoop - radial), twice * (axial - radial), twice * shear
        for cosine, sine, k in self.fibres:
            around, along = widening * cosine + turn * sine, stretch * sine
            pull = k * (1.0 - 1.0 / np.sqrt(around**2 + along**2))
            hoop, axial, shear = hoop + pull * around**2, axial + pull * along**2, shear + pull * around * along
        return hoop, axial, shear


_REST = np.array([1.0, 1.0, 0.0])


def by_shooting(tube: Tube, pressure: float, steps: int = STEPS) -> Found:
    """Newton on stretch, inner radius and twist from rest; derivatives by complex steps through RK4.

    Raises
    ------
    ValueError
        As for `Wall`.
    """
    wall = Wall(tube, pressure)
    x, previous = _REST, np.inf
    with np.errstate(all="ignore"):
        for iterations in range(1, _MOST_ITERATIONS + 1):
            columns = np.concatenate([x[None], x + 1j * _COMPLEX_STEP * np.eye(3)])
            rows = wall.shot(columns, steps)
            residual, jacobian = rows[0].real, rows[1:].imag.T / _COMPLEX_STEP
            if not (np.isfinite(residual).all() and np.isfinite(jacobian).all()):
                return Found(False, "overflow", iterations=iterations)
            try:
                step = -np.linalg.solve(jacobian, residual)
            except np.linalg.LinAlgError:
                return Found(False, "singular", iterations=iterations)
            size = float(np.abs(step).max())
            x = x + min(1.0, _LARGEST_STEP / size) * step if size > 0.0 else x
            # Quadratic from here on: the step after this one would be of the order of this one's square.
            if size <= 1e-8 and previous <= 1e-3:
                return Found(True, "converged", float(x[0]), iterations, float(np.abs(residual).max()))
            previous = size
    return Found(False, "no convergence", iterations=_MOST_ITERATIONS)


def by_least_squares(tube: Tube, pressure: float, limit: float = 20.0, steps: int = STEPS) -> Found:
    """The same conditions given to `scipy.optimize.least_squares`, with everything at its defaults.

    Raises
    ------
    ModuleNotFoundError
        scipy is missing.
    ValueError
        As for `Wall`.
    """
    from scipy.optimize import least_squares  # type: ignore[import-untyped, unused-ignore]

    wall, deadline = Wall(tube, pressure), time.perf_counter() + limit

    def rows(x: Array) -> Array:
        if time.perf_counter() > deadline:
            raise GaveUp
        return np.nan_to_num(wall.shot(x, steps), nan=1e150, posinf=1e150, neginf=-1e150)

    with np.errstate(all="ignore"):
        try:
            found = least_squares(rows, _REST)
        except GaveUp:
            return Found(False, "gave up")
    residual = float(np.abs(found.fun).max())
    converged = bool(found.success) and residual <= 1e-5  # a minimum of the squares need not be a root
    outcome = "converged" if converged else "no convergence"
    return Found(converged, outcome, float(found.x[0]), int(found.nfev), residual)


def by_collocation(tube: Tube, pressure: float, limit: float = 20.0, tolerance: float = 1e-6) -> Found:
    """`scipy.integrate.solve_bvp`: four functions a layer over its own fraction, stretch and twist as parameters.

    Raises
    ------
    ModuleNotFoundError
        scipy is missing.
    ValueError
        As for `Wall`.
    """
    from scipy.integrate import solve_bvp  # type: ignore[import-untyped, unused-ignore]

    wall, deadline = Wall(tube, pressure), time.perf_counter() + limit
    thickness = np.diff(wall.faces)
    count = len(thickness)

    def rate(x: Array, y: Array, parameters: Array) -> Array:
        if time.perf_counter() > deadline:
            raise GaveUp
        stretch, twist = parameters
        parts = [
            thickness[i] * wall.slope(i, wall.faces[i] + thickness[i] * x, y[4 * i : 4 * i + 4], stretch, twist)
            for i in range(count)
        ]
        return np.concatenate(parts)

    def conditions(inside: Array, outside: Array, _: Array) -> Array:
        full = np.pi * inside[0] ** 2 * wall.pressure
        return np.concatenate(
            [
                [inside[1] + wall.pressure, inside[2], inside[3]],
                outside[:-4] - inside[4:],
                [outside[-3], outside[-2] - full, outside[-1]],
            ]
        )

    x = np.linspace(0.0, 1.0, 5)
    guess = np.zeros((4 * count, x.size))
    for i in range(count):
        at = wall.faces[i] + thickness[i] * x
        guess[4 * i] = at
        guess[4 * i + 1] = -wall.pressure * (wall.faces[-1] - at) / (wall.faces[-1] - wall.faces[0])
    with np.errstate(all="ignore"):
        try:
            found = solve_bvp(rate, conditions, x, guess, p=[1.0, 0.0], tol=tolerance)
        except GaveUp:
            return Found(False, "gave up")
    outcome = "converged" if found.success else "no convergence"
    return Found(bool(found.success), outcome, float(found.p[0]), int(found.niter), float(found.rms_residuals.max()))
