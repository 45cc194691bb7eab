"""Tubes that several test files use, and a second, independent solution of the thick tube."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import root

import softlimb as sl
from softlimb.units import deg, kPa

DRAGON_SKIN = sl.Yeoh(c1=86.1 * kPa, c2=13.6 * kPa)
SMOOTHSIL = sl.NeoHookean(c1=340 * kPa)
MODULUS = 31.067e9
RULE = np.polynomial.legendre.leggauss(30)  # in the deformed radius: exact to rounding for walls of any thickness


def reference_file(shared: Path) -> dict[str, Any]:
    return json.loads((shared / "reference" / "fra_tubes.json").read_text())


def tube_of(case: dict[str, Any], **options: Any) -> sl.Tube:
    layers = []
    for layer in case["layers"]:
        c = layer["yeoh_c"]
        law = sl.NeoHookean(c1=c[0]) if len(c) == 1 else sl.Yeoh(c1=c[0], c2=c[1])
        fibres = [
            sl.Fibres(angle=f["alpha_deg_from_circumferential"] * deg, stiffness=f["k"]) for f in layer["fibres"]
        ]
        layers.append(sl.Layer(layer["R_in"], layer["R_out"], law, fibres=fibres))
    return sl.Tube(0.2, layers, tension_only=case["fibres_tension_only"], **options)


def proximal(**options: Any) -> sl.Tube:
    """The proximal actuator of the reference limb."""
    pair = sl.Fibres.pair(angle=1.33 * deg, modulus=MODULUS, fraction=0.0083)
    layers = [sl.Layer(0.018, 0.0205, DRAGON_SKIN), sl.Layer(0.0205, 0.0215, SMOOTHSIL, fibres=pair)]
    return sl.Tube(0.2, layers, **options)


def unequal(**options: Any) -> sl.Tube:
    """Two families that do not mirror each other: the tube twists."""
    fibres = [sl.Fibres(angle=20 * deg, stiffness=2.5e8), sl.Fibres(angle=-35 * deg, stiffness=1e8)]
    layers = [sl.Layer(0.018, 0.0205, DRAGON_SKIN), sl.Layer(0.0205, 0.0215, SMOOTHSIL, fibres=fibres)]
    return sl.Tube(0.2, layers, **options)


def plain(law: Any = SMOOTHSIL, radii: tuple[float, float] = (0.018, 0.0215), **options: Any) -> sl.Tube:
    return sl.Tube(0.2, [sl.Layer(*radii, law)], **options)


def independent_state(
    tube: sl.Tube, pressure: float, force: float, torque: float, start: tuple[float, float, float]
) -> tuple[float, float, float]:
    """(stretch, inner radius, twist) from radial equilibrium of the Cauchy stress, by quadrature and root finding.

    Shares nothing with the package's solution, which minimises an energy: here the stresses of Yeoh or neo-Hookean
    silicone and of the fibres are integrated over the deformed wall, and the pressure difference, the net axial force
    and the torque are matched. Layers by themselves, split where a tension-only fibre goes slack.
    """
    inner = tube.inner_radius

    def unbalance(x: np.ndarray) -> list[float]:
        stretch, r_i, twist = x[0], x[1] * inner, x[2] / inner

        def reference(r: float) -> float:
            return float(np.sqrt(inner**2 + stretch * (r**2 - r_i**2)))

        def extra(layer: sl.Layer, r: float) -> tuple[float, float, float]:
            """Hoop and axial stress less the radial, and the shear."""
            big_r = reference(r)
            f = np.array([[r / big_r, r * twist], [0.0, stretch]])
            b = f @ f.T
            radial = 1.0 / np.linalg.det(f) ** 2
            c = [layer.law.c1, getattr(layer.law, "c2", 0.0), getattr(layer.law, "c3", 0.0)]
            i1 = np.trace(b) + radial - 3.0
            slope = layer.silicone_fraction * (c[0] + 2 * c[1] * i1 + 3 * c[2] * i1**2)
            sigma = 2.0 * slope * (b - radial * np.eye(2))
            for family in layer.fibres:
                a = f @ np.array([np.cos(family.angle), np.sin(family.angle)])
                length = np.linalg.norm(a)
                if length > 1.0 or not tube.tension_only:
                    sigma = sigma + family.stiffness * (1.0 - 1.0 / length) * np.outer(a, a)
            return sigma[0, 0], sigma[1, 1], sigma[0, 1]

        p = f_net = m = 0.0
        for layer in tube.layers:
            a, b = (np.sqrt(r_i**2 + (radius**2 - inner**2) / stretch) for radius in (layer.inner, layer.outer))
            cuts = [a, b]
            if tube.tension_only:
                fine = np.linspace(a, b, 200)
                for family in layer.fibres:
                    def excess(r: float, angle: float = family.angle) -> float:
                        around = r * np.cos(angle) / reference(r) + r * twist * np.sin(angle)
                        return float(np.hypot(around, stretch * np.sin(angle)) - 1.0)

                    values = np.array([excess(r) for r in fine])
                    for k in np.flatnonzero(values[1:] * values[:-1] < 0.0):
                        low, high = fine[k], fine[k + 1]
                        for _ in range(60):
                            middle = 0.5 * (low + high)
                            low, high = (middle, high) if excess(middle) * excess(low) > 0 else (low, middle)
                        cuts.append(low)
            cuts.sort()
            for low, high in pairwise(cuts):
                def integrate(g: Any, low: float = low, high: float = high) -> float:
                    middle, half = 0.5 * (low + high), 0.5 * (high - low)
                    return float(sum(half * w * g(middle + half * x) for x, w in zip(*RULE, strict=True)))
                p += integrate(lambda r, layer=layer: extra(layer, r)[0] / r)
                # Closed ends: the axial force in the wall less pi r_i^2 P equals, by radial equilibrium, this integral.
                f_net += integrate(lambda r, layer=layer: np.pi * r * (2.0 * extra(layer, r)[1] - extra(layer, r)[0]))
                m += integrate(lambda r, layer=layer: 2.0 * np.pi * r**2 * extra(layer, r)[2])
        scale = np.pi * inner**2
        return [p - pressure, f_net / scale - force / scale, m / (scale * inner) - torque / (scale * inner)]

    x0 = np.array([start[0], start[1] / inner, start[2] * inner])
    solution = root(unbalance, x0, method="hybr", options={"xtol": 1e-13})
    return float(solution.x[0]), float(solution.x[1] * inner), float(solution.x[2] / inner)
