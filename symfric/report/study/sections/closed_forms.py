"""Closed forms of the ready scenes beside what was computed, where they hold for the values of the file."""

import math
from collections.abc import Callable, Iterator

import sympy as sp

from symfric.errors import NotFound, SceneError
from symfric.orbits.steady_state import Vibration
from symfric.report.study.measurement import SampledMotion
from symfric.scenefile import SceneFile
from symfric.theory import transient
from symfric.theory.drive import positioning_error, two_slides_cycle
from symfric.theory.hunting import hunting
from symfric.theory.transient import averaged_decay_time

Row = tuple[str, float, float, str, str]  # quantity, predicted, computed, formula, symbol whose unit it has


def closed_forms(file: SceneFile, motion: SampledMotion | None, steady: Vibration | None) -> list[Row]:
    """Return the closed forms that apply to a ready scene.

    Parameters
    ----------
    motion : SampledMotion or None
    steady : Vibration or None
        None where the motion has not settled.
    """
    form = _FORMS.get(file.model or "")
    if form is None or motion is None or motion.status != "OK":
        return []
    try:
        return list(form(file, motion, steady))
    except (SceneError, NotFound):
        return []


def _numbers(file: SceneFile) -> dict[str, float]:
    return {s.name: float(v) for s, v in file.scene.numbers().items()}


def _rest(motion: SampledMotion) -> float:
    """Return the time from which everything sticks until the end of the motion; NaN if something moves."""
    last = [intervals[-1] if intervals else (math.nan, math.nan) for intervals in motion.sticks.values()]
    return max(start for start, _ in last) if all(end >= motion.t[-1] for _, end in last) else math.nan


def _coulomb_oscillator(file: SceneFile, motion: SampledMotion, steady: Vibration | None) -> Iterator[Row]:
    given = _numbers(file)
    if given["u"] != 0:
        return
    start = given["delta"], given["delta_s"], given["x"]
    words = "counting half cycles"
    yield "time of rest", transient.stop_time(*start, given["omega_n"]), _rest(motion), words, "t"
    yield "x at rest", float(transient.stop_position(*start)), float(motion.x[0, -1]), words, "x"


def _contact_damper(file: SceneFile, motion: SampledMotion, steady: Vibration | None) -> Iterator[Row]:
    words = "averaging; within half of a half cycle"
    yield "time of rest", averaged_decay_time(file.scene), _rest(motion), words, "t"


def _drive_stop(file: SceneFile, motion: SampledMotion, steady: Vibration | None) -> Iterator[Row]:
    given = _numbers(file)
    if given["speed"] == 0 and "error" in motion.outputs:
        error = positioning_error(given["mu1"], given["mu2"], given["lam"], epsilon=given["epsilon"])
        yield "positioning error", error.value, motion.outputs["error"], "Guida (15), (20)", ""


def _two_slides(file: SceneFile, motion: SampledMotion, steady: Vibration | None) -> Iterator[Row]:
    given = _numbers(file)
    if steady is None or not steady.stick_fraction > 0:
        return
    names = ("r", "zeta", "s1", "s2", "fc1", "fs1")
    over = "omega2" if file.scene.system.force[1].diff(file.scene.system.u[1]).has(*_named(file, "zeta")) else "omega1"
    cycle = two_slides_cycle(**{n: given[n] for n in names}, damping=over)
    words = "one slip and one stick in closed form"
    measured = {"eta1": 0, "eta2": 1}.get(file.sweep.coordinate if file.sweep else "eta1")
    if measured is not None:
        half = 0.5 * cycle.ranges[measured]
        yield f"half range of eta{measured + 1}", half, steady.half_range, words, f"eta{measured + 1}"
    yield "period", cycle.period, steady.period, words, "t"


def _named(file: SceneFile, name: str) -> list[sp.Symbol]:
    return [s for s in file.scene.parameters if s.name == name]


def _positioning_stage(file: SceneFile, motion: SampledMotion, steady: Vibration | None) -> Iterator[Row]:
    given, law = _numbers(file), file.scene.contacts[0].law.where(file.scene.parameter_values())
    if steady is None or given["compensation"] != 0 or law.memory or not law.kinetic.is_number:
        return
    cycle = hunting(
        **{n: given[n] for n in ("k_p", "k_d", "k_i", "m")},
        F_s=given["N"] * float(law.stick),
        F_c=given["N"] * float(law.kinetic),
    )
    words = "hunting in closed form"
    yield "half range of x", cycle.offset, steady.half_range, words, "x"
    yield "period", cycle.period, steady.period, words, "t"


_FORMS: dict[str, Callable[..., Iterator[Row]]] = {
    "coulomb_oscillator": _coulomb_oscillator,
    "contact_damper": _contact_damper,
    "drive_stop": _drive_stop,
    "two_slides": _two_slides,
    "positioning_stage": _positioning_stage,
}
