"""The excitation of a scene: its frequencies and its period."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import sympy as sp
from sympy.core.relational import Relational

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.constant_parameters import vanishing
from symfric.model.linear_part import with_replaced
from symfric.model.scene import Scene
from symfric.model.symbols import TIME

# Relative difference up to which numbers count as equal, and largest product p q for which two frequencies count as
# p : q. The ratio of two independent numbers is that close to such a fraction by chance in about 6 cases of a million.
_EQUAL, _MOST = 1e-11, 1_000_000
_ALIKE = 1e-9  # relative difference up to which changes of two frequencies count as keeping their ratio
_SAMPLED = "a sampled input has no period; write the excitation with sin or cos of sf.TIME"


@dataclass(frozen=True, eq=False)
class Excitation:
    """How the equations of a scene depend on time.

    Attributes
    ----------
    rates : tuple of Expr
        Angular frequencies of the sines and cosines of time; none if nothing depends on time.
    note : str
        Why it has no period for any values; "" if it may have one.
    """

    rates: tuple[sp.Expr, ...] = field(default=())
    note: str = ""

    def __bool__(self) -> bool:
        """Whether anything depends on time."""
        return bool(self.rates or self.note)

    @property
    def parameters(self) -> frozenset[str]:
        """Names of the parameters that change the frequencies."""
        return frozenset(s.name for s in self._symbols)

    def frequencies(self, values: Mapping[str, float]) -> np.ndarray:
        """Return the angular frequencies as numbers, in the order of `rates`.

        Raises
        ------
        SceneError
            If one is not a finite real number.
        """
        return self._frequencies([values[s.name] for s in self._symbols])

    def _frequencies(self, numbers: Sequence[float]) -> np.ndarray:
        with np.errstate(all="ignore"):
            values = np.array([complex(e) for e in self._numbers(*numbers)])
        for rate, number in zip(self.rates, values, strict=True):
            if not np.isfinite(number) or number.imag:
                raise SceneError(f"the frequency {rate} of the excitation is {number:g}; it must be finite and real")
        return values.real

    def period(self, values: Mapping[str, float]) -> float:
        """Return the period of the excitation for parameter values by name; perhaps a multiple of the least one.

        Raises
        ------
        SceneError
            If there is none.
        """
        if self.note:
            raise SceneError(self.note)
        return _period(self, tuple(values[s.name] for s in self._symbols))

    def period_by(self, values: Mapping[str, float], parameters: Sequence[str]) -> np.ndarray:
        """Return the derivatives of the period by parameters, shape (n_p,).

        Raises
        ------
        SceneError
            If a change of them leaves no common period.
        """
        if self.note:
            raise SceneError(self.note)
        return _period_by(self, tuple(values[s.name] for s in self._symbols), tuple(parameters)).copy()

    @cached_property
    def _symbols(self) -> tuple[sp.Symbol, ...]:
        return tuple(sorted(set().union(*(rate.free_symbols for rate in self.rates)), key=str))

    @cached_property
    def _numbers(self) -> Callable[..., Any]:
        with SYMBOLIC:
            made: Callable[..., Any] = sp.lambdify(self._symbols, self.rates)
            return made

    @cached_property
    def _kept(self) -> dict[tuple[str, ...], Callable[..., Any]]:
        return {}

    @alone(SYMBOLIC)
    def _slopes(self, parameters: tuple[str, ...]) -> Callable[..., Any]:
        """Return a function of the parameters that gives the derivatives of the frequencies by them."""
        if parameters not in self._kept:
            of = {s.name: s for s in self._symbols}
            table = [[sp.diff(rate, of[n]) if n in of else sp.S.Zero for n in parameters] for rate in self.rates]
            self._kept[parameters] = sp.lambdify(self._symbols, table)
        return self._kept[parameters]


@alone(SYMBOLIC)
def excitation_of(scene: Scene, varied: frozenset[str] = frozenset()) -> Excitation:
    """Read the excitation of a scene.

    Parameters
    ----------
    scene : Scene
        Terms with a factor that is zero do not count.
    varied : frozenset of str
        Parameters that will not stay zero.
    """
    if scene.inputs:
        return Excitation(note=_SAMPLED)
    angles: dict[sp.Expr, None] = {}
    for e, reduced in _of_time(scene, varied):
        try:
            angles |= dict.fromkeys(
                rate for rate in _rates(reduced, {TIME, *scene.system.states, *scene.system.rows}, e) if rate != 0
            )
        except SceneError as reason:
            return Excitation(note=str(reason))
    for part in scene.timed:
        if part.every is None:
            return Excitation(note="states are reset at given times: the scene has no period")
        first = sp.sympify(part.offset - part.every).subs({s: v for s, v in scene.values.items() if v is not None})
        if first.is_number and first >= 0:
            return Excitation(note="a clock starts later than a period of its own: the scene has no period")
        angles[2 * sp.pi / part.every] = None
    return Excitation(tuple(angles))


def periodic(scene: Scene, varied: frozenset[str] = frozenset()) -> Excitation | None:
    """Return the excitation of a scene, None if nothing depends on time; see `excitation_of`.

    Raises
    ------
    SceneError
        If it has no period, for the values of the scene if all are given.
    """
    excitation = excitation_of(scene, varied)
    if excitation.note:
        raise SceneError(excitation.note)
    if not excitation:
        return None
    given = {s.name: v for s, v in scene.values.items() if v is not None}
    if len(given) == len(scene.values):
        excitation.period(given)
    return excitation


def forcing_period(scene: Scene, varied: frozenset[str] = frozenset()) -> float | None:
    """Return the period of the excitation with the values of the scene, None without one; see `excitation_of`.

    Raises
    ------
    SceneError
        If it has no period.
    """
    excitation = excitation_of(scene, varied)
    return excitation.period({s.name: v for s, v in scene.parameter_values().items()}) if excitation else None


@alone(SYMBOLIC)
def is_excited(scene: Scene, varied: frozenset[str] = frozenset()) -> bool:
    """Return whether time or a sampled input enters the equations; terms with a factor that is zero do not count."""
    return bool(scene.inputs or scene.timed) or next(_of_time(scene, varied), None) is not None


def _of_time(scene: Scene, varied: frozenset[str]) -> Iterator[tuple[sp.Expr, sp.Expr]]:
    """Yield the expressions of a scene that depend on time: as written, and with zero parameters inserted."""
    contacts = (e for c in scene.contacts for e in c.expressions)
    everything, since = [*scene.system.expressions, *contacts, *scene.clocked], _since_samples(scene)
    for _ in since:
        everything.remove(TIME)
    timed = [e for e in map(sp.sympify, everything) if TIME in e.xreplace(since).free_symbols]
    zero = vanishing(scene, varied) if timed else {}
    for e in timed:
        reduced = e.xreplace(dict(zero))
        if TIME in reduced.free_symbols:
            yield e, reduced


def _since_samples(scene: Scene) -> dict[sp.Basic, sp.Expr]:
    """Return what stands for times of samples: time less that since the sample, which repeats with the clock.

    Such a variable is sampled at the start of a period, so that what it was before does not matter.
    """
    stamps = [h for h in scene.held if h.update == TIME and h.every is not None and h.step is None and not h.late]
    return {h.symbol: TIME - sp.Dummy(f"since {h.name}", real=True) for h in stamps if sp.sympify(h.offset).is_zero}


def frequency_of(wave: sp.Expr, moving: set[sp.Symbol]) -> tuple[sp.Expr, list[sp.Expr]]:
    """Return the frequency of a sine or cosine, and the terms of its argument that are not linear in time.

    Parameters
    ----------
    wave : Expr
    moving : set of Symbol
        What changes along a motion, time among it.
    """
    parts = sp.Add.make_args(sp.expand(wave.args[0]))
    slopes = [sp.diff(part, TIME) for part in parts]
    steady = [not s.free_symbols & moving for s in slopes]
    rate = sum((s for s, even in zip(slopes, steady, strict=True) if even), sp.S.Zero)
    return rate, [part for part, even in zip(parts, steady, strict=True) if not even]


def _rates(e: sp.Expr, moving: set[sp.Symbol], whole: sp.Expr) -> Iterator[sp.Expr]:
    """Yield the frequencies of the sines and cosines in an expression."""
    if TIME not in e.free_symbols:
        return
    if e == TIME:
        raise SceneError(
            f"time appears outside sines and cosines in {whole}: the excitation has no period; of a drive that moves "
            "steadily, take the deflection from it as the coordinate, so that its speed stands where time was"
        )
    parts: Iterable[sp.Expr] = e.args
    if isinstance(e, Relational) and (e.lhs - e.rhs).is_Mul:
        e = _sum_of_waves(e.lhs - e.rhs)
        parts = e.args
    if isinstance(e, sp.sin | sp.cos):
        rate, parts = frequency_of(e, moving)
        yield rate
    for part in parts:
        yield from _rates(part, moving, whole)


def _sum_of_waves(product: sp.Expr) -> sp.Expr:
    """Return a product of two sines of time as a sum of cosines, the frequencies of which it has; else the product."""
    waves = [e for e in product.args if TIME in e.free_symbols]
    if len(waves) != 2 or not all(isinstance(e, sp.sin) for e in waves):
        return product
    a, b = (e.args[0] for e in waves)
    return product / (2 * waves[0] * waves[1]) * (sp.cos(sp.expand(a - b)) - sp.cos(sp.expand(a + b)))


@lru_cache(1024)
def _period(excitation: Excitation, numbers: tuple[float, ...]) -> float:
    """Return the period for the numbers of the excitation's symbols; shooting asks for the same ones many times."""
    frequencies = excitation._frequencies(numbers)
    base = common_rate(frequencies)
    if base is None:
        told = ", ".join(f"{rate} = {number:.12g}" for rate, number in zip(excitation.rates, frequencies, strict=True))
        if not np.any(frequencies):
            raise SceneError(f"the frequencies of the excitation are zero, so it has no period: {told}")
        raise SceneError(f"the frequencies of the excitation have no common period: {told}")
    return 2 * np.pi / base


