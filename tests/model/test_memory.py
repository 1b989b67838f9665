"""Laws with memory in a scene: states made, named, started and shown, with bad input in one line."""

import pytest
import sympy as sp

import symfric as sf
from symfric.scenefile import read_scene_text

X, U = sp.symbols("x u", real=True)
V = sp.Symbol("v_b", positive=True)
LUGRE = sf.laws.lugre(0.4, 0.25, 0.1, 1000.0, 10.0)
LAWS = {
    "dahl": sf.laws.dahl(0.3, 1000.0),
    "dahl of order 2": sf.laws.dahl(0.3, 1000.0, exponent=2),
    "lugre": LUGRE,
    "elasto_plastic": sf.laws.elasto_plastic(0.4, 0.25, 0.1, 1000.0, 10.0, z_ba=1e-4),
}


def scene(law, **changes):
    given = {"initial": {X: 0.0, U: 0.0}, "horizon": 10.0, "values": {V: 0.2}} | changes
    return sf.Scene(sf.System([X], [U], [[1]], [-X]), [sf.Contact("belt", U - V, 1, law)], **given)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_the_state_is_made_named_and_starts_at_zero(law):
    made = scene(law)
    assert [s.name for s in made.system.states] == ["x", "u", "belt.z"]
    assert made.numbers()[made.contacts[0].states[0]] == 0.0
    assert len(made.equations()) == 3
    assert r"z_{belt}" in made._repr_latex_()


def test_a_start_is_given_by_name_and_kept():
    made = scene(LUGRE, initial={X: 0.0, U: 0.0, "belt.z": 1e-4})
    for changed in (made.where({"v_b": 0.3}), made.until(20.0), made.wanting({"end": sf.End()})):
        assert changed.numbers()[changed.system.z[-1]] == 1e-4
        assert changed.system == made.system
    assert made.starting({"belt.z": 2e-4}).numbers()[made.system.z[-1]] == 2e-4
    run = sf.simulate(made.until(1e-3).wanting({"path": sf.Trajectory()}))
    assert run.names == ("x", "u", "belt.z")
    assert run["belt.z"][0] == 1e-4


def test_states_stand_behind_those_of_the_system_in_the_order_of_the_contacts():
    z = sp.Symbol("z", real=True)
    system = sf.System([X], [U], [[1]], [-X - z], [z], [U - z])
    contacts = [sf.Contact(n, U - V, 1, law) for n, law in (("a", LUGRE), ("b", sf.laws.coulomb(0.1)), ("c", LUGRE))]
    made = sf.Scene(system, contacts, {V: 0.2}, {X: 0.0, U: 0.0, z: 0.0}, 1.0)
    assert [s.name for s in made.system.z] == ["z", "a.z", "c.z"]
    fewer = sf.Scene(made.system, contacts[1:], {V: 0.2}, {X: 0.0, U: 0.0, z: 0.0}, 1.0)
    assert [s.name for s in fewer.system.z] == ["z", "c.z"]


def test_parameters_of_the_law_are_parameters_of_the_scene():
    s0 = sp.Symbol("sigma0", positive=True)
    made = scene(sf.laws.lugre(0.4, 0.25, 0.1, s0), values={V: 0.2, s0: 100.0})
    assert {s.name for s in made.parameters} == {"v_b", "sigma0"}
    with pytest.raises(sf.SceneError, match="no value for sigma0"):
        scene(sf.laws.lugre(0.4, 0.25, 0.1, s0))
    assert made.contacts[0].law.where({"sigma0": 50}).stiffness == 50


def test_steady_coefficient_and_stiffness():
    law = sf.laws.lugre(1.5, 1.0, 0.001, 1e5, 300.0, 0.4)
    assert law(0.001) == pytest.approx(1.1843397205857, rel=1e-13)
    assert law.steady.free_symbols == {sf.SPEED}
    assert law.stiffness == 1e5
    assert sf.laws.coulomb(0.3).stiffness == sp.oo
    assert sf.laws.coulomb(0.3).steady == 0.3 == sf.laws.dahl(0.3, 10.0).steady


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: sf.laws.dahl(0.0, 10.0), "mu_c of dahl is 0.*; it must be positive"),
        (lambda: sf.laws.dahl(0.3, -1), "sigma of dahl is -1"),
        (lambda: sf.laws.dahl(0.3, 10.0, 0.5), "exponent of dahl is 0.5.*at least 1"),
        (lambda: sf.laws.lugre(0.2, 0.3, 0.1, 10.0), "mu_s of lugre is 0.2.*must not be below mu_c"),
        (lambda: sf.laws.lugre(0.4, 0.3, 0.1, 10.0, -1.0), "sigma1 of lugre is -1.*must not be negative"),
        (lambda: sf.laws.elasto_plastic(0.4, 0.3, 0.1, 10.0, z_ba=0.04), "z_ba of elasto_plastic is 0.04"),
        (lambda: LUGRE.averaged(0.1), "has memory"),
        (lambda: scene(LUGRE, initial={X: 0.0, U: 0.0, "belt.y": 0.0}), "belt.y in Scene.initial is no state; did you"),
        (lambda: scene(LUGRE, initial={X: 0.0, U: 0.0, "belt.z": float("nan")}), "initial value of belt.z is nan"),
        (lambda: sf.average(scene(LUGRE)), "averaging takes one coordinate"),
    ],
)
def test_bad_input_in_one_line(make, words):
    with pytest.raises(sf.SceneError, match=words):
        make()


def test_a_law_with_memory_has_no_jump_to_regularise():
    assert LUGRE.regularised(1e-3) is LUGRE
    both = sf.Scene(
        sf.System([X], [U], [[1]], [-X]),
        [sf.Contact("a", U - V, 1, LUGRE), sf.Contact("b", U - V, 1, sf.laws.coulomb(0.2))],
        {V: 0.2},
        {X: 0.0, U: 0.0},
        1.0,
    ).regularised(1e-2)
    assert all(c.law.smooth for c in both.contacts)


FILE = """
[scene]
coordinates = ["x"]
velocities = ["u"]
mass = [[1]]
force = ["-x"]
initial = {x = 0, u = 0, START}
horizon = 10

[values]
v_b = 0.2

[friction.belt]
law = "lugre"
slip = "u - v_b"
normal = 1
mu_s = 0.4
mu_c = 0.25
v_s = 0.1
sigma0 = 1000
sigma1 = 10

[outputs]
deepest = "min(belt.z)"
heat = 'integral(dissipated_power("belt"))'
"""


@pytest.mark.parametrize("start", ['"belt.z" = 1e-4', "belt.z = 1e-4"])
def test_a_scene_file_starts_and_reads_the_state(start):
    made = read_scene_text(FILE.replace("START", start)).scene
    assert made.numbers()[made.system.z[-1]] == 1e-4
    run = sf.simulate(made)
    assert -0.4 / 1000 < run["deepest"] < -0.25 / 1000
    assert run["heat"] > 0


def test_a_scene_file_names_an_unknown_state():
    with pytest.raises(sf.SceneError, match="a dot after a name"):
        read_scene_text(FILE.replace("START", "belt.z = 0").replace("min(belt.z)", "min(belt.y)"))
