"""Twelve scenes: a tube, one rod, one segment, a limb; each mild, stiff, and extreme.

Mild is what every method should manage. Stiff scenes put very different stiffnesses or strong forces side by side.
Extreme ones lie where methods break: at a limit point, under tension that disturbances grow in, far from the straight
start. Each posture asked for was the only stable one that solves from dozens of random starts met.
"""

from __future__ import annotations

import numpy as np

from softlimb import materials, presets
from softlimb.bench import limbs, others
from softlimb.limb import Limb, Rod
from softlimb.report.limbs import LimbScene
from softlimb.report.methods import Scene
from softlimb.report.tubes import TubeScene
from softlimb.scenes import load_scene
from softlimb.tube import Fibres, Layer, Tube
from softlimb.units import deg, kPa, mm

__all__ = ["SCENES"]

_LENGTH = 200 * mm


def _actuator() -> Tube:
    return presets.reference_limb(["proximal"]).segments[0].actuators[0]


def _unequal() -> Tube:
    """Two families that do not mirror each other, a thousand times stiffer than the silicone."""
    fibres = [Fibres(angle=20 * deg, stiffness=2.5e8), Fibres(angle=-35 * deg, stiffness=1e8)]
    core = Layer(18 * mm, 20.5 * mm, materials.DRAGON_SKIN_30)
    return Tube(_LENGTH, [core, Layer(20.5 * mm, 21.5 * mm, materials.SMOOTHSIL_950, fibres=fibres)])


def _bare() -> Tube:
    return Tube(_LENGTH, [Layer(18 * mm, 21.5 * mm, materials.SMOOTHSIL_950)])


def _wire() -> Limb:
    return limbs.clamped(Rod(limbs.HEAVY_STEEL, limbs.LEG))


# By which a disturbance of the wire's base grows along it: e^20. The pull is a stress of 125 MPa, steel bears more.
_GROWTH = 20.0
_PULL = float(limbs.STEEL.bending * (_GROWTH / limbs.LEG) ** 2)
_COMPLEX = load_scene("complex-posture")


def _benchmarked(name: str, other: str) -> LimbScene:
    """A scene on which `softlimb bench` compares methods, too."""
    scene = next(scene for scene in others.SCENES if scene.name == other)
    return LimbScene(name, scene.what, scene.limb, scene.options)


SCENES: tuple[Scene, ...] = (
    TubeScene("tube-mild", "one actuator of the reference limb, 30 kPa", _actuator, 30.0 * kPa),
    TubeScene(
        "tube-stiff", "tube that twists: fibres at 20 and -35 deg, 300 kPa", _unequal, 300.0 * kPa
    ),
    TubeScene("tube-extreme", "bare silicone, 0.1 % below ballooning", _bare, 90.5 * kPa),
    _benchmarked("cantilever-mild", "other-rod"),
    LimbScene(
        "cantilever-stiff",
        "one steel wire, 0.4 m long and 2 mm thick, force across",
        _wire,
        {"gravity": limbs.HANGING, "tip_force": (2.0, 1.0, 0.0)},
    ),
    LimbScene(
        "cantilever-extreme",
        f"one steel wire, pulled across by {_PULL:.0f} N",
        _wire,
        {"gravity": limbs.HANGING, "tip_force": (_PULL, 0.0, 0.0)},
    ),
    _benchmarked("segment-mild", "other-segment"),
    LimbScene(
        "segment-stiff",
        "six clamped steel legs (Stewart-Gough), two of them longer",
        lambda: limbs.six_legs(limbs.LEG + np.array([0.0, 5.0, 0.0, 0.0, 5.0, 0.0]) * mm, limbs.HEAVY_STEEL),
        {"gravity": limbs.HANGING, "tip_force": (1.0, 0.5, -5.0)},
    ),
    LimbScene(
        "segment-extreme",
        "one segment of 3 thin rods, 30 kPa, 5 N across",
        lambda: presets.reference_limb(["distal"]),
        {"pressures": np.full(3, 30.0 * kPa), "tip_force": (5.0, 1.0, 0.0)},
    ),
    LimbScene(
        "limb-mild",
        "limb of 9 rods, pressures nearly equal, no weight, small force",
        presets.reference_limb,
        {
            "pressures": np.array([30.0, 28.0, 26.0, 24.0, 26.0, 28.0, 30.0, 28.0, 29.0]) * kPa,
            "tip_force": (0.05, -0.03, 0.02),
        },
    ),
    LimbScene(
        "limb-stiff",
        "limb of 9 rods in the paper's complex posture, hanging",
        lambda: _COMPLEX.limb,
        {"pressures": _COMPLEX.pressures, "gravity": _COMPLEX.gravity},
    ),
    LimbScene(
        "limb-extreme",
        "limb of 9 rods, 90 kPa on one side, standing, force across",
        presets.reference_limb,
        {
            "pressures": np.array([90.0, 0.0, 0.0] * 3) * kPa,
            "gravity": (0.0, 0.0, -limbs.HANGING[2]),
            "tip_force": (0.5, 0.5, 0.0),
        },
    ),
)
"""In the order of the page."""
