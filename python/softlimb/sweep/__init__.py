"""Many postures of one limb under one scene.

From what a row is to who works on it: `row_table` (columns), `record` (what a sweep is of), `file_layout`,
`message_blocks` and `sweep_file` (a sweep on the disk), `batch` (what users get), `chunks` (workers elsewhere), `run`
(the sweep). The solver is `softlimb.rows.solve_rows`.
"""

from softlimb.rows import INVALID, NOT_RUN
from softlimb.sweep.batch import Batch, file_path, scene_text
from softlimb.sweep.pose_angles import bending_angle, rotation_matrix, rotation_vector
from softlimb.sweep.run import sweep

__all__ = [
    "INVALID",
    "NOT_RUN",
    "Batch",
    "bending_angle",
    "file_path",
    "rotation_matrix",
    "rotation_vector",
    "scene_text",
    "sweep",
]
