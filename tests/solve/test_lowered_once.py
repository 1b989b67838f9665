"""Selection and programs share one lowering of a scene, and routes answer for derivatives as they do for values."""

import pytest
import sympy as sp

import symfric as sf
from symfric.lower.contact_dynamics import ContactDynamics
from symfric.solve.lowered import LoweredScene

X, U = sp.symbols("x u", real=True)
BELT = sf.scenes.mass_on_belt(v_b=0.2, a=0.0, horizon=3.0)
BRISTLES = sf.Scene(
    sf.System([X], [U], [[1]], [-X - U / 10]),
    [sf.Contact("belt", U - sp.Rational(1, 5), 1, sf.laws.lugre(0.4, 0.3, 0.1, 200.0, 5.0, 0.1))],
    initial={X: 1.0, U: 0.0},
    horizon=1.0,
)


@pytest.fixture
def lowerings(monkeypatch):
    scenes, of = [], ContactDynamics.of
    monkeypatch.setattr(ContactDynamics, "of", lambda scene, *given: scenes.append(scene) or of(scene, *given))
    return scenes


@pytest.mark.one_in(3)
@pytest.mark.parametrize("route", [None, "taylor"])
@pytest.mark.parametrize(("names", "order"), [((), 1), (("v_b", "x"), 1), (("a",), 2)])
def test_a_scene_is_lowered_once(lowerings, route, names, order):
    sf.simulate(BELT, 1e-6, route, names, order=order)
    assert len(lowerings) == 1


def test_extremes_beside_derivatives_share_the_equations(lowerings):
    scene = BRISTLES.wanting({"top": sf.Max(X), "path": sf.Trajectory()})
    run = sf.simulate(scene, 1e-6, sf.Integrators("cvodes"), ["x"])
    assert run.output_sensitivities["top"]["x"] == pytest.approx(1.0)
    assert len(lowerings) == 1


@pytest.mark.parametrize(
    ("scene", "route", "order", "reason"),
    [
        (sf.scenes.coulomb_oscillator(0.1), "exact", 1, "'exact' declines: computes no derivatives"),
        (BELT, "integrators", 1, "'integrators' declines: cvodes has no events"),
        (BRISTLES, "integrators", 2, "'integrators' declines: computes no second derivatives"),
        (BRISTLES, sf.Integrators("erk"), 1, "'integrators' declines: erk computes no derivatives, cvodes does"),
    ],
)
def test_a_route_declines_derivatives_in_the_words_of_its_answer(scene, route, order, reason):
    with pytest.raises(sf.NoRoute, match=reason) as refusal:
        sf.prepare(scene, route=route, sensitivities=["x"], order=order)
    settings = (
        route if isinstance(route, sf.Integrators) else {"exact": sf.Exact(), "integrators": sf.Integrators()}[route]
    )
    answer = settings.answer(LoweredScene(scene, directions=("x",), order=order))
    assert not answer.takes
    assert answer.words in str(refusal.value)


def test_a_parameter_that_is_zero_is_no_longer_dropped_if_it_is_a_direction():
    assert "a" in sf.explain(BELT).facts.dropped
    assert "a" not in sf.explain(BELT, sensitivities=["a"]).facts.dropped
