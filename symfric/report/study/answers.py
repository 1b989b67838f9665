"""Answers of a study: values, or the reasons why there are none."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, ParamSpec, TypeVar

import numpy as np

from symfric.errors import NoRoute, NotFound, RunFailed, SceneError
from symfric.time_limit import OutOfTime, time_limit

_Found = TypeVar("_Found", covariant=True)
_Given = ParamSpec("_Given")
_MORE_TIME = "; shorten the horizon, or give it more time with --limit"
EXPECTED = (SceneError, NotFound, NoRoute, RunFailed, NotImplementedError, ArithmeticError, np.linalg.LinAlgError)


@dataclass(frozen=True, eq=False)
class StudyAnswer(Generic[_Found]):
    """Result of one part of a study: a value, or the reason why there is none."""

    value: _Found | None
    note: str = ""

    @property
    def found(self) -> _Found:
        """The value, which must exist."""
        if self.value is None:
            raise LookupError(self.note)
        return self.value


def answer(question: Callable[_Given, _Found], *given: _Given.args, **named: _Given.kwargs) -> StudyAnswer[_Found]:
    """Call a function; an expected exception becomes the reason for a missing value."""
    try:
        return StudyAnswer(question(*given, **named))
    except EXPECTED as error:
        return StudyAnswer(None, str(error) or type(error).__name__)
    except OutOfTime as limit:
        return StudyAnswer(None, f"{limit}{_MORE_TIME}")


def out_of_time(found: StudyAnswer) -> bool:
    """Whether there is no value because its limit of time had passed."""
    return found.value is None and found.note.endswith(_MORE_TIME)


def within(seconds: float, part: Callable[_Given, _Found], *given: _Given.args, **named: _Given.kwargs) -> _Found:
    """Call a function whose answers together have a limit of time."""
    with time_limit(seconds):
        return part(*given, **named)
