"""Values given to a run or a sweep must satisfy what those of a scene must: what a scene refuses no run answers with OK."""

import inspect

import numpy as np
import pytest
import sympy as sp

import symfric as sf

x, u, y, w = sp.symbols("x u y w", real=True)
P = sp.Symbol("P", real=True)
LAWS = sf.laws
GOOD_AND_BAD = {  # a law with one parameter left open, a value that it takes, and values that it does not
    "lorentz": (LAWS.lorentz(0.4, P), 0.1, [0.0, -0.1]),
    "gauss": (LAWS.gauss(0.4, P), 0.1, [0.0, -0.1]),
    "stribeck": (LAWS.stribeck(0.4, 0.2, P), 0.1, [0.0, -0.1]),
    "cubic": (LAWS.cubic(0.4, 0.2, P), 0.5, [0.0, -0.5]),
    "exponential": (LAWS.exponential(0.4, P), 0.5, [0.0, -0.5]),
    "thomsen": (LAWS.thomsen_regularised(0.4, 0.2, 0.5, P), 0.01, [0.0, -0.1, 0.5, 0.6]),
    "line": (LAWS.piecewise_linear(0.4, [0, P, 1.0], [0.4, 0.3, 0.2]), 0.5, [0.0, -0.5, 1.0, 1.5]),
    "regularised": (LAWS.coulomb(0.4).regularised(P), 0.01, [0.0, -0.01]),
    "tanh": (LAWS.coulomb(0.4).regularised(P, "tanh"), 0.01, [0.0, -0.01]),
    "regularised stribeck": (LAWS.stribeck(0.4, 0.2, P).regularised(0.01), 0.1, [0.0, -0.1]),
    "averaged": (LAWS.cubic(0.4, 0.2, P).averaged(0.3), 0.5, [0.0, -0.5]),
    "dahl": (LAWS.dahl(0.4, P), 100.0, [0.0, -100.0]),
    "dahl, coefficient": (LAWS.dahl(P, 100.0), 0.4, [0.0, -0.4]),
    "lugre": (LAWS.lugre(0.4, 0.3, 0.1, P), 100.0, [0.0, -100.0]),
    "lugre, speed": (LAWS.lugre(0.4, 0.3, P, 100.0), 0.1, [0.0, -0.1]),
    "lugre, damping": (LAWS.lugre(0.4, 0.3, 0.1, 100.0, P), 0.0, [-1.0]),
    "lugre, static": (LAWS.lugre(P, 0.3, 0.1, 100.0), 0.3, [0.2]),
    "elasto-plastic": (LAWS.elasto_plastic(0.4, 0.3, 0.1, 100.0, z_ba=P), 0.002, [0.0, 0.003, 0.004]),
    "maxwell": (LAWS.maxwell_slip([100, P], [0.1, 0.2]), 50.0, [0.0, -50.0]),
    "maxwell, limit": (LAWS.maxwell_slip([100, 50], [0.1, P]), 0.2, [0.0, -0.2]),
    "iwan": (LAWS.iwan(1.0, P, 0.5, 3), -0.5, [-1.0, -1.5]),
    "bouc-wen": (LAWS.bouc_wen(100.0, 300.0, P, 1), 200.0, [-300.0, -400.0]),
    "rate and state": (LAWS.rate_and_state(0.6, 0.01, 0.015, P, 1e-2), 0.1, [0.0, -0.1]),
}


def scene(law, value, **more):
    contact = sf.Contact("floor", u, 1, law, **more)
    system = sf.System([x], [u], [[1]], [-x])
    return sf.Scene(system, [contact], {P: value}, {x: 1.0, u: 0.5}, 1.0, outputs={"end": sf.Max(x)})


def in_plane(value):
    table = sf.Contact("table", (u, w), 1, LAWS.coulomb(0.2), ellipse=(1, P))
    system = sf.System([x, y], [u, w], sp.eye(2), [-x, -2 * y])
    return sf.Scene(system, [table], {P: value}, {x: 1, y: 0.5, u: 0, w: 0.3}, 1.0, outputs={"end": sf.Max(x)})


def refused(make, good, bad, said):
    """Assert that scene, program and sweep take the good value and no bad one."""
    program = sf.prepare(make(good))
    assert program.run().status == sf.Status.OK
    for value in bad:
        with pytest.raises(sf.SceneError, match=said):
            make(value)
        with pytest.raises(sf.SceneError, match=said):
            make(good).where({"P": value})
        with pytest.raises(sf.SceneError, match=said):
            program.run({"P": value})
    table = sf.sweep(make(good), {"P": np.array([good, *bad])})
    assert table["status"].values.tolist() == [sf.Status.OK, *len(bad) * [-1]]  # values that the scene refuses
    assert np.isnan(table["end"].values[1:]).all()


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", GOOD_AND_BAD)
def test_parameters_of_laws(name):
    law, good, bad = GOOD_AND_BAD[name]
    refused(lambda value: scene(law, value), good, bad, "law of contact 'floor': .*must (be positive|not be negative)")
    for value in bad:
        with pytest.raises(sf.SceneError):
            law.where({"P": value})


def test_numbers_of_contacts():
    refused(
        lambda v: scene(LAWS.coulomb(0.2), v, stiffness=P),
        10.0,
        [0.0, -5.0],
        "stiffness of contact 'floor' is .*positive",
    )
    refused(in_plane, 0.5, [0.0, -0.5], "ellipse of contact 'table' is .*positive")


def test_what_a_docstring_asks_for_is_asked_for():
    """A parameter that a docstring calls positive, or a speed over which friction changes, is among the requirements."""
    missing = []
    for name in set(LAWS.__all__) - {"Law", "SHAPES"}:
        made = getattr(LAWS, name)
        parameters = {k: p for k, p in inspect.signature(made).parameters.items() if "Parameter" in str(p.annotation)}
        for parameter, text in documented(made).items():
            if parameter in parameters and (", > 0" in text or "over which friction" in text):
                symbols = {k: sp.Symbol(k) for k in parameters}
                law = made(**symbols, **({"elements": 2} if name == "iwan" else {}))
                if not any(e.value == symbols[parameter] and not e.zero for e in law.requirements):
                    missing.append((name, parameter))
    assert not missing


def documented(made):
    """Return what the docstring of a law says of each parameter."""
    lines = inspect.getdoc(made).partition("Parameters\n")[2].partition("Returns\n")[0].splitlines()[1:]
    said, names = {}, []
    for line in lines:
        if line and not line.startswith(" "):
            names = [n.strip() for n in line.split(":")[0].split(",")]
        for name in names:
            said[name] = said.get(name, "") + " " + line.strip()
    return said
