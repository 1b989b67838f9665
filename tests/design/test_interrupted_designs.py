"""Designs that are interrupted, on request, are the best ones until then, and say that nothing verified them."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.design.absorber import rough
from symfric.design.contact_damper import design as contact_damper
from symfric.design.controller import design as controller
from symfric.design.damper import settling
from symfric.design.optimal_control import collocation
from symfric.design.quench import design as quench
from tests.longer import longer

X, U, W = sp.symbols("x u w", real=True)
D, T = sp.symbols("D T", positive=True)


def sampled():
    damping = sf.Held("damping", update=sp.Max(-1, sp.Min(1, -D * U)), every=T)
    rail = sf.Contact("rail", slip=U, normal=1, law=sf.laws.coulomb(0.2))
    system = sf.System([X], [U], [[1]], [-X + damping.symbol])
    return sf.Scene(system, [rail], {D: 1, T: 0.2}, {X: 0, U: 0.4}, 60.0, held=[damping])


def block():
    floor = sf.Contact("floor", slip=U, normal=0.3, law=sf.laws.coulomb(1))
    return sf.Scene(sf.System([X], [U], [[1]], [W]), [floor], {W: 0.0}, {X: 0.0, U: 0.0}, 1.0)


CALLS = {
    "contact_damper": (
        (contact_damper, "_design"),
        lambda: sf.design.contact_damper(sf.scenes.contact_damper(f_n=5, mu_m=0.1), {"mu_m": (0.05, 0.2)}),
    ),
    "damper": (
        (settling, "_design"),
        lambda: sf.design.damper(sf.scenes.mass_on_belt(v_b=0.6, horizon=60.0), "beta", (0.3, 1.0), settle=20.0,
                                 half_range=1e-3),
    ),
    "quench": (
        (quench, "checked"),
        lambda: sf.design.quench(sf.scenes.mass_on_belt(v_b=0.2), (0.05, 0.4), Omega=(50, 50), a=(0, 0.01)),
    ),
    "controller": (
        (controller, "_result"),
        lambda: sf.design.controller(sampled(), "D", bounds=(9, 12)),
    ),
    "collocation": (
        (collocation, "_replayed"),
        lambda: sf.design.collocation(block(), {"w": (-1, 1)}, end={"x": 1, "u": 0}, time=(0.1, 10)),
    ),
}  # fmt: skip


def interrupted(*_, **__):
    raise KeyboardInterrupt


@pytest.mark.parametrize("name", longer(CALLS, [name for name in CALLS if name != "quench"]))
def test_the_design_before_its_verification_is_kept(name, monkeypatch, caplog):
    (module, part), call = CALLS[name]
    whole = call()
    monkeypatch.setattr(module, part, interrupted)
    with pytest.raises(KeyboardInterrupt):
        call()
    with sf.keep_when_interrupted():
        kept = call()
    assert kept.status == "unverified"
    assert "interrupted" in kept.doubts[0]
    assert kept.values == pytest.approx(whole.values, rel=1e-9)
    assert kept.objective == pytest.approx(whole.objective, rel=1e-9)
    assert kept.to_dict()["check"]["agrees"] is False
    assert f"{name} was interrupted" in caplog.text
    repr(kept)
    kept.plot()


@pytest.mark.long(beside="test_the_best_absorber_with_friction_until_then_is_kept")
def test_of_an_interrupted_survey_the_best_is_kept(monkeypatch):
    """Earlier interrupts keep designs that are no better, and none is kept before the first is known."""
    call = CALLS["contact_damper"][1]
    whole, simulate = call(), contact_damper.Damper.__call__
    left = 0

    def counted(self, p):
        nonlocal left
        left -= 1
        if left < 0:
            raise KeyboardInterrupt
        return simulate(self, p)

    monkeypatch.setattr(contact_damper.Damper, "__call__", counted)
    times = []
    with sf.keep_when_interrupted():
        for left in (400, 900):  # noqa: B007
            kept = call()
            times.append(kept.objective)
            assert kept.objective == np.nanmin(kept.curve.y)
        left = 0
        with pytest.raises(KeyboardInterrupt):
            call()
    assert times[0] >= times[1] >= whole.objective


def test_the_best_absorber_with_friction_until_then_is_kept(monkeypatch):
    monkeypatch.setattr(rough, "_design", interrupted)
    monkeypatch.setattr(rough, "_polled", interrupted)
    monkeypatch.setattr(rough, "BUDGET", 400)
    monkeypatch.setattr(rough, "TUNINGS", np.array([1.0]))
    monkeypatch.setattr(rough, "DAMPINGS", np.array([0.8, 1.0]))
    with sf.keep_when_interrupted():
        kept = sf.design.absorber(0.1, contact="absorber", friction=0.1, band=(0.8, 1.2))
    assert kept.status == "unverified"
    assert kept.objective == kept.curve.y.max() > 1
    kept.plot()