@lru_cache(1024)
def _period_by(excitation: Excitation, numbers: tuple[float, ...], parameters: tuple[str, ...]) -> np.ndarray:
    period = _period(excitation, numbers)
    if len(excitation.rates) == 1:
        (slopes,), rate = excitation._slopes(parameters)(*numbers), 2 * np.pi / period
        sign = np.sign(excitation._frequencies(numbers)[0])
        return np.array([-period * sign * float(slope) / rate for slope in slopes])
    rates = excitation._frequencies(numbers)
    slopes = np.array(excitation._slopes(parameters)(*numbers), dtype=float).reshape(len(rates), len(parameters))
    runs = rates != 0
    relative = slopes[runs] / rates[runs, None]
    if np.any(np.abs(relative - relative[0]) > _ALIKE * np.abs(relative[0])) or np.any(slopes[~runs]):
        raise SceneError(
            f"{' and '.join(parameters)} changes some frequencies of the excitation and not others, "
            f"{', '.join(map(str, excitation.rates))}: they keep no common period; let it change all or none"
        )
    return np.asarray(-period * relative[0])


def common_rate(rates: Iterable[float]) -> float | None:
    """Return the largest frequency of which all others are whole multiples; None if there is none.

    Zeros and signs do not count, nor does the order.

    Examples
    --------
    >>> common_rate([2.0, 3.0])
    1.0
    >>> common_rate([1.0, 2**0.5]) is None
    True
    """
    sizes = sorted(abs(float(rate)) for rate in rates if rate != 0)
    if len(sizes) < 2:
        return sizes[0] if sizes else None
    ratios = [ratio for ratio in (_simple(size / sizes[0]) for size in sizes) if ratio is not None]
    if len(ratios) < len(sizes):
        return None
    return sizes[0] * math.gcd(*(r.numerator for r in ratios)) / math.lcm(*(r.denominator for r in ratios))


