"""Many decays of the contact damper, from one compiled program for each law."""

from collections.abc import Iterable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from symfric.model import scenes
from symfric.solve.protocol import Program
from symfric.solve.routes import prepare
from symfric.solve.run import Run

FALLING, PRINTED = "corrected law", "law as printed"
LAWS = (FALLING, PRINTED)
MASS, GRAVITY, START = 0.5, 9.81, 0.01  # kg, of figures 3 and 4; m/s^2, not said; m, said for figure 5
HORIZON = 100.0  # s; time at rest takes no computing
TOLERANCE = 1e-11


class RodDecay(NamedTuple):
    """Result of one decay.

    Attributes
    ----------
    time : float
        Until the rod rests for good, s; NaN if that is beyond the horizon.
    half_cycles : int
    ratio : float
        Viscous over contact energy.
    rest : float
        Final position of the rod, m.
    closest : float
        The margin of the decision to stick or to slide that was nearest to the other one; see
        `symfric.theory.transient.decisions`, which says the same of any scene.
    """

    time: float
    half_cycles: int
    ratio: float
    rest: float
    closest: float


def start_of(energy: float | np.ndarray, *, f_n: float, m: float, impulse: bool = False) -> Any:
    """Return displacement, m, or with `impulse` velocity, m/s, that gives the rod an energy, J; (4) corrected."""
    velocity = np.sqrt(2 * np.asarray(energy) / m)
    return velocity if impulse else velocity / (2 * np.pi * f_n)


def run_of(
    law: str,
    *,
    f_n: float,
    mu_m: float,
    zeta: float = 0.0,
    m: float = MASS,
    x0: float = START,
    v0: float = 0.0,
    v_c: float = 1.0,
) -> Run:
    """Return one motion with the corrected law or the one as printed."""
    values = {"f_n": f_n, "mu_m": mu_m, "zeta": zeta, "m": m, "v_c": v_c}
    return _program(law).run(values, {"x": x0, "u": v0}).checked()


def decay(law: str = FALLING, **values: float) -> RodDecay:
    """Return one decay; the arguments are those of `run_of`."""
    run = run_of(law, **values)
    events = [e.t for e in run.events]
    turns = [values.get("x0", START)] * (values.get("v0", 0.0) == 0.0)
    positions = np.abs([*turns, *(run(np.array(events))[0] if events else ())])
    limit = values["mu_m"] * GRAVITY / (2 * np.pi * values["f_n"]) ** 2
    margins = positions / limit - 1
    viscous, contact = run["E_viscous"], run["E_contact"]
    return RodDecay(
        float(run["stop_time"]),
        len(events),
        viscous / contact if contact else np.nan,
        float(run.final[0]),
        float(margins[np.argmin(np.abs(margins))]),
    )


def decays(law: str, name: str, values: Iterable[float], **fixed: float) -> list[RodDecay]:
    """Return decays over a range of one argument of `run_of`."""
    return [decay(law, **fixed, **{name: float(v)}) for v in values]


@cache
def _program(law: str) -> Program:
    scene = scenes.contact_damper(
        f_n=10.0, mu_m=0.1, zeta=0.01, g=GRAVITY, m=MASS, literal=law == PRINTED, horizon=HORIZON
    )
    return prepare(scene.starting({"x": START, "u": 0.0}), TOLERANCE)
