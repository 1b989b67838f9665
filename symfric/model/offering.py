"""The door of a package: its public names alone, hints on misspelled names and arguments, a log of long calls."""

import functools
import inspect
import logging
import sys
import threading
import time
from collections.abc import Callable
from enum import Enum
from types import ModuleType

from symfric.errors import SceneError

PATIENCE = 1.0  # time after which a call is logged, s
_PAIR = tuple[float, float]
_log = logging.getLogger("symfric")
_calls = threading.local()
_seen: set[type] = set()


class _Package(ModuleType):
    """A module that lists its public names only, and answers an unknown one with the nearest of them."""

    def __dir__(self) -> list[str]:
        return [*self.__all__, *(n for n in vars(self) if n.startswith("__"))]

    def __getattr__(self, name: str):
        if name.startswith("_"):
            raise AttributeError(f"{self.__name__} has no attribute {name!r}", name=name, obj=self)
        from symfric.model.symbols import nearest

        spoken = self.__name__.replace("symfric.model.", "symfric.")
        raise AttributeError(f"{spoken} has no name {name!r}{nearest(name, self.__all__)}")


def offer(package: str) -> None:
    """Make a package show its public names only, and guard those that it has: see `guarded`.

    Parameters
    ----------
    package : str
        Name of a loaded module; modules among its public names are offered too.
    """
    module = sys.modules[package]
    if "__all__" not in vars(module):
        vars(module)["__all__"] = _own_names(module)
    for name in module.__all__:
        thing = vars(module).get(name)
        if type(thing) is ModuleType and thing.__name__.startswith("symfric."):
            offer(thing.__name__)
        elif thing is not None:
            setattr(module, name, guarded(thing, package))
    module.__class__ = _Package


def _own_names(module: ModuleType) -> list[str]:
    """Return the public names of what a module defines: functions, classes, and constants of its classes."""
    public = {n: t for n, t in vars(module).items() if not n.startswith("_")}
    classes = tuple(t for t in public.values() if inspect.isclass(t) and t.__module__ == module.__name__)
    own = (n for n, t in public.items() if getattr(t, "__module__", "") == module.__name__ or isinstance(t, classes))
    return sorted(own)


def guarded(thing, package: str):
    """Return a public function or class that answers wrong arguments in one line and logs calls of over a second.

    Parameters
    ----------
    thing : object
        Classes get a guarded ``__init__`` and guarded methods, and an unknown attribute names the nearest; anything but
        functions and classes is returned as it is.
    package : str
        Where it is found under its name, for pickling.

    Returns
    -------
    object
    """
    if inspect.isfunction(thing) and not getattr(thing, "guarded", False):
        found = _guarded(thing, thing.__name__, first=0)
        found.__module__ = package
        return found
    if inspect.isclass(thing) and thing.__module__.startswith("symfric."):
        init = vars(thing).get("__init__")
        if inspect.isfunction(init) and not getattr(init, "guarded", False):
            type.__setattr__(thing, "__init__", _guarded(init, thing.__name__, first=1))
        if not issubclass(thing, Exception | Enum):
            _guard_methods(thing)
    return thing


def _helpful(result):
    """Return a result whose class answers wrong arguments of its methods and unknown attributes in one line."""
    kind = type(result)
    if kind not in _seen:
        _seen.add(kind)
        if kind.__module__.startswith("symfric.") and not issubclass(kind, Exception | Enum):
            _guard_methods(kind)
    return result


def _guard_methods(kind: type) -> None:
    for name, method in list(vars(kind).items()):
        if inspect.isfunction(method) and not name.startswith("_") and not getattr(method, "guarded", False):
            type.__setattr__(kind, name, _guarded_method(method, f"{kind.__name__}.{name}"))
    if not hasattr(kind, "__getattr__"):
        type.__setattr__(kind, "__getattr__", _unknown_attribute)


def _unknown_attribute(self, name: str):
    """Raise the error of an unknown attribute, with the nearest known one."""
    if name.startswith("_") or hasattr(type(self), name):  # a protocol; or a property that failed with this error
        return object.__getattribute__(self, name)
    from symfric.model.symbols import nearest

    known = [n for n in dir(self) if not n.startswith("_")]
    raise AttributeError(f"{type(self).__name__} has no attribute {name!r}{nearest(name, known)}", name=name, obj=self)


def _guarded_method(method: Callable, spoken: str) -> Callable:
    """Return a method that answers wrong arguments in one line; unlike functions, it costs next to nothing."""

    @functools.wraps(method)
    def guard(*args, **kwargs):
        try:
            return method(*args, **kwargs)
        except (TypeError, AttributeError, ValueError) as error:
            found = _in_one_line(error, method, spoken, 1, args, kwargs)
            if found is error:
                raise
            raise found from None

    vars(guard)["guarded"] = True
    return guard


