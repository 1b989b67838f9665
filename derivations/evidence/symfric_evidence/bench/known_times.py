"""Cost of events at known times beside a plain run, and of tables beside a smooth law at the first call."""

import statistics
import time
from collections.abc import Callable

import numpy as np
import sympy as sp

from symfric.model import laws, scenes
from symfric.model.held import Held
from symfric.model.outputs import End
from symfric.model.resets import Reset
from symfric.model.scene import Scene
from symfric.model.symbols import TIME
from symfric.model.system import Contact, System
from symfric.solve.routes import prepare
from symfric_evidence.bench.needs import Need

_TOLERANCE = 1e-10
_ROUNDS, _REPEATS, _FIRST = 9, 40, 5
_HORIZON, _INSTANTS = 100.0, 64
_X, _U = sp.symbols("x u", real=True)
_LITTLE = 1e-3  # size of steps and kicks: the motion stays nearly the same


def _belt(force: sp.Expr = sp.S.Zero, held: tuple[Held, ...] = (), resets: tuple[Reset, ...] = ()) -> Scene:
    """Return P2 with another force."""
    system = System([_X], [_U], [[1]], [-_X - _U / 10 + force])
    belt = Contact("belt", _U - sp.Rational(1, 5), 1, laws.cubic(0.4, 0.25, 0.5))
    start = {_X: 0.0, _U: 0.0}
    return Scene(system, [belt], {}, start, _HORIZON, {"end": End()}, held=held, resets=resets)


def instant_costs() -> tuple[Need, ...]:
    """Measure P2 with steps in time, a sampled command and kicks, in interleaved rounds."""
    instants = [_HORIZON * (k + 0.37) / _INSTANTS for k in range(_INSTANTS)]
    steps = [_LITTLE * sp.Heaviside(TIME - t) * (-1) ** k for k, t in enumerate(instants)]
    command = Held("command", -_LITTLE * _X, every=_HORIZON / _INSTANTS, offset=instants[0])
    kicks = Reset(at=instants, set={_U: _U + _LITTLE})
    asked = [
        ("plain", _belt()),
        ("one step in time", _belt(steps[_INSTANTS // 2])),
        (f"a square wave, {_INSTANTS} steps", _belt(_LITTLE * sp.sign(sp.sin(sp.pi * TIME * _INSTANTS / _HORIZON)))),
        (f"a command sampled {_INSTANTS} times", _belt(command.symbol, held=(command,))),
        (f"a reset with {_INSTANTS} times", _belt(resets=(kicks,))),
    ]
    programs = [prepare(scene, _TOLERANCE, "taylor") for _, scene in asked]
    samples: list[list[float]] = [[] for _ in programs]
    for program in programs:
        program.run().checked()
    for _ in range(_ROUNDS):
        for program, taken in zip(programs, samples, strict=True):
            taken.append(_seconds(lambda: [program.run() for _ in range(_REPEATS)]) / _REPEATS)  # noqa: B023
    return tuple(Need(name, statistics.median(taken), 0.0) for (name, _), taken in zip(asked, samples, strict=True))


def table_costs() -> tuple[Need, ...]:
    """Measure the first call of a mass on a belt, with laws of other numbers each time, so that nothing is cached."""
    rng, rows = np.random.default_rng(), []
    asked: list[tuple[str, Callable[[], laws.Law]]] = [
        ("a smooth law", lambda: laws.stribeck(0.4, float(rng.uniform(0.2, 0.3)), 0.17)),
        ("a table of 5 points", lambda: _table(rng, 5)),
        ("a table of 50 points", lambda: _table(rng, 50)),
        ("a table of 500 points", lambda: _table(rng, 500)),
    ]
    samples: list[list[float]] = [[] for _ in asked]
    for _ in range(_FIRST):
        for (_, law), taken in zip(asked, samples, strict=True):
            taken.append(_seconds(lambda: _first(law())))  # noqa: B023
    for (name, _), taken in zip(asked, samples, strict=True):
        rows.append(Need(name, statistics.median(taken[1:]), 0.0))
    return tuple(rows)


def _table(rng: np.random.Generator, points: int) -> laws.Law:
    """Return a law of some points near a smooth one."""
    speeds = np.linspace(0, 1.5, points)
    values = 0.25 + 0.15 * np.exp(-speeds / 0.15) + 1e-3 * rng.random(points)
    return laws.piecewise_linear(0.41, speeds.tolist(), values.tolist())


def _first(law: laws.Law) -> None:
    scene = scenes.mass_on_belt(law, v_b=0.2, horizon=30.0).wanting({"end": End()})
    prepare(scene, _TOLERANCE, "taylor").run().checked()


def _seconds(run: Callable[[], object]) -> float:
    start = time.process_time()
    run()
    return time.process_time() - start
