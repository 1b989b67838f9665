"""The excitation of a scene: how its equations depend on time, and whether that repeats."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from fractions import Fraction

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.scene import Scene
from symfric.model.symbols import TIME

_MOST = 1000  # denominator of a ratio of frequencies that have a common period
_EQUAL = 1e-11  # relative: numbers that differ by rounding


@alone(SYMBOLIC)
def frequencies(scene: Scene, zero: Mapping[sp.Symbol, sp.Expr]) -> tuple[sp.Expr, ...]:
    """Return the angular frequencies of the sines and cosines of time in a scene; none if nothing depends on time.

    Parameters
    ----------
    scene : Scene
    zero : dict of Symbol to Expr
        Parameters to drop: a term with a factor that is zero does not count.

    Raises
    ------
    SceneError
        If time enters otherwise, or an input is sampled: then the excitation has no period.
    """
    if scene.inputs:
        raise SceneError("a sampled input has no period; write the excitation with sin or cos of sf.TIME")
    parts = [*scene.system.expressions, *(e for c in scene.contacts for e in (c.slip, c.normal, c.profile))]
    moving, drop = {TIME, *scene.system.states}, dict(zero)
    found = dict.fromkeys(rate for e in parts for rate in _rates(sp.sympify(e).xreplace(drop), moving, e))
    return tuple(rate for rate in found if rate != 0)


def _rates(e: sp.Expr, moving: set[sp.Symbol], whole: sp.Expr) -> Iterator[sp.Expr]:
    """Yield the frequencies in an expression."""
    if TIME not in e.free_symbols:
        return
    if e == TIME:
        raise SceneError(f"time appears outside sines and cosines in {whole}: the excitation has no period")
    parts = e.args
    if isinstance(e, sp.sin | sp.cos):
        parts = sp.Add.make_args(sp.expand(e.args[0]))
        slopes = [sp.diff(part, TIME) for part in parts]
        yield sum((s for s in slopes if not s.free_symbols & moving), sp.S.Zero)
        parts = [part for part, s in zip(parts, slopes, strict=True) if s.free_symbols & moving]
    for part in parts:
        yield from _rates(part, moving, whole)


def common_rate(rates: Iterable[float]) -> float | None:
    """Return the largest frequency of which all others are whole multiples; None if there is none.

    Examples
    --------
    >>> common_rate([2.0, 3.0])
    1.0
    >>> common_rate([1.0, 2**0.5]) is None
    True
    """
    sizes = [abs(rate) for rate in rates if rate != 0]
    if not sizes:
        return None
    ratios = [Fraction(size / sizes[0]).limit_denominator(_MOST) for size in sizes]
    for ratio, size in zip(ratios, sizes, strict=True):
        if ratio == 0 or abs(float(ratio) * sizes[0] - size) > _EQUAL * size:
            return None
    return sizes[0] * math.gcd(*(r.numerator for r in ratios)) / math.lcm(*(r.denominator for r in ratios))


@alone(SYMBOLIC)
def later(scene: Scene, time: float) -> Scene:
    """Return the scene whose excitation at t = 0 is that of the given one at a time."""
    shift = {TIME: TIME + time}
    moved = replace(
        scene.system,
        force=[e.xreplace(shift) for e in scene.system.force],
        z_rate=[e.xreplace(shift) for e in scene.system.z_rate],
    )
    contacts = tuple(
        replace(c, slip=c.slip.xreplace(shift), normal=c.normal.xreplace(shift), profile=c.profile.xreplace(shift))
        for c in scene.contacts
    )
    inputs = {s: replace(signal, t0=signal.t0 - time) for s, signal in scene.inputs.items()}
    return replace(scene, system=moved, contacts=contacts, inputs=inputs)
