"""Statics of soft limbs built of fibre-reinforced pneumatic actuators.

Names are loaded when they are first used, so that importing the package costs a few milliseconds: numpy and the
compiled core come with the first tube, limb or law.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from softlimb import units

if TYPE_CHECKING:
    from softlimb import control, design, identify, materials, measured, plot, presets
    from softlimb._core import Gent, MooneyRivlin, NeoHookean, Ogden, Section, Yeoh
    from softlimb.limb import Limb, Plate, Rod, Segment
    from softlimb.materials import fit_uniaxial, read_tensile_csv
    from softlimb.path import Path, PathEvent
    from softlimb.payload import Payload, PayloadRose, payload_rose
    from softlimb.posture import Posture, RodPosture, Verification
    from softlimb.reach import Reach
    from softlimb.scenes import Scene, load_scene
    from softlimb.sense import Sensed
    from softlimb.sweep import Batch
    from softlimb.tube import Fibres, Layer, Tube, TubeState
    from softlimb.workspace import Workspace

__all__ = [
    "Batch",
    "Fibres",
    "Gent",
    "Layer",
    "Limb",
    "MooneyRivlin",
    "NeoHookean",
    "Ogden",
    "Path",
    "PathEvent",
    "Payload",
    "PayloadRose",
    "Plate",
    "Posture",
    "Reach",
    "Rod",
    "RodPosture",
    "Scene",
    "Section",
    "Segment",
    "Sensed",
    "Tube",
    "TubeState",
    "Verification",
    "Workspace",
    "Yeoh",
    "control",
    "design",
    "fit_uniaxial",
    "identify",
    "load_scene",
    "materials",
    "measured",
    "payload_rose",
    "plot",
    "presets",
    "read_tensile_csv",
    "units",
]

_MODULES = ("control", "design", "identify", "materials", "measured", "plot", "presets")
_HOME = {
    "_core": ("Gent", "MooneyRivlin", "NeoHookean", "Ogden", "Section", "Yeoh"),
    "limb": ("Limb", "Plate", "Rod", "Segment"),
    "materials": ("fit_uniaxial", "read_tensile_csv"),
    "path": ("Path", "PathEvent"),
    "payload": ("Payload", "PayloadRose", "payload_rose"),
    "posture": ("Posture", "RodPosture", "Verification"),
    "reach": ("Reach",),
    "scenes": ("Scene", "load_scene"),
    "sense": ("Sensed",),
    "sweep": ("Batch",),
    "tube": ("Fibres", "Layer", "Tube", "TubeState"),
    "workspace": ("Workspace",),
}


def __getattr__(name: str) -> object:
    if name in _MODULES:
        return import_module(f"softlimb.{name}")
    for module, names in _HOME.items():
        if name in names:
            found: object = getattr(import_module(f"softlimb.{module}"), name)
            globals()[name] = found
            return found
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
