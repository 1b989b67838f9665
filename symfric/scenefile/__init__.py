"""Scene files: TOML to `Scene`. Expressions are parsed with a whitelist; nothing in a file is executed."""

from symfric.scenefile.build import ready_scenes
from symfric.scenefile.designs import DesignPlan
from symfric.scenefile.friction import LawSpec, friction_laws
from symfric.scenefile.identification import IdentificationPlan
from symfric.scenefile.read import SceneFile, SweepPlan, belt_speeds, file_of, read_scene_file, read_scene_text
from symfric.scenefile.structure import StructurePlan

__all__ = [
    "DesignPlan",
    "IdentificationPlan",
    "LawSpec",
    "SceneFile",
    "StructurePlan",
    "SweepPlan",
    "belt_speeds",
    "file_of",
    "friction_laws",
    "read_scene_file",
    "read_scene_text",
    "ready_scenes",
]
