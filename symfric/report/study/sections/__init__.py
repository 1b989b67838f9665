"""The sections of a study. Each is one file: functions for what it computes and shows, and a `Section` that names them.

A new section is such a file, and an entry of the list below; ``study(file, sections=(*SECTIONS, own))`` takes one from
anywhere else.
"""

from typing import Any

from symfric.report.study.section import Section
from symfric.report.study.sections.branch import BRANCH
from symfric.report.study.sections.comparison import COMPARISON
from symfric.report.study.sections.contacts import CONTACTS
from symfric.report.study.sections.designs import DESIGNS, NO_DESIGN
from symfric.report.study.sections.flutter import FLUTTER, OPENED
from symfric.report.study.sections.friction import EFFECTIVE, FRICTION
from symfric.report.study.sections.how import EXPLANATION
from symfric.report.study.sections.matrices import MATRICES
from symfric.report.study.sections.modes import MODES
from symfric.report.study.sections.motion import MOTION, OUTPUTS, STEADY
from symfric.report.study.sections.onset import HOPF, SAFE
from symfric.report.study.sections.openings import OPENINGS
from symfric.report.study.sections.prediction import CURVES
from symfric.report.study.sections.quench import QUENCH
from symfric.report.study.sections.scene import SCENE
from symfric.report.study.sections.stability import EQUILIBRIUM, SLOW, STABILITY
from symfric.report.study.sections.sweep import QUENCHED, SWEEP

SECTIONS: tuple[Section[Any], ...] = (  # in the order of computing: each finds the answers of those before it
    *(SCENE, MATRICES, SLOW, EQUILIBRIUM, STABILITY, HOPF, SAFE, MOTION, CONTACTS, OPENINGS, OUTPUTS, STEADY, SWEEP),
    *(OPENED, MODES, FLUTTER, BRANCH, DESIGNS, QUENCH, QUENCHED, CURVES, COMPARISON, FRICTION, EFFECTIVE),
    *(NO_DESIGN, EXPLANATION),
)
