"""Statics of soft limbs built of fibre-reinforced pneumatic actuators."""

from softlimb import units
from softlimb._core import Gent, MooneyRivlin, NeoHookean, Ogden, Section, Yeoh

__all__ = ["Gent", "MooneyRivlin", "NeoHookean", "Ogden", "Section", "Yeoh", "units"]
