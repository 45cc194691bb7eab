"""Statics of soft limbs built of fibre-reinforced pneumatic actuators."""

from typing import TYPE_CHECKING

from softlimb import materials, presets, units
from softlimb._core import Gent, MooneyRivlin, NeoHookean, Ogden, Section, Yeoh
from softlimb.limb import Limb, Plate, Posture, Rod, RodPosture, Segment, Verification
from softlimb.scenes import Scene, load_scene
from softlimb.tube import Fibres, Layer, Tube, TubeState

if TYPE_CHECKING:
    from softlimb.materials import fit_uniaxial, read_tensile_csv

__all__ = [
    "Fibres",
    "Gent",
    "Layer",
    "Limb",
    "MooneyRivlin",
    "NeoHookean",
    "Ogden",
    "Plate",
    "Posture",
    "Rod",
    "RodPosture",
    "Scene",
    "Section",
    "Segment",
    "Tube",
    "TubeState",
    "Verification",
    "Yeoh",
    "fit_uniaxial",
    "load_scene",
    "materials",
    "presets",
    "read_tensile_csv",
    "units",
]


def __getattr__(name: str) -> object:
    if name in ("fit_uniaxial", "read_tensile_csv"):  # loaded when first asked for, see softlimb.materials
        return getattr(materials, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
