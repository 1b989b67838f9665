"""Controllers without hunting: closed forms of the border, motions on both sides of it, and what is refused."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from tests.orbits.test_sampled_cycles import border, made

x, u = sp.symbols("x u", real=True)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("k_p", "k_d", "allowed"), [(4.0, 4.0, 0.1), (4.0, 2.0, 0.1), (4.0, 3.0, 0.1)])
def test_the_offset_of_a_continuous_pid_is_that_of_the_closed_form(k_p, k_d, allowed):
    stage = sf.scenes.positioning_stage(k_p=k_p, k_d=k_d, k_i=1.0, x0=0.5, horizon=300.0)
    found = sf.design.controller(stage, "k_i", (0.5, 0.9 * k_p * k_d), half_range=allowed, settle=150.0)
    assert found.status == "optimal"
    told = sf.theory.hunting(k_p=k_p, k_d=k_d, k_i=found.values["k_i"], F_s=1.5, F_c=1.0)
    assert told.offset == pytest.approx(allowed, rel=1e-6)
    assert found.active == (f"half range {allowed:g} after t = 150",)


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("name", "bounds"), [("D", (1, 30)), ("T", (0.02, 0.4))])
def test_the_border_of_a_sampled_damper_lies_where_its_cycle_appears(name, bounds):
    found = sf.design.controller(made(False).starting({"u": 0.4}), name, bounds)
    edge = border(name)
    assert found.status == "optimal"
    assert found.values[name] == pytest.approx(edge, rel=2e-5)
    assert found.curve.marks == (found.values[name],)
    assert str(found.check).startswith("a little below, 50 motions settle")


@pytest.mark.long(beside="test_a_bound_that_no_motion_violates_is_the_answer")
def test_a_range_of_periods_is_decided_by_the_slowest_clock():
    starts = {"u": [0.1, 0.2, 0.4], "cmd": [1.0]}
    found = sf.design.controller(made(False), "D", (1, 30), (0.1, 0.2), starts=starts)
    assert found.active == ("hunting at T = 0.2",)
    assert np.all(np.diff(found.curve.y) < 0)
    single = sf.design.controller(made(False).where({"T": 0.2}), "D", (1, 30), starts=starts)
    assert single.values["D"] == pytest.approx(found.values["D"], rel=0.01)
    ax = found.plot()
    assert ax.get_xlabel() == "T"


def test_a_bound_that_no_motion_violates_is_the_answer():
    found = sf.design.controller(made(False), "D", (1, 5))
    assert found.values == {"D": 5.0}
    assert found.active == ("D at its upper bound",)
    assert found.status == "optimal"


def test_a_loop_that_grows_for_ever_does_not_settle():
    command = sf.Held("cmd", -20 * x - 2 * u, every=sp.Symbol("T", positive=True))
    guide = sf.Contact("guide", u, 1, sf.laws.stribeck(0.3, 0.2, 0.1))
    scene = sf.Scene(
        sf.System([x], [u], [[1]], [command.symbol]),
        [guide],
        {sp.Symbol("T", positive=True): 0.01},
        {x: 1.0, u: 0.0},
        20.0,
        held=[command],
    )
    found = sf.design.controller(scene, "T", (0.02, 1.0))
    assert found.status == "optimal"
    assert 0.05 < found.values["T"] < 0.3
    with pytest.raises(sf.NotFound, match=r"even at T = 0.5"):
        sf.design.controller(scene, "T", (0.5, 1.0))


def test_what_is_refused():
    scene = made(False)
    for arguments, message in (
        ({"bounds": (3, 1)}, "give 0 <= low < high"),
        ({"settle": 200.0}, "between 0 and the horizon"),
        ({"half_range": -1.0}, "must not be negative"),
        ({"starts": {"y": [1.0]}}, "y in starts is no state"),
        ({"starts": {}}, "starts names no values"),
        ({"periods": (0.1, 0.2), "period": "D"}, "give period='...' another name"),
    ):
        with pytest.raises(sf.SceneError, match=message):
            sf.design.controller(scene, "D", **{"bounds": (1, 30), **arguments})
    with pytest.raises(sf.SceneError, match="starts at rest at zero"):
        sf.design.controller(scene.starting({"u": 0.0}), "D", (1, 30))
