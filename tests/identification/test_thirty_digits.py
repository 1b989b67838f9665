"""Derivatives of every law against differences of solutions with thirty digits, while the contact slips one way."""

import mpmath as mp
import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.model.laws.memory import SIDE, SLIP
from tests.longer import longer

X, U = sp.symbols("x u", real=True)
A, B, C = sp.symbols("a b c", positive=True)
V, END = sp.Rational(6, 5), sp.Rational(3, 2)  # of the belt, which the mass never reaches
LAWS = {
    "coulomb": (sf.laws.coulomb(A, B), {"a": 0.4, "b": 0.25}),
    "stribeck": (sf.laws.stribeck(A, B, C), {"a": 0.4, "b": 0.25, "c": 0.5}),
    "lorentz": (sf.laws.lorentz(A, B, C), {"a": 0.25, "b": 0.4, "c": 0.4}),
    "gauss": (sf.laws.gauss(A, B, C), {"a": 0.25, "b": 0.8, "c": 0.4}),
    "square_root": (sf.laws.square_root(A, -B, C), {"a": 0.35, "b": 0.1, "c": 0.4}),
    "cubic": (sf.laws.cubic(A, B, C), {"a": 0.4, "b": 0.25, "c": 1.5}),
    "exponential": (sf.laws.exponential(A, B), {"a": 0.3, "b": 0.3}),
    "dahl": (sf.laws.dahl(A, B), {"a": 0.3, "b": 3.0}),
    "dahl, sharper": (sf.laws.dahl(A, B, 2), {"a": 0.3, "b": 3.0}),
    "lugre": (sf.laws.lugre(A, B, C, 20.0, 1.0, 0.1), {"a": 0.4, "b": 0.25, "c": 0.5}),
    "bouc_wen": (sf.laws.bouc_wen(A, B, C, 1), {"a": 3.0, "b": 8.0, "c": 2.0}),
    "rate_and_state": (sf.laws.rate_and_state(A, 0.02, B, C, 0.1), {"a": 0.3, "b": 0.05, "c": 0.5}),
}


def solution(law, numbers):
    """Return the displacement at the end with thirty digits."""
    memory = law.memory
    z = memory.symbols if memory else ()
    friction, rates = (memory.force, memory.rates) if memory else (-law.kinetic, ())
    slip = {SLIP: U - V, sf.SPEED: V - U, SIDE: -1}
    f, *own = ((sp.nsimplify(e) if not e.has(sp.exp) else e).xreplace(slip) for e in (friction, *rates))
    field = sp.lambdify((X, U, *z, *numbers), [U, -X - U / 20 - f, *own], "mpmath")
    start = [mp.mpf(0)] * (2 + len(z))
    return mp.odefun(lambda _, y: field(*y, *numbers.values()), 0, start)(mp.mpf(END.p) / END.q)[0]


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", longer(LAWS, set(LAWS) - {"coulomb", "dahl"}))
def test_derivatives_of_every_law_against_thirty_digits(name):
    law, values = LAWS[name]
    contact = sf.Contact("belt", U - V, 1, law)
    system = sf.System([X], [U], [[1]], [-X - U / 20])
    scene = sf.Scene(system, [contact], values, {X: 0, U: 0}, float(END), {"x": sf.Samples(X, [float(END)])})
    found = sf.simulate(scene, 1e-12, sensitivities=list(values)).output_sensitivities["x"]
    symbols = {s: s.name for s in (A, B, C) if s.name in values}
    with mp.workdps(30):
        given = {s: mp.mpf(repr(values[n])) for s, n in symbols.items()}
        step = mp.mpf(10) ** -9
        for s, n in symbols.items():
            ahead, behind = (solution(law, {**given, s: given[s] + way * step}) for way in (1, -1))
            exact = float((ahead - behind) / (2 * step))
            scale = max(abs(exact), 1e-3)
            assert np.abs(float(found[n][0]) - exact) < 1e-7 * scale, n
