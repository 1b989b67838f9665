"""The protocol of a section: how a part of a study is computed, and what page, data and tables hold of it."""

import csv
import io
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Generic, ParamSpec, TypeVar

import numpy as np
from markupsafe import Markup

from symfric.errors import NoRoute, NotFound, RunFailed, SceneError
from symfric.report.html.words import typeset
from symfric.scenefile import SceneFile, SweepPlan
from symfric.time_limit import OutOfTime

Progress = Callable[[str, float], None]
_Found = TypeVar("_Found", covariant=True)
_Other = TypeVar("_Other")
_Given = ParamSpec("_Given")
_MORE_TIME = "; shorten the horizon, or give it more time with --limit"
EXPECTED = (SceneError, NotFound, NoRoute, RunFailed, NotImplementedError, ArithmeticError, np.linalg.LinAlgError)


@dataclass(frozen=True, eq=False)
class StudyAnswer(Generic[_Found]):
    """Result of one section of a study: a value, or the reason why there is none.

    Attributes
    ----------
    value : object or None
    note : str
        The reason.
    """

    value: _Found | None
    note: str = ""

    @property
    def found(self) -> _Found:
        """The value; `NotFound` is raised with the reason if there is none."""
        if self.value is None:
            raise NotFound(self.note)
        return self.value

    @property
    def out_of_time(self) -> bool:
        """Whether there is no value because its limit of time had passed."""
        return self.value is None and self.note.endswith(_MORE_TIME)


def answer(question: Callable[_Given, _Found], *given: _Given.args, **named: _Given.kwargs) -> StudyAnswer[_Found]:
    """Call a function; an expected exception becomes the reason for a missing value."""
    try:
        return StudyAnswer(question(*given, **named))
    except EXPECTED as error:
        return StudyAnswer(None, str(error) or type(error).__name__)
    except OutOfTime as limit:
        return StudyAnswer(None, f"{limit}{_MORE_TIME}")


def _nothing(*_: Any) -> Any:
    return {}


@dataclass(frozen=True, eq=False)
class Section(Generic[_Found]):
    """One part of a study. The list of sections is the study: page and data show what each of them gives.

    Attributes
    ----------
    name : str
        Attribute of the result under which the answer is found.
    compute : callable ``(study, progress) -> value``
        The study has the answers of the sections before. Exceptions become the reason why there is no value; runs have
        a limit of time.
    topic : str
        Name in the list of what has no answer; "" if it does not stand there.
    asked : callable ``(SceneFile) -> bool``
        Whether the section belongs to the study of a file.
    longer : bool
        Whether its limit of time is that of designs and limit cycles.
    place : int
        Where `page` stands, in increasing order.
    page : callable ``(study) -> iterable of Markup``
    rank : int
        Where `summary` stands, in increasing order.
    summary : callable ``(study, value) -> iterable of str``
        Sentences at the head of the page.
    key : str
        Where `data` stands in study.json, parts separated by points; "" if it does not.
    data : callable ``(study, value) -> object``, optional
        `value.to_dict()` unless given.
    without : object
        Stands there if there is no value.
    tables : callable ``(study, value) -> dict of str to str``
        Files beside the page.
    missing : callable ``(study, value) -> dict of str to str``
        Parts of the value without an answer, with reasons.
    """

    name: str
    compute: Callable[["StudyResult", Progress], _Found]
    topic: str = ""
    asked: Callable[[SceneFile], bool] = lambda _file: True
    longer: bool = False
    place: int = 0
    page: Callable[["StudyResult"], Iterable[Markup]] = _nothing
    rank: int = 0
    summary: Callable[["StudyResult", Any], Iterable[str]] = _nothing
    key: str = ""
    data: Callable[["StudyResult", Any], Any] = lambda _study, value: value.to_dict()
    without: Any = None
    tables: Callable[["StudyResult", Any], Mapping[str, str]] = _nothing
    missing: Callable[["StudyResult", Any], Mapping[str, str]] = _nothing


@dataclass(frozen=True, eq=False)
class StudyResult:
    """All results of a study; the answer of a section is the attribute of its name, as in ``result.motion.value``.

    Attributes
    ----------
    file : SceneFile
    sections : tuple of Section
    answers : dict of str to StudyAnswer
    versions : dict of str to str
    seconds : float
    """

    file: SceneFile
    sections: tuple[Section[Any], ...]
    answers: dict[str, StudyAnswer[Any]]
    versions: Mapping[str, str]
    seconds: float = 0.0

    def __getitem__(self, section: Section[_Other]) -> StudyAnswer[_Other]:
        return self.answers.get(section.name, StudyAnswer(None, f"{section.name} is no part of this study"))

    def __getattr__(self, name: str) -> StudyAnswer[Any]:
        if name in (answers := self.__dict__.get("answers", {})):
            answer: StudyAnswer[Any] = answers[name]
            return answer
        raise AttributeError(f"a study has no section {name!r}; this one has {', '.join(answers)}")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.answers]

    @property
    def asked(self) -> tuple[Section[Any], ...]:
        """The sections that belong to the study of this file."""
        return tuple(section for section in self.sections if section.asked(self.file))

    @property
    def answered(self) -> Iterator[tuple[Section[Any], Any]]:
        """The sections that have a value, with it."""
        return ((section, value) for section in self.asked if (value := self[section].value) is not None)

    @property
    def plan(self) -> SweepPlan:
        """The file's sweep, or a default measurement without one."""
        return self.file.sweep or SweepPlan("", 0.0, 0.0, 0, self.file.coordinate)

    def skipped(self) -> dict[str, str]:
        """Return the parts without a result, with reasons."""
        reasons: dict[str, str] = {}
        for section in self.asked:
            own = self[section]
            if own.value is not None:
                reasons |= section.missing(self, own.value)
            elif section.topic:
                reasons[section.topic] = own.note
        return reasons

    def tables(self) -> dict[str, str]:
        """Return the tables beside the page as CSV, by their file names."""
        return {name: text for section, value in self.answered for name, text in section.tables(self, value).items()}

    def said(self, text: str) -> Markup:
        """Return a sentence on the scene with the names of symbols set as mathematics."""
        scene = self.file.scene
        names = [s.name for s in (*scene.system.states, *scene.system.rows, *scene.parameters)]
        return typeset(text, names, [e for c in scene.contacts for e in c.expressions])


def csv_text(head: Iterable[str], rows: Iterable[Iterable[Any]]) -> str:
    """Return a table as CSV; numbers in full, an empty cell for one that is not finite."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(head)
    writer.writerows([v if isinstance(v, str) else _cell(float(v)) for v in row] for row in rows)
    return stream.getvalue()


def _cell(value: float) -> str:
    return repr(value) if math.isfinite(value) else ""