def _in_one_line(error: Exception, function: Callable, spoken: str, first: int, args: tuple, kwargs: dict) -> Exception:
    """Return the error of a call that names the argument at fault; the error itself if none is."""
    if isinstance(error, SceneError):
        return error
    parameters = list(inspect.signature(function).parameters.values())[first:]
    wrong = _misnamed(parameters, spoken, kwargs) or _missing(parameters, spoken, args[first:], kwargs)
    if wrong is not None:
        return wrong
    blame = _blamed(function, args, kwargs)
    return error if blame is None else SceneError(f"{spoken}: {blame}")


def _misnamed(parameters: list[inspect.Parameter], spoken: str, kwargs: dict) -> TypeError | None:
    """Return the error of an argument that a function does not have; None if it has them all."""
    known = [p.name for p in parameters]
    if any(p.kind is p.VAR_KEYWORD for p in parameters) or set(kwargs) <= set(known):
        return None
    from symfric.model.symbols import nearest

    wrong = next(k for k in kwargs if k not in known)
    if len(known) == 1 and "Mapping" in str(parameters[0].annotation):  # where(k=1) for where({"k": 1})
        return TypeError(f"{spoken} takes a mapping: {spoken.rpartition('.')[2]}({{{wrong!r}: {kwargs[wrong]!r}}})")
    return TypeError(f"{spoken} has no argument {wrong!r}{nearest(wrong, known)}")


def _missing(parameters: list[inspect.Parameter], spoken: str, args: tuple, kwargs: dict) -> TypeError | None:
    """Return the error of arguments that a call lacks, with the form of the call; None if it has them all."""
    places = [p for p in parameters if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
    given = {p.name for p in places[: len(args)]} | set(kwargs)
    needed = [p for p in parameters if p.default is p.empty and p.kind not in (p.VAR_POSITIONAL, p.VAR_KEYWORD)]
    lacking = [p.name for p in needed if p.name not in given]
    if not lacking:
        return None
    form = ", ".join(f"{p.name}=..." if p.kind is p.KEYWORD_ONLY else p.name for p in needed)
    return TypeError(f"{spoken} needs {' and '.join(lacking)}: {spoken.rpartition('.')[2]}({form})")


def _guarded(function: Callable, spoken: str, first: int) -> Callable:
    parameters = list(inspect.signature(function).parameters.values())
    known = {p.name for p in parameters[first:]}
    checks = [(i, p.name, check) for i, p in enumerate(parameters) if (check := _check_of(p.annotation))]

    @functools.wraps(function)
    def guard(*args, **kwargs):
        if not known.issuperset(kwargs) and (wrong := _misnamed(parameters[first:], spoken, kwargs)):
            raise wrong
        for i, name, check in checks:
            if i < len(args):
                check(args[i], name, spoken)
            elif name in kwargs:
                check(kwargs[name], name, spoken)
        try:
            if _log.isEnabledFor(logging.INFO) and not getattr(_calls, "inside", False):
                return _helpful(_timed(function, spoken, args, kwargs))
            return _helpful(function(*args, **kwargs))
        except (TypeError, AttributeError, ValueError) as error:
            found = _in_one_line(error, function, spoken, first, args, kwargs)
            if found is error:
                raise
            raise found from None

    vars(guard)["guarded"] = True
    return guard


def _timed(function: Callable, spoken: str, args: tuple, kwargs: dict):
    """Call a function; log that it works once this takes a second, and its time at the end."""
    _calls.inside, begin = True, time.monotonic()
    waiting = threading.Timer(PATIENCE, _log.info, ("%s: working", spoken))
    waiting.daemon = True
    waiting.start()
    try:
        return function(*args, **kwargs)
    finally:
        waiting.cancel()
        _calls.inside = False
        if time.monotonic() - begin > PATIENCE:
            _log.info("%s: %.1f s", spoken, time.monotonic() - begin)


def _check_of(annotation) -> Callable[[object, str, str], None] | None:
    """Return the check of an argument by its type: scenes and ranges, which are mistaken most."""
    if inspect.isclass(annotation) and annotation.__name__ == "Scene":
        return functools.partial(_check_scene, annotation)
    return _check_pair if annotation == _PAIR else None


def _check_scene(kind: type, value, name: str, spoken: str) -> None:
    if isinstance(value, kind):
        return
    cure = "sf.read(...) reads a scene file" if isinstance(value, str) else "give a sf.Scene"
    raise SceneError(f"{name} of {spoken} is {_short(value)}, not a scene; {cure}")


def _check_pair(value, name: str, spoken: str) -> None:
    try:
        count = None if isinstance(value, str) else len(value)
    except TypeError:
        count = None
    if count != 2:
        raise SceneError(f"{name} of {spoken} is {_short(value)}; give two numbers, {name}=(lower, upper)")


def _blamed(function: Callable, args: tuple, kwargs: dict) -> str | None:
    from symfric.model.blame import blamed

    return blamed(function, args, kwargs)


def _short(value) -> str:
    from symfric.model.blame import shortened

    return shortened(value)
