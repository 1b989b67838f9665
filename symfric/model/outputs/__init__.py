"""Outputs of a scene: only those listed are computed and stored.

A new output is a class in the file of its kind here, and a public name.
"""

from collections.abc import Mapping, Sequence

from symfric.errors import SceneError
from symfric.model.outputs.extremes import HalfRange, Max, Min
from symfric.model.outputs.integrals import RMS, Integral, Mean
from symfric.model.outputs.of_contacts import (
    OF_CONTACTS,
    dissipated_power,
    friction_force,
    normal_force,
    slip,
    stored_energy,
)
from symfric.model.outputs.output import Output, OutputAfter, OutputOfExpression
from symfric.model.outputs.records import Events, Trajectory
from symfric.model.outputs.times import Period, StopTime
from symfric.model.outputs.values import At, End, Samples
from symfric.model.symbols import legible, shortened

__all__ = [
    "OF_CONTACTS",
    "RMS",
    "At",
    "End",
    "Events",
    "HalfRange",
    "Integral",
    "Max",
    "Mean",
    "Min",
    "Output",
    "OutputAfter",
    "OutputOfExpression",
    "Period",
    "Samples",
    "StopTime",
    "Trajectory",
    "dissipated_power",
    "friction_force",
    "normal_force",
    "read_outputs",
    "slip",
    "stored_energy",
    "words",
]


def words(of: type[Output] = Output) -> dict[str, type[Output]]:
    """Return the output classes by their names in scene files."""
    classes: dict[str, type[Output]] = {}
    kinds: Sequence[type[Output]] = of.__subclasses__()
    for kind in kinds:
        classes |= {kind.word: kind} if kind.word else {}
        classes |= words(kind)
    return classes


def read_outputs(outputs: Mapping[str, Output] | None) -> dict[str, Output]:
    """Return the outputs of a scene, the trajectory unless any are given; raise on what is none."""
    if outputs is None:
        return {"path": Trajectory()}
    if not isinstance(outputs, Mapping):
        raise SceneError(f"outputs is {shortened(outputs)}; give a mapping of names to sf.End(), sf.Max(x), ...")
    for name, output in outputs.items():
        if not isinstance(name, str):
            raise SceneError(f"{name!r} is not the name of an output; use a string")
        legible(name, "an output")
        if not isinstance(output, Output):
            raise SceneError(f"output {name!r} is {output!r}; use sf.End(), sf.Max(x), ... with its brackets")
    return dict(outputs)
