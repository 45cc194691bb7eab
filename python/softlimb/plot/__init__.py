"""Pictures. Every function returns a figure, or draws into the axes it is given, and leaves no global state behind."""

from softlimb.plot.curves import comparison, curve, positions, sweep
from softlimb.plot.design import radius_ratio
from softlimb.plot.limb import limb, side_view
from softlimb.plot.material import draw_fit
from softlimb.plot.path import path
from softlimb.plot.reach import reach
from softlimb.plot.tube import ballooning, elongation, stiffness, wall_stress
from softlimb.plot.validation import profile, validation
from softlimb.plot.workspace import payload_rose, settling, workspace

__all__ = [
    "ballooning",
    "comparison",
    "curve",
    "draw_fit",
    "elongation",
    "limb",
    "path",
    "payload_rose",
    "positions",
    "profile",
    "radius_ratio",
    "reach",
    "settling",
    "side_view",
    "stiffness",
    "sweep",
    "validation",
    "wall_stress",
    "workspace",
]
