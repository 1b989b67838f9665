"""Fit of a friction law with memory to measured hysteresis: displacement and friction."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import casadi as ca
import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.identification.direct import Formula, fit_formula, noise_of, symbols_called, with_law
from symfric.identification.fit import Fit
from symfric.identification.records import Channel, numbers
from symfric.identification.unknowns import read_bounds
from symfric.locks import SYMBOLIC, alone
from symfric.lower.printer import Printer, Switches
from symfric.model.arguments import flag
from symfric.model.laws import Law
from symfric.model.laws.memory import SIDE, SLIP, Memory
from symfric.model.symbols import SPEED, Key, positive
from symfric.spelling import spelt

PARTS = 8  # steps from one sample to the next; laws linear in their states, and sliders, are exact in one


@spelt
def fit_loop(
    law: Law,
    displacement: Any,
    friction: Any,
    parameters: Mapping[Key, tuple[float, float]],
    *,
    time: Any = None,
    normal: float = 1.0,
    closed: bool = False,
    sigma: Any = None,
    seed: int = 0,
) -> Fit:
    """Fit a law with memory to hysteresis loops: displacement of the contact and friction, sample by sample.

    Parameters
    ----------
    law : Law
        With memory, and with symbols in place of what is unknown: ``sf.laws.dahl(mu_c, sigma)``, ``maxwell_slip``,
        ``bouc_wen``, ``lugre``, ...
    displacement, friction : array_like, shape (n,)
        In the order of the measurement; between the samples the contact moves evenly.
    parameters : mapping of name to (low, high)
        The symbols of the law with their bounds.
    time : array_like, shape (n,), optional
        Of the samples; needed for laws that depend on the speed.
    normal : float
        Normal load, so that `friction` is a force; 1 for coefficients.
    closed : bool
        Whether the record holds whole cycles, which begin in the state in which they end; else all states begin at
        zero.
    sigma : float or array_like, shape (n,), optional
        Standard deviation of the noise; estimated from the residuals unless given.
    seed : int
        Of the starts.

    Returns
    -------
    Fit
        ``fit.law`` is the law with the fitted values.

    Raises
    ------
    SceneError
        If the law has no memory or other symbols, a sample is bad, or times are missing.
    NotFound
        If the law has no finite value between the bounds.

    Notes
    -----
    From sample to sample the states follow their rates at constant speed by the exponential method of Rosenbrock and
    Euler in 8 parts (Hochbruck and Ostermann, Acta Numerica 19 (2010) 209), which is exact for laws that are linear in
    their state (Dahl, LuGre) and of second order for others; sliders are exact. Derivatives by the same recurrence.

    Examples
    --------
    >>> import numpy as np
    >>> import sympy as sp
    >>> import symfric as sf
    >>> mu_c, sigma = sp.symbols("mu_c sigma", positive=True)
    >>> x = 1e-3 * np.sin(np.linspace(0.0, 4 * np.pi, 400))
    >>> rise = 0.3 * (1 - np.exp(-x[:51] * 2000.0 / 0.3))  # first loading of Dahl's law
    >>> fit = sf.fit_loop(sf.laws.dahl(mu_c, sigma), x[:51], rise, {"mu_c": (0.1, 1.0), "sigma": (100.0, 1e4)})
    >>> {n: round(v, 6) for n, v in fit.values.items()}
    {'mu_c': 0.3, 'sigma': 2000.0}
    """
    flag(closed, "closed")
    if not isinstance(law, Law) or law.memory is None:
        raise SceneError("the law has no memory, so that it has no loops; use sf.fit_curve, or a law such as dahl")
    load = positive(normal, "normal")
    x, y = numbers(displacement, "displacement"), numbers(friction, "friction")
    t = _times(x, y, time, law)
    unknowns = read_bounds(parameters)
    recurrence = _recurrence(law, unknowns.names)
    drive = _drive(x, t, recurrence.parts, closed)
    channel = Channel("", "friction", law.kinetic, t, y, over="t" if time is not None else "path")

    def evaluate(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        predicted, slopes = recurrence.run(drive, values, x.size)
        return load * predicted, load * slopes

    def plain(values: np.ndarray) -> np.ndarray:
        return load * recurrence.run(drive, values, x.size, slopes=False)[0]

    fit = fit_formula(Formula((channel,), unknowns, evaluate, plain), noise_of(sigma, y.size), None, seed)
    return with_law(fit, law)


def _times(x: np.ndarray, y: np.ndarray, time: Any, law: Law) -> np.ndarray:
    """Return the times of the samples, or the path that the contact has gone."""
    if x.size != y.size:
        raise SceneError(f"there are {x.size} displacements and {y.size} values of friction; give one for each")
    if x.size < 3:
        raise SceneError(f"the loop has {x.size} samples; measure more")
    for row, name in ((x, "displacement"), (y, "friction")):
        bad = np.flatnonzero(~np.isfinite(row))
        if bad.size:
            raise SceneError(f"{name}[{bad[0]}] is {row[bad[0]]}; leave out samples that are not finite")
        if np.ptp(row) == 0:
            raise SceneError(f"the {name} is constant ({row[0]:.6g}); a loop needs motion there and back")
    if time is None:
        if not _is_rate_independent(law):
            raise SceneError("the law depends on the speed; give the times of the samples with time=...")
        return np.concatenate([[0.0], np.cumsum(np.abs(np.diff(x)))])
    t = numbers(time, "time")
    if t.size != x.size:
        raise SceneError(f"there are {t.size} times and {x.size} samples; give one for each")
    if not np.all(np.isfinite(t)) or np.any(np.diff(t) <= 0):
        raise SceneError("time is not finite and increasing; sort the samples")
    return t


@alone(SYMBOLIC)
def _is_rate_independent(law: Law) -> bool:
    """Whether twice the speed makes twice the rates and the same force, tried at numbers."""
    memory = _memory_of(law)
    rng = np.random.default_rng(0)
    symbols = sorted(set().union(*(e.free_symbols for e in memory.expressions)) - {SLIP, SPEED, SIDE}, key=str)
    given = {s: float(v) for s, v in zip(symbols, rng.uniform(0.5, 1.5, len(symbols)), strict=True)}
    once, twice = ({**given, SLIP: w, SPEED: w, SIDE: 1} for w in (0.7, 1.4))
    same = [abs(float(e.subs(twice)) - 2 * float(e.subs(once))) for e in memory.rates]
    force = abs(float(memory.force.subs(twice)) - float(memory.force.subs(once)))
    return max(*same, force) < 1e-9


def _memory_of(law: Law) -> Memory:
    assert law.memory is not None
    return law.memory


def _drive(x: np.ndarray, t: np.ndarray, parts: int, closed: bool) -> tuple[np.ndarray, np.ndarray, int]:
    """Return length and speed of every step, the speeds at the samples, and how many steps come before them."""
    step, change = np.diff(t), np.diff(x)
    speed = np.divide(change, step, out=np.zeros_like(step), where=step > 0)
    at = np.gradient(x, t) if np.all(step > 0) else np.concatenate([[speed[0]], speed])
    table = np.stack([np.repeat(step / parts, parts), np.repeat(speed, parts)])
    before = table.shape[1] if closed else 0
    return (np.concatenate([table, table], axis=1) if closed else table), at, before


@dataclass(frozen=True, eq=False)
class _Recurrence:
    """States of a law with their derivatives, step by step, and the friction that they make.

    Attributes
    ----------
    step, force : pair of casadi.Function
        ``(z, [h; w], p) -> z`` and ``(z, w, p) -> mu``; then with derivatives, ``([z; S], [h; w], p) -> [z; S]`` and
        ``([z; S], w, p) -> [mu; d mu/dp]``.
    parts : int
        Steps from sample to sample.
    """

    step: tuple[ca.Function, ca.Function]
    force: tuple[ca.Function, ca.Function]
    parts: int
    _repeated: dict[tuple[int, int, bool], tuple[ca.Function, ca.Function]] = field(default_factory=dict, repr=False)

    def _over(self, size: int, steps: int, slopes: bool) -> tuple[ca.Function, ca.Function]:
        """Return the functions of all steps and of all samples."""
        key = size, steps, slopes
        if key not in self._repeated:
            self._repeated[key] = self.step[slopes].mapaccum(steps), self.force[slopes].map(size)
        return self._repeated[key]

    @alone(SYMBOLIC)
    def run(
        self, drive: tuple[Any, ...], values: np.ndarray, size: int, slopes: bool = True
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return friction (n,) and its derivatives (n, n_p), of which there are none without `slopes`."""
        table, at, before = drive
        whole, force = self._over(size, table.shape[1], slopes)
        start = np.zeros((whole.size1_in(0), 1))
        states = np.array(whole(start, table, np.tile(values[:, None], table.shape[1])))
        states = np.concatenate([start, states], axis=1)[:, before :: self.parts]
        rows = np.array(force(states, at[None, :], np.tile(values[:, None], size)))
        return rows[0], rows[1:].T


