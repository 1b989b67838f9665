"""Names that nothing has: the nearest known one, and the error of a call whose keyword the function does not take."""

import difflib
import re
import sys
from collections.abc import Callable, Iterable
from functools import wraps
from inspect import isclass, signature
from typing import Any, TypeVar

_Thing = TypeVar("_Thing", bound=Callable[..., Any])

_MISFIT = re.compile(r"[\w.<>]+\(\) (?:got an unexpected keyword argument '(\w+)'|takes .* arguments? but .* given)")
_OF_MAPPING = re.compile(r"(collections\.abc\.)?Mapping\[")
_STATED = "System", "Contact", "Scene", "Taylor", "Integrators"  # whose arguments are looked for elsewhere
_WORDS = {  # arguments, and what other programs call them
    "tolerance": "tol rtol atol reltol abstol eps epsilon precision accuracy",
    "route": "solver method integrator engine algorithm",
    "horizon": "T tend tmax tspan tf t_end t_max t_span t_final t_stop duration time end stop length",
    "initial": "x0 y0 q0 start state state0 init ic initial_conditions initial_state initial_values",
    "values": "params parameters parameter constants args p",
    "law": "mu mu_s mu_k mu_d friction friction_law friction_coefficient coefficient",
    "slip": "velocity speed v_rel relative_velocity sliding_velocity",
    "normal": "N F_N f_n load normal_force preload",
    "outputs": "results result want wanted observables save_at",
    "force": "f F forces rhs equation equations stiffness K k spring damping C",
    "mass": "m M masses inertia",
    "q": "x coordinates coordinate position positions",
    "u": "v qd dq velocities",
    "jobs": "n_jobs workers n_workers threads cores processes parallel",
    "seed": "random_state rng random",
    "most": "n max_points points n_max limit",
    "bracket": "bounds limits interval range span low",
    "span": "bounds limits interval range bracket",
    "bounds": "limits interval range span bracket",
    "parameter": "param name key variable p",
    "ax": "axis axes figure fig subplot",
    "path": "file filename name",
}


def nearest(name: str, known: Iterable[str]) -> str:
    """Return the hint '; did you mean ...?' for a misspelled name, or the list of known names."""
    known = sorted(set(known))
    name = str(name)
    close = difflib.get_close_matches(name, known, n=1, cutoff=0.6)
    longer = [k for k in known if name and k.startswith(name)]  # tol for tolerance
    close = close or longer if len(longer) < 2 else close
    if close:
        return f"; did you mean {close[0]}?"
    if not known:
        return "; there are none"
    return "; known: " + ", ".join(known[:12]) + (", ..." if len(known) > 12 else "")


def spelt(thing: _Thing) -> _Thing:
    """Decorate a function or a class so that a keyword which it does not take is answered with the nearest one."""
    if isclass(thing):
        setattr(thing, "__init__", spelt(getattr(thing, "__init__")))  # noqa: B009, B010 (of a class, not of one of its objects)
        return thing

    @wraps(thing)
    def called(*args: Any, **kwargs: Any) -> Any:
        try:
            return thing(*args, **kwargs)
        except TypeError as error:
            if better := _misfit(error, thing):
                raise better from None
            raise

    return called  # type: ignore[return-value]


def _misfit(error: TypeError, function: Callable[..., Any]) -> TypeError | None:
    """Return the error of a call that does not fit its function, with the cure; None for errors of another kind."""
    found = _MISFIT.fullmatch(str(error))
    frame = error.__traceback__
    if found is None or (frame is not None and frame.tb_next is not None):  # raised by a call within the function
        return None
    return TypeError(f"{error}{_cure(found[1], function)}")


def _cure(wrong: str | None, function: Callable[..., Any]) -> str:
    """Return the cure for a keyword that a function does not take, or for too many positional arguments."""
    known = {n: p for n, p in signature(function).parameters.items() if n != "self"}
    mapping = next((n for n, p in known.items() if _OF_MAPPING.match(str(p.annotation))), None)
    if wrong is None:  # too many without a name
        first = next(iter(known), None)
        return f"; give {first}={{'name': ...}}" if first and first == mapping else nearest("", known)
    hint = nearest(wrong, known)
    if "did you mean" in hint:
        return hint
    for name in known:
        if wrong in _WORDS.get(name, "").split():
            return f"; it is called {name} here"
    owners = [kind for kind in _STATED if wrong in _arguments(kind)]
    if owners:
        return f"; it is an argument of sf.{owners[0]}"
    return f"; give {mapping}={{{wrong!r}: ...}}" if mapping else hint


def _arguments(kind: str) -> Iterable[str]:
    """Return the arguments of a public class."""
    thing = getattr(sys.modules.get("symfric"), kind, None)
    return signature(thing).parameters if thing else ()
