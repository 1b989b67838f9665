"""Parallel contacts of which one has no load at zero slip: it never holds what the other could not."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

X, U = sp.symbols("x u", real=True)
PATH = {"path": sf.Trajectory()}


def scene(load, order):
    k = sp.Symbol("k", positive=True)
    contacts = [
        sf.Contact("vanishing", U, load, sf.laws.coulomb(0.5, 0.4)),
        sf.Contact("b", U, 0.2, sf.laws.coulomb(0.1)),
    ]
    system = sf.System([X], [U], [[1]], [-k * X - U / 30])
    return sf.Scene(system, contacts[::order], {k: 3.0}, {X: -0.2, U: 0.7}, 4.0, PATH)


@pytest.mark.long(beside="test_they_are_one_contact")
@pytest.mark.parametrize(("load", "order"), [(sp.Abs(U) / 2, 1), (U**2, 1), (sp.Abs(U) * (1 + X**2), -1)], ids=str)
def test_contacts_of_one_slip_have_one_mode(load, order):
    fine, *programs = (sf.prepare(scene(load, order), tolerance, "taylor") for tolerance in (1e-13, 1e-10, 1e-8))
    for k, u in np.random.default_rng(7).uniform([2.0, 0.5], [4.0, 1.0], (20, 2)):
        exact = fine.run({"k": k}, {"u": u}).checked()
        for program in programs:
            run = program.run({"k": k}, {"u": u}).checked()
            assert run.final == pytest.approx(exact.final, abs=100 * program.tolerance)
            assert np.all(run.mode[0] == run.mode[1])


CANCELLING = [sp.sqrt(1 + U**2) - 1, 1 - sp.cos(U), sp.Abs(U) ** 3, (1 + U) ** 2 - 1 - 2 * U]


@pytest.mark.one_in(8)
@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("load", CANCELLING, ids=str)
def test_they_are_one_contact(load, order):
    """Coulomb contacts of one slip are one with the sum of their bounds; bounds that vanish as terms cancel too."""
    laws = {"vanishing": (load, sf.laws.coulomb(0.4)), "b": (sp.Integer(1), sf.laws.coulomb(0.3))}
    two = [sf.Contact(name, U, *laws[name]) for name in list(laws)[::order]]
    one = [sf.Contact("both", U, 0.4 * load + 0.3, sf.laws.coulomb(1))]
    system, start = sf.System([X], [U], [[1]], [-1.15 * X - 0.07 * U]), {X: -0.8, U: 0.0}
    runs = [sf.prepare(sf.Scene(system, contacts, {}, start, 4.0, PATH), 1e-11) for contacts in (two, one)]
    for x, u in [(-0.8, 0.0), (0.8, 0.0), (0.2, 0.0), (0.3, 0.9), (0.0, -0.5)]:
        split, whole = (program.run(initial={"x": x, "u": u}).checked() for program in runs)
        assert split.final == pytest.approx(whole.final, abs=1e-9)
        assert (whole.final[0] != pytest.approx(x)) == (abs(x) > 0.3 or u != 0)
