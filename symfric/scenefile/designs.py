"""Designs of a scene file: the tables of ``[design]``, checked against the scene."""

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symfric.errors import SceneError
from symfric.model.scene import Scene
from symfric.model.symbols import nearest, shorten
from symfric.scenefile.expressions import parse_expression
from symfric.scenefile.motions import read_motion
from symfric.scenefile.sections import checked

if TYPE_CHECKING:
    from symfric.design.plan import DesignPlan


def read_designs(
    tables: Mapping[str, Any], scene: Scene, model: str | None, folder: Path | None
) -> tuple["DesignPlan", ...]:
    """Return the designs of a file, with ranges and names checked against the scene.

    Parameters
    ----------
    tables : mapping of str
        The section ``[design]``, a table for each design.
    scene : Scene
    model : str or None
        Name of the ready scene.
    folder : Path or None
        Folder relative to which records are found.

    Returns
    -------
    tuple of DesignPlan
    """
    if not tables:
        return ()
    from symfric.design.plan import TableReader  # slow to import, and most files have no design
    from symfric.design.plans import PLANS

    known = [plan.kind for plan in PLANS]
    for kind in tables:
        if kind not in known:
            raise SceneError(f"[design] has no key {shorten(kind, 40)!r}{nearest(kind, known)}")
    names = {s.name: s for s in (*scene.system.states, *scene.parameters)}
    expression, motion = lambda text, at: parse_expression(text, names, at), partial(read_motion, folder=folder)
    plans = []
    for asked in PLANS:
        if asked.kind in tables:
            place = f"design.{asked.kind}"
            plan = checked(asked, tables[asked.kind], place)
            if plan.models and model not in plan.models:
                mine = model or "equations of its own"
                raise SceneError(f"[{place}] takes the ready scene {' or '.join(plan.models)}; this file has {mine}")
            plans.append(plan.read(TableReader(place, scene, model, expression, motion)))
    return tuple(plans)
