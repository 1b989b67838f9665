"""Scene files: TOML to `Scene`. Expressions are parsed with a whitelist; nothing in a file is executed."""

from symfric.model.belts import belt_speeds
from symfric.scenefile.build import ready_scenes
from symfric.scenefile.identification import IdentificationPlan
from symfric.scenefile.laws import LawSpec, friction_laws
from symfric.scenefile.read import SceneFile, SweepPlan, file_of, read_scene_file, read_scene_text
from symfric.scenefile.structure import StructurePlan

__all__ = [
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