def _simple(ratio: float) -> Fraction | None:
    """Return the fraction of small integers that equals a ratio >= 1 up to rounding; None if there is none."""
    if ratio > _MOST * (1 + _EQUAL):
        return None
    fraction = Fraction(ratio).limit_denominator(max(1, math.isqrt(int(_MOST / ratio))))
    return fraction if abs(float(fraction) - ratio) <= _EQUAL * ratio else None


@alone(SYMBOLIC)
def later(scene: Scene, time: float) -> Scene:
    """Shift the excitation in time: at t = 0 it is that of the given scene at the given time."""
    numbers = {s: v for s, v in scene.values.items() if v is not None}
    for period in (part.every for part in scene.timed):
        shifts = np.nan if period is None else time / float(sp.sympify(period).subs(numbers))
        if not abs(shifts - round(shifts) if np.isfinite(shifts) else np.inf) <= _ALIKE * abs(shifts):
            raise SceneError("the clocks of held variables and resets start again after whole periods only")
    shift = {TIME: TIME + time}
    moved = replace(
        scene.system,
        force=[e.xreplace(shift) for e in scene.system.force],
        z_rate=[e.xreplace(shift) for e in scene.system.z_rate],
        linear=with_replaced(scene.system.linear, shift),
    )
    contacts = tuple(
        replace(
            c.rewritten(lambda e: e.xreplace(shift)),
            law=c.law.where(shift) if TIME in c.law.free_symbols else c.law,
        )
        for c in scene.contacts
    )
    inputs = {s: replace(signal, t0=signal.t0 - time) for s, signal in scene.inputs.items()}
    held = tuple(h.where(shift) for h in scene.held)
    resets = tuple(r.where(shift) for r in scene.resets)
    return replace(scene, system=moved, contacts=contacts, inputs=inputs, held=held, resets=resets)
