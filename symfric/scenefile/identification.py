"""The section ``[identify]`` of a scene file: a record and the unknowns that shall fit it."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.identification.loss import LOSSES
from symfric.model.scene import Scene
from symfric.model.symbols import TIME, nearest, shorten
from symfric.scenefile.arguments import as_expr
from symfric.scenefile.schema import Identify

if TYPE_CHECKING:
    from symfric.identification.fit import Fit


@dataclass(frozen=True)
class IdentificationPlan:
    """A fit to compute.

    Attributes
    ----------
    record : Path
        A .csv, .txt or .npy file; the first column is time.
    unknowns : mapping of name to (low, high)
    observed : mapping of column to Expr
        What columns measure that are no states.
    sigma : float, mapping of column to float, or None
    starts, seed : int
    loss : str
    """

    record: Path
    unknowns: Mapping[str, tuple[float, float]]
    observed: Mapping[str, sp.Expr]
    sigma: Any
    starts: int
    seed: int
    loss: Any  # a name in LOSSES

    def records(self, scene: Scene) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Return the columns of the record that measure something; the others are left out.

        Raises
        ------
        SceneError
            If the file cannot be read, or none of its columns is a state or observed.
        """
        from symfric.identification.tables import read_table

        columns = read_table(self.record)
        known = {s.name for s in scene.system.states} | set(self.observed)
        missing = next((n for n in self.observed if n not in columns), None)
        if missing is not None:
            raise SceneError(f"identify.observed names {missing}, which is no column of {self.record.name}")
        measured = {n: r for n, r in columns.items() if n in known}
        if not measured:
            shown = ", ".join(s.name for s in scene.system.states[:6])
            raise SceneError(
                f"no column of {self.record.name} is a state ({shown}); say what they are in [identify.observed]"
            )
        return measured

    def __call__(self, scene: Scene) -> "Fit":
        """Compute the fit; raises the exceptions of `symfric.identification.identify.identify`."""
        from symfric.identification.identify import identify

        records = self.records(scene)
        observed = {n: e for n, e in self.observed.items() if n in records}
        return identify(
            scene, records, self.unknowns, observed, self.sigma, self.starts, seed=self.seed, loss=self.loss
        )


def read_identification(section: Identify, scene: Scene, folder: Path | None) -> IdentificationPlan:
    """Return the plan of a section.

    Parameters
    ----------
    section : Identify
    scene : Scene
    folder : Path or None
        Folder of the scene file, relative to which the record is found; None if there is no file.
    """
    if folder is None:
        raise SceneError("identify.record: its path is relative to a scene file; this scene was given as text")
    for name, (low, high) in section.unknowns.items():
        if not low < high:
            raise SceneError(f"identify.unknowns.{shorten(name, 40)} is [{low:g}, {high:g}]; write [smallest, largest]")
    names = {s.name: s for s in (*scene.system.states, *scene.parameters)} | {TIME.name: TIME}
    contacts = [c.name for c in scene.contacts]
    observed = {
        name: as_expr(e, f"identify.observed.{shorten(name, 40)}", names, contacts)
        for name, e in section.observed.items()
    }
    if section.loss not in LOSSES:
        raise SceneError(f"identify.loss is {shorten(section.loss, 20)!r}{nearest(section.loss, LOSSES)}")
    unknowns = {n: (low, high) for n, (low, high) in section.unknowns.items()}
    return IdentificationPlan(
        folder / section.record, unknowns, observed, section.sigma, section.starts, section.seed, section.loss
    )