@alone(SYMBOLIC)
def _recurrence(law: Law, names: tuple[str, ...]) -> _Recurrence:
    """Return the recurrence of a law, with derivatives by some of its symbols."""
    memory = _memory_of(law)
    used = set().union(*(e.free_symbols for e in (*memory.rates, memory.force, *memory.limits))) - memory.reserved
    symbols = symbols_called(names, used)
    n, n_p = len(memory.symbols), len(names)
    z, p, h, w = ca.SX.sym("z", n), ca.SX.sym("p", n_p), ca.SX.sym("h"), ca.SX.sym("w")
    known: dict[sp.Symbol, ca.SX] = dict(zip(memory.symbols, ca.vertsplit(z), strict=True))
    known |= dict(zip(symbols, ca.vertsplit(p), strict=True))
    known |= {SLIP: w, SPEED: ca.fabs(w), SIDE: ca.sign(w)}
    write = Printer(known, set(), Switches())
    rates = ca.vertcat(*map(write, memory.rates))
    if memory.limits:
        limits = ca.vertcat(*map(write, memory.limits))
        after = ca.fmax(-limits, ca.fmin(limits, z + h * rates))
    else:
        slope = h * ca.diag(ca.jacobian(rates, z))
        small = ca.fabs(slope) < 1e-6
        factor = ca.if_else(small, 1 + slope / 2, ca.expm1(slope) / ca.if_else(small, 1, slope))
        after = z + h * factor * rates
    carried = ca.SX.sym("S", n, n_p)
    moved = ca.jacobian(after, z) @ carried + ca.jacobian(after, p)
    both, state = ca.vertcat(after, ca.vec(moved)), ca.vertcat(z, ca.vec(carried))
    mu = write(memory.force)
    slopes = ca.jacobian(mu, z) @ carried + ca.jacobian(mu, p)
    hw = ca.vertcat(h, w)
    step = ca.Function("step", [z, hw, p], [after]), ca.Function("step", [state, hw, p], [both])
    force = ca.Function("force", [z, w, p], [mu]), ca.Function("force", [state, w, p], [ca.vertcat(mu, slopes.T)])
    linear = not ca.depends_on(ca.jacobian(rates, z), z)
    return _Recurrence(step, force, 1 if memory.limits or linear else PARTS)
