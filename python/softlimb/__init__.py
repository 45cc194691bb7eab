"""Statics of soft limbs built of fibre-reinforced pneumatic actuators."""

from softlimb import presets, units
from softlimb._core import Gent, MooneyRivlin, NeoHookean, Ogden, Section, Yeoh
from softlimb.limb import Limb, Plate, Posture, Rod, RodPosture, Segment, Verification
from softlimb.scenes import Scene, load_scene
from softlimb.tube import Fibres, Layer, Tube, TubeState

__all__ = [
    "Limb",
    "Plate",
    "Posture",
    "Rod",
    "RodPosture",
    "Segment",
    "Verification",
    "Fibres",
    "Gent",
    "Layer",
    "MooneyRivlin",
    "NeoHookean",
    "Ogden",
    "Scene",
    "Section",
    "Tube",
    "TubeState",
    "Yeoh",
    "load_scene",
    "presets",
    "units",
]
