"""Which observables the outputs of a scene need."""

from symfric.model.outputs import OutputOfExpression
from symfric.model.scene import Scene
from symfric.solve.observables import Observables


def observables_of(scene: Scene) -> Observables:
    """Return the observables of the outputs of a scene."""
    outputs = scene.outputs
    row = {n: o.row(scene.horizon) for n, o in outputs.items() if isinstance(o, OutputOfExpression)}
    rows = tuple(dict.fromkeys(row.values()))
    path = any(o.keeps_path for o in outputs.values())
    events = any(o.keeps_events for o in outputs.values())
    return Observables(rows, {n: rows.index(r) for n, r in row.items()}, path, events)
