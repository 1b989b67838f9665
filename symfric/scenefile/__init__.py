"""Scene files: TOML to `Scene`. Expressions are parsed with a whitelist; nothing in a file is executed."""

from symfric.scenefile.build import LawSpec, friction_laws, ready_scenes
from symfric.scenefile.designs import DesignPlan
from symfric.scenefile.identification import IdentificationPlan
from symfric.scenefile.read import SceneFile, SweepPlan, belt_speeds, read_scene_file, read_scene_text

__all__ = [
    "DesignPlan",
    "IdentificationPlan",
    "LawSpec",
    "SceneFile",
    "SweepPlan",
    "belt_speeds",
    "friction_laws",
    "read_scene_file",
    "read_scene_text",
    "ready_scenes",
]
