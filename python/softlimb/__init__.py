"""Statics of soft limbs built of fibre-reinforced pneumatic actuators."""

from softlimb import units
from softlimb._core import Section

__all__ = ["Section", "units"]
