"""Pictures. Every function returns a figure (or draws into the axes it is given) and leaves no global state behind."""

from softlimb.plot.limb import limb, side_view

__all__ = ["limb", "side_view"]
