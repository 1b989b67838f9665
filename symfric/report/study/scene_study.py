"""The study of a scene from Python: its results, its page, its files."""

from dataclasses import dataclass
from pathlib import Path

from symfric.files import write_together
from symfric.model.scene import Scene
from symfric.report.study.data import data_files, json_text, to_dict
from symfric.report.study.narrative import summary
from symfric.report.study.page import page
from symfric.report.study.study import Progress, StudyResult, study
from symfric.scenefile import file_of


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

    def to_dict(self) -> dict:
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
        files = {"study.html": page(self.result), **data_files(self.result), "study.json": json_text(self.to_dict())}
        write_together({place / name: text for name, text in files.items()})
        return place / "study.html"

    def _repr_html_(self) -> str:
        return self.html()

    def __repr__(self) -> str:
        return "\n".join(["Study:", *(f"  {line}" for line in summary(self.result))])


def study_of(scene: Scene, progress: Progress | None = None) -> Study:
    """Return the study of a scene, with what its file asks for if it was read from one."""
    return Study(study(file_of(scene), progress))
