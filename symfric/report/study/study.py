"""Compute the study of a scene file, section by section; drawing and writing use its result alone."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from symfric.files import write_together
from symfric.long_calls import long_call, tell
from symfric.model.scene import Scene
from symfric.report.html.versions import versions
from symfric.report.study.data import data_files, to_dict
from symfric.report.study.page import page, summary
from symfric.report.study.section import Progress, Section, StudyResult, answer
from symfric.report.study.sections import SECTIONS
from symfric.report.study.sections.motion import MOTION
from symfric.scenefile import SceneFile, file_of
from symfric.time_limit import time_limit

LIMIT = 20.0  # longest time for one part, s
LONGER = 10  # factor of that time for designs and limit cycles


def study(
    file: SceneFile,
    progress: Progress | None = None,
    limit: float = LIMIT,
    sections: Sequence[Section[Any]] = SECTIONS,
) -> StudyResult:
    """Compute the study of a scene file.

    Parameters
    ----------
    file : SceneFile
    progress : callable ``(stage, fraction) -> None``, optional
    limit : float
        Longest time for the runs of one part, s; designs and limit cycles may take ten times as long. What takes longer
        is left out, with this reason; what builds on it is not tried.
    sections : sequence of Section, optional
        Each finds the answers of those before it.

    Returns
    -------
    StudyResult
        A part without a value holds the reason; no exception is raised.
    """
    started, tell = time.monotonic(), progress or (lambda _stage, _fraction: None)
    result = StudyResult(file, tuple(sections), {}, versions())
    for section in result.asked:
        # where the motion itself took too long, what takes longer still is not given more time
        longer = section.longer and not result[MOTION].out_of_time
        with time_limit(LONGER * limit if longer else limit):
            result.answers[section.name] = answer(section.compute, result, tell)
    return replace(result, seconds=time.monotonic() - started)


@dataclass(frozen=True, eq=False, repr=False)
class Study:
    """The study of a scene; see `Scene.study`.

    Attributes
    ----------
    result : StudyResult
        All results; a part without a value holds the reason.

    Examples
    --------
    >>> import symfric as sf
    >>> found = sf.scenes.coulomb_oscillator(0.1).study()
    >>> found.result.motion.value.status
    'OK'
    """

    result: StudyResult

    def to_dict(self) -> dict[str, Any]:
        """Return plain data, as in study.json.

        Returns
        -------
        dict
        """
        return to_dict(self.result)

    def html(self) -> str:
        """Return the page.

        Returns
        -------
        str
        """
        return page(self.result)

    def files(self) -> dict[str, str]:
        """Return the page and the data beside it.

        Returns
        -------
        dict of str to str
            Texts by names of files.
        """
        return {"study.html": self.html(), **data_files(self.result)}

    def write(self, folder: str | Path) -> Path:
        """Write the page and the data beside it.

        Parameters
        ----------
        folder : str or Path
            Made if it does not exist.

        Returns
        -------
        Path
            Of the page.
        """
        place = Path(folder)
        place.mkdir(parents=True, exist_ok=True)
        write_together({place / name: text for name, text in self.files().items()})
        return place / "study.html"

    def _repr_html_(self) -> str:
        return self.html()

    def __repr__(self) -> str:
        return "\n".join(["Study:", *(f"  {line}" for line in summary(self.result))])


def study_of(scene: Scene, progress: Progress | None = None) -> Study:
    """Return the study of a scene, with what its file asks for if it was read from one."""
    with long_call("study"):
        return Study(study(file_of(scene), progress or tell))
