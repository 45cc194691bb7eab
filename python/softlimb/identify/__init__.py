"""Identification: numbers of an actuator or a limb from measurements, with confidence, and what cannot be known.

`identify` does it for what the package models, `least_squares` for any model with derivatives, `tip_uncertainty`
carries the standard errors of fitted laws to the tip of a posture.
"""

from softlimb.identify.actuators import EmpiricalActuator, ScaledTube
from softlimb.identify.carried import TipUncertainty, tip_uncertainty
from softlimb.identify.driven import DrivenLimb, DrivenSegment
from softlimb.identify.identify import identify
from softlimb.identify.least_squares import Block, Identified, Profile, least_squares
from softlimb.identify.observations import ActuatorCurve, LimbCurve, Points, TipPoses

__all__ = [
    "ActuatorCurve",
    "Block",
    "DrivenLimb",
    "DrivenSegment",
    "EmpiricalActuator",
    "Identified",
    "LimbCurve",
    "Points",
    "Profile",
    "ScaledTube",
    "TipPoses",
    "TipUncertainty",
    "identify",
    "least_squares",
    "tip_uncertainty",
]
