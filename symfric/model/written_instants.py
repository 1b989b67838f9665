"""Held variables and resets as equations for reading.

Instants have names: ``t_command`` are those at which the variable is computed, ``t_1`` those of the first reset, with a
whole number n where they repeat themselves; ``t_1^+`` is just after. At zeros of an expression an equation says so.
"""

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import sympy as sp

from symfric.model.held import Held
from symfric.model.resets import Reset
from symfric.model.symbols import TIME

if TYPE_CHECKING:
    from symfric.model.scene import Scene

_COUNT = sp.Symbol("n", integer=True, nonnegative=True)


def instants_of(scene: "Scene", shown: Callable[[sp.Symbol], str]) -> Iterator[sp.Eq]:
    """Yield the equations of the held variables and resets of a scene; `shown` gives states their names."""
    moving = {s: sp.Function(shown(s), real=True) for s in scene.system.states}
    for h in scene.held:
        yield from _held(h, scene, moving)
    for k, reset in enumerate(scene.resets, 1):
        yield from _reset(reset, k, moving)


def _at(e: sp.Expr, instant: sp.Expr, moving: dict[sp.Symbol, sp.Function]) -> sp.Expr:
    """Return an expression at an instant."""
    return sp.sympify(e).xreplace({TIME: instant, **{s: f(instant) for s, f in moving.items()}})


def _held(h: Held, scene: "Scene", moving: dict[sp.Symbol, sp.Function]) -> Iterator[sp.Eq]:
    instant = sp.Symbol(f"t_{h.name}", real=True)
    before: dict[sp.Symbol, sp.Expr] = {g.previous: sp.Symbol(f"{g.name}_previous", real=True) for g in scene.held}
    if h.when is None:
        yield sp.Eq(instant, h.offset + _COUNT * h.every, evaluate=False)
        together = [g for g in scene.held if (g.every, g.offset) == (h.every, h.offset)]
        before |= {g.previous: moving[g.symbol](instant - h.every + g.delay) for g in together}
    else:
        yield sp.Eq(_at(h.when, instant, moving), 0, evaluate=False)
    side = instant if h.when is None else sp.Symbol(f"t_{h.name}^+", real=True)
    value = _at(h.update.xreplace(before), side, moving)
    if h.step is not None:
        value = h.step * sp.floor(value / h.step + sp.Rational(1, 2))
    yield sp.Eq(moving[h.symbol](instant + h.delay), value, evaluate=False)


def _reset(reset: Reset, k: int, moving: dict[sp.Symbol, sp.Function]) -> Iterator[sp.Eq]:
    of = {s.name: f for s, f in moving.items()}

    def after(name: str, i: int) -> Iterator[sp.Eq]:
        instant, then = sp.Symbol(name, real=True), sp.Symbol(f"{name}^+", real=True)
        for state, entries in reset.set.items():
            yield sp.Eq(of[state](then), _at(entries[min(i, len(entries) - 1)], instant, moving), evaluate=False)

    name = f"t_{k}"
    if reset.guard is not None:
        yield sp.Eq(_at(reset.guard, sp.Symbol(name, real=True), moving), 0, evaluate=False)
        yield from after(name, 0)
    elif reset.every is not None:
        yield sp.Eq(sp.Symbol(name, real=True), reset.offset + _COUNT * reset.every, evaluate=False)
        yield from after(name, 0)
    else:
        for i, time in enumerate(reset.at):
            each = name if len(reset.at) == 1 else f"{name},{i + 1}"
            yield sp.Eq(sp.Symbol(each, real=True), time, evaluate=False)
            yield from after(each, i)
