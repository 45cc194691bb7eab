"""Statics of soft limbs built of fibre-reinforced pneumatic actuators."""

from softlimb import units
from softlimb._core import Gent, MooneyRivlin, NeoHookean, Ogden, Section, Yeoh
from softlimb.tube import Fibres, Layer, Tube, TubeState

__all__ = ["Fibres", "Gent", "Layer", "MooneyRivlin", "NeoHookean", "Ogden", "Section", "Tube", "TubeState", "Yeoh", "units"]
