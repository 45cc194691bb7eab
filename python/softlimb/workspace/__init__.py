"""Where the tip of a limb gets to.

From pressures to tables: `samples` (pressures that fill a box), `voxels` (how large a cloud is), `hull` (its convex
hull), `explore` (pressures that fill it where it is thin), `edges` (pressures that lead to its edge), `cloud` (the
workspace), `published` (beside the limbs of the literature).
"""

from softlimb.workspace.cloud import ReachableVolume, Regions, Slice, Workspace, workspace
from softlimb.workspace.published import PUBLISHED, PublishedLimb, beside_published
from softlimb.workspace.voxels import Occupancy

__all__ = [
    "PUBLISHED",
    "Occupancy",
    "PublishedLimb",
    "ReachableVolume",
    "Regions",
    "Slice",
    "Workspace",
    "beside_published",
    "workspace",
]
