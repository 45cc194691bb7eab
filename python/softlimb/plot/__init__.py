"""Pictures. Every function returns a figure, or draws into the axes it is given, and leaves no global state behind."""

from softlimb.plot.curves import comparison, curve, positions, sweep
from softlimb.plot.limb import limb, side_view

__all__ = ["comparison", "curve", "limb", "positions", "side_view", "sweep"]
