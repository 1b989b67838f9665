"""What does not take contacts that open says so, with the contact and a reason."""

import pytest
import sympy as sp

import symfric as sf

X, U = sp.symbols("x u", real=True)
K = sp.Symbol("k", positive=True)


def scene():
    stop = sf.Contact("stop", None, sf.Unilateral(1 - X, restitution=0.5))
    belt = sf.Contact("belt", U - 1, 1, sf.laws.coulomb(0.3, 0.2))
    system = sf.System([X], [U], [[1]], [-K * X - U / 10 + sp.cos(sf.TIME)])
    return sf.Scene(system, [belt, stop], {K: 1.0}, {X: 0.0, U: 0.0}, 10.0)


@pytest.mark.parametrize(
    "ask",
    [
        lambda s: sf.simulate(s, route="integrators"),
        lambda s: sf.design.collocation(s, {K: (0.5, 2.0)}, {X: 0.5}, time=(1.0, 5.0)),
        lambda s: sf.design.quench(s, speeds=(0.1, 1.0), Omega=(5.0, 10.0), a=(0.0, 1.0)),
        lambda s: sf.export.stepper(s, 1e-3),
        lambda s: sf.equilibrium(s),
        lambda s: sf.stability(s),
        lambda s: sf.average(s),
        lambda s: sf.separate(s),
    ],
)
def test_refusals_name_the_contact(ask):
    with pytest.raises((sf.SceneError, sf.NoRoute), match="contact 'stop' opens|open"):
        ask(scene())


def test_explain_says_why_other_routes_decline():
    told = str(sf.explain(scene()))
    assert "taylor" in told
    assert "contact 'stop' opens and strikes" in told
