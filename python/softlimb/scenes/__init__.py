"""Scenes and limbs as TOML documents; beside this file the paper's experiments as scenes."""

from softlimb.scenes.limb_file import limb_from_dict, limb_to_dict, read_limb, write_limb
from softlimb.scenes.ranges import Axis
from softlimb.scenes.scene import Scene, available_scenes, load_scene

__all__ = [
    "Axis",
    "Scene",
    "available_scenes",
    "limb_from_dict",
    "limb_to_dict",
    "load_scene",
    "read_limb",
    "write_limb",
]
