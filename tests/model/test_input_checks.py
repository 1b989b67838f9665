"""Every check of user input: the message names the thing and the cure."""

import math

import numpy as np
import pytest
import sympy as sp

import symfric as sf

X, U, Y, W, Z = sp.symbols("x u y w z", real=True)
K, V_B = sp.symbols("k v_b", positive=True)
LAW = sf.laws.coulomb(0.3)
v = sf.SPEED


def scene(force=-K * X, slip=U - V_B, normal=1, law=LAW, profile=1, **changes):
    """A mass on a spring and a belt, with something wrong."""
    parts = {
        "system": sf.System(q=[X], u=[U], mass=[[1]], force=[force]),
        "contacts": [sf.Contact("belt", slip, normal, law, profile)],
        "values": {K: 1.0, V_B: 0.2},
        "initial": {X: 0.0, U: 0.0},
        "horizon": 10.0,
    }
    return sf.Scene(**{**parts, **changes})


def system(**changes):
    return sf.System(**{"q": [X], "u": [U], "mass": [[1]], "force": [-X], **changes})


def test_the_sound_scene_is_accepted():
    assert scene().values == {K: 1.0, V_B: 0.2}


VALUES = {
    "missing": ({K: 1.0}, r"no value for v_b; add it to Scene.values"),
    "misspelled": ({"k": 1.0, "vb": 0.2}, r"no value for v_b; add it to Scene.values; did you mean vb\?"),
    "unused": ({K: 1.0, V_B: 0.2, "beta": 0.1}, "value beta is used by no expression"),
    "unused, near": ({K: 1.0, V_B: 0.2, "v_bb": 0.1}, r"value v_bb is used by no expression; did you mean v_b\?"),
    "a string": ({K: "1.0", V_B: 0.2}, "the value of k is '1.0', not a number; give a plain number"),
    "a boolean": ({K: True, V_B: 0.2}, "the value of k is True, not a number"),
    "a list": ({K: [1.0], V_B: 0.2}, r"the value of k is \[1.0\], not a number"),
    "complex": ({K: 1j, V_B: 0.2}, "the value of k is 1j, not a number"),
    "an expression": ({K: X + 1, V_B: 0.2}, r"the value of k is the expression x \+ 1, not a number"),
    "imaginary": ({K: sp.I, V_B: 0.2}, "the value of k is I; it must be real"),
    "NaN": ({K: math.nan, V_B: 0.2}, "the value of k is nan; it must be finite"),
    "infinite": ({K: math.inf, V_B: 0.2}, "the value of k is inf; it must be finite"),
    "a state": ({K: 1.0, V_B: 0.2, "x": 1.0}, r"x is a state; its start belongs in Scene.initial"),
    "given twice": ({K: 1.0, V_B: 0.2, "k": 1.0}, "given twice"),
    "no name": ({K: 1.0, V_B: 0.2, 3: 1.0}, "3 is no name"),
}


@pytest.mark.parametrize("what", VALUES)
def test_values(what):
    values, message = VALUES[what]
    with pytest.raises(sf.SceneError, match=message):
        scene(values=values)


INITIAL = {
    "missing": ({X: 0.0}, r"no initial value for u; add it to Scene.initial"),
    "misspelled": ({X: 0.0, "uu": 0.0}, r"uu in Scene.initial is no state; did you mean u\?"),
    "unknown": ({X: 0.0, U: 0.0, "phi": 0.0}, "phi in Scene.initial is no state; known: u, x"),
    "NaN": ({X: math.nan, U: 0.0}, "the initial value of x is nan; it must be finite"),
    "a string": ({X: "0", U: 0.0}, "the initial value of x is '0', not a number"),
    "of a state": ({X: U, U: 0.0}, "the initial value of x is u; it may depend on parameters only"),
    "infinite": ({X: 1 / (K - 1), U: 0.0}, "the initial value of x"),
}


@pytest.mark.parametrize("what", INITIAL)
def test_initial(what):
    initial, message = INITIAL[what]
    with pytest.raises(sf.SceneError, match=message):
        scene(initial=initial)


@pytest.mark.parametrize(
    ("horizon", "message"),
    [(0, "horizon is 0.0; it must be positive"), (-1, "must be positive"), (math.inf, "must be finite"), ("1", "'1'")],
)
def test_horizon(horizon, message):
    with pytest.raises(sf.SceneError, match=message):
        scene(horizon=horizon)


@pytest.mark.parametrize(
    ("jump", "name"),
    [
        (sp.sign(U), "sign"),
        (sp.Heaviside(X), "Heaviside"),
        (sp.floor(X), "floor"),
        (sp.ceiling(X), "ceiling"),
        (sp.Mod(X, 1), "Mod"),
        (sp.DiracDelta(X), "DiracDelta"),
        (X * sp.exp(sp.sign(U - V_B)), "sign"),
    ],
)
def test_jumps_in_forces_are_contacts(jump, name):
    with pytest.raises(
        sf.SceneError, match=rf"force\[0\] contains {name}.*which jumps; dry friction enters as a Contact"
    ):
        system(force=[-K * X + jump])


@pytest.mark.parametrize("place", ["slip", "normal", "profile"])
def test_jumps_in_contacts(place):
    with pytest.raises(sf.SceneError, match=f"{place} of contact 'belt' contains sign"):
        scene(**{place: U + sp.sign(X)})


def test_jumps_in_rates_and_laws():
    with pytest.raises(sf.SceneError, match=r"z_rate\[0\] contains sign"):
        system(z=[Z], z_rate=[sp.sign(X)])
    with pytest.raises(sf.SceneError, match="law of contact 'belt' contains Heaviside"):
        scene(law=sf.laws.custom(0.3 * sp.Heaviside(v - 1), 0.3))


@pytest.mark.parametrize("place", ["force", "normal", "profile"])
def test_a_piecewise_that_jumps_is_refused_where_it_jumps(place):
    step = sp.Piecewise((1, X < sp.Rational(1, 2)), (2, True))
    with pytest.raises(sf.SceneError, match=rf"{place}.* jumps by \S+ at x = 0.5; a Piecewise must be continuous"):
        scene(**{place: step - K * X if place == "force" else step * K})


def test_a_law_that_jumps_is_refused_where_it_jumps():
    law = sf.laws.custom(sp.Piecewise((0.3, v < 1), (0.2, True)), 0.3, breaks=[1])
    with pytest.raises(sf.SceneError, match=r"law of contact 'belt' jumps by -0.1 at v = 1"):
        scene(law=law)


@pytest.mark.parametrize(
    "force",
    [
        sp.Piecewise((X, X < 1), (2 * X - 1, True)),
        sp.Abs(X) - sp.Max(X, U, 0) + sp.Min(1, X),
        sp.Piecewise((0, X < K), ((X - K) ** 2, True)),
    ],
)
def test_continuous_kinks_are_welcome(force):
    assert scene(force=force - K * X).horizon == 10


@pytest.mark.parametrize("slip", [U**2 - V_B, U * W, sp.sin(U), sp.Abs(U) - V_B, sp.sqrt(U) - V_B])
def test_slip_must_be_linear_in_the_velocities(slip):
    body = sf.System(q=[X, Y], u=[U, W], mass=sp.eye(2), force=[-K * X, -Y])
    with pytest.raises(sf.SceneError, match="slip of contact 'belt' is .*not linear in the velocities u"):
        scene(slip=slip, system=body, initial=dict.fromkeys([X, Y, U, W], 0.0))


def test_slip_may_turn_with_position_and_time():
    assert scene(slip=U * sp.cos(X) - V_B * sp.sin(sf.TIME)).contacts[0].name == "belt"


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"slip": V_B + X}, "contains no velocity"),
        ({"slip": U - V_B * v}, "slip of contact 'belt' contains v, .* which is sf.SPEED.*rename your symbol v"),
        ({"normal": -1}, "normal of contact 'belt' is -1; a normal load is not negative"),
        ({"normal": K - 2}, "normal of contact 'belt' is -1 at the start; it must not be negative"),
        ({"normal": X - K}, "normal of contact 'belt' is -1 at the start"),
        ({"normal": sp.nan}, "normal of contact 'belt' is nan; it must be finite"),
        ({"normal": "1"}, "normal of contact 'belt' is the string '1'; give a SymPy expression"),
        ({"profile": U}, "profile of contact 'belt' is u; it may depend on q only"),
        ({"profile": 1 + sp.sin(sf.TIME)}, "it may depend on q only"),
        ({"law": 0.3}, "the law of contact 'belt' is 0.3; use one of sf.laws"),
        ({"law": sf.laws.custom(0.4, 0.3)}, "static coefficient 0.3 is smaller than the kinetic one at rest, 0.4"),
    ],
)
def test_contacts(changes, message):
    with pytest.raises(sf.SceneError, match=message):
        scene(**changes)


def test_names_of_contacts():
    contact = sf.Contact("belt", U - V_B, 1, LAW)
    with pytest.raises(sf.SceneError, match="two contacts are called 'belt'; give each its own name"):
        scene(contacts=[contact, contact])
    with pytest.raises(sf.SceneError, match="name of a contact is ''"):
        sf.Contact("", U, 1, LAW)
    with pytest.raises(sf.SceneError, match="in contacts is no sf.Contact"):
        scene(contacts=[LAW])


def test_a_slip_of_first_order_states_is_refused():
    body = system(z=[Z], z_rate=[-Z])
    with pytest.raises(sf.SceneError, match="it may not depend on z"):
        scene(slip=U - Z - V_B, system=body, initial={X: 0, U: 0, Z: 0})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"q": []}, "at least one coordinate"),
        ({"u": [U, W]}, "1 coordinates in q and 2 velocities in u; give one velocity for each"),
        ({"force": [-X, 0]}, "force has 2 entries; it needs 1"),
        ({"force": []}, "force has 0 entries; it needs 1"),
        ({"z": [Z]}, "z_rate has 0 entries; it needs 1"),
        ({"mass": sp.eye(2)}, r"the mass matrix has shape \(2, 2\); 1 coordinate needs \(1, 1\)"),
        ({"mass": [[1], [2, 3]]}, "not a matrix; give mass="),
        ({"mass": [[U]]}, r"mass\[0\]\[0\] is u; it may depend on q only"),
        ({"mass": [[sp.nan]]}, r"mass\[0\]\[0\] is nan"),
        ({"mass": [[1 + sp.sign(X)]]}, r"mass\[0\] contains sign"),
        ({"force": [sp.nan]}, r"force\[0\] is nan; it must be finite"),
        ({"force": [sp.oo * X]}, r"force\[0\] is .*; it must be finite"),
        ({"force": ["-x"]}, r"force\[0\] is the string '-x'; give a SymPy expression, or use a scene file"),
        ({"force": [None]}, r"force\[0\] is None, not a SymPy expression"),
        ({"q": ["x"]}, "'x' in q is not a symbol"),
        ({"u": [X]}, "two states are called x"),
        ({"q": [sp.Symbol("t")]}, "reserved for time"),
    ],
)
def test_systems(changes, message):
    with pytest.raises(sf.SceneError, match=message):
        system(**changes)


def test_mass_matrix_must_be_symmetric_and_positive():
    with pytest.raises(sf.SceneError, match="the mass matrix is not symmetric"):
        sf.System(q=[X, Y], u=[U, W], mass=[[1, 1], [0, 1]], force=[0, 0])
    for mass in (0, -K, X):
        with pytest.raises(sf.SceneError, match="the mass matrix is not positive definite at the start"):
            scene(system=system(mass=[[mass]], force=[-K * X]))


def test_a_force_that_is_infinite_at_the_start():
    with pytest.raises(sf.SceneError, match=r"force\[0\] is \S+ at the start; it must be finite"):
        scene(force=-K / X)


@pytest.mark.parametrize("name", ["k", "x", "v_b"])
def test_one_name_for_two_symbols(name):
    twin = sp.Symbol(name)  # without the assumptions of the other
    with pytest.raises(sf.SceneError, match=f"{name} is used as two different symbols; create it once"):
        scene(force=-K * X + twin * V_B)


def named(symbol, place):
    """A scene with a symbol in one place, where it is given the value 0.2 unless it is a state."""
    parts = {"values": {K: 1.0, V_B: 0.2, symbol.name: 0.2}}
    if place in ("force", "slip", "normal", "profile"):
        parts[place] = {"force": -K * X, "slip": U - V_B, "normal": 1, "profile": 1}[place] + symbol
    elif place == "mass":
        parts["system"] = sf.System([X], [U], [[1 + symbol]], [-K * X])
    elif place == "coordinate":
        parts |= {"system": sf.System([symbol], [U], [[1]], [-K * symbol]), "initial": {symbol: 0.0, U: 0.0}}
        parts["values"] = {K: 1.0, V_B: 0.2}
    elif place == "velocity":
        parts |= {"system": sf.System([X], [symbol], [[1]], [-K * X]), "initial": {X: 0.0, symbol: 0.0}}
        parts |= {"slip": symbol - V_B, "values": {K: 1.0, V_B: 0.2}}
    elif place == "initial":
        parts["initial"] = {X: symbol, U: 0.0}
    elif place == "output":
        parts["outputs"] = {"m": sf.Max(X * symbol)}
    elif place == "input":
        parts |= {"force": -K * X + symbol, "values": {K: 1.0, V_B: 0.2}, "inputs": {symbol: sf.Signal([0, 1], 1.0)}}
    else:
        laws = {
            "static": lambda s: sf.laws.coulomb(s),
            "kinetic": lambda s: sf.laws.stribeck(0.4, s, 0.1),
            "speed": lambda s: sf.laws.cubic(0.4, 0.25, s),
            "list": lambda s: sf.laws.piecewise_linear(0.4, [0, 1], [0.3, s]),
            "memory": lambda s: sf.laws.dahl(0.3, s),
            "own": lambda s: sf.laws.custom(0.3 + s, 1.0),
        }
        parts["law"] = laws[place](symbol)
    return scene(**parts)


PLACES = (
    *("force", "slip", "normal", "profile", "mass", "coordinate", "velocity", "initial", "output", "input"),
    *("static", "kinetic", "speed", "list", "memory", "own"),
)


@pytest.mark.parametrize("place", PLACES)
def test_a_symbol_called_like_the_sliding_speed_is_renamed(place):
    with pytest.raises(sf.SceneError, match=r"\bv\b.*sf\.SPEED.*rename your symbol v"):
        named(sp.Symbol("v", positive=True), place)


@pytest.mark.parametrize("place", [e for e in PLACES if e not in ("list",)])
@pytest.mark.parametrize("kind", [{}, {"real": True}], ids=["plain", "real"])
def test_another_symbol_v_is_not_the_sliding_speed(place, kind):
    """Its scene is that of any other name."""
    made, other = (named(sp.Symbol(name, **kind), place) for name in ("v", "w"))
    assert [s.name.replace("v", "w") for s in made.values] == [s.name.replace("v", "w") for s in other.values]
    here, there = (s.contacts[0] for s in (made, other))
    swap = {sp.Symbol("w", **kind): sp.Symbol("v", **kind)}
    assert here.law.kinetic == there.law.kinetic.xreplace(swap)
    assert here.slip == there.slip.xreplace(swap)


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("kind", [{}, {"real": True}, {"positive": True}], ids=["plain", "real", "positive"])
def test_a_symbol_called_like_time_is_refused(place, kind):
    if place == "list":
        pytest.skip("breaks of numbers")
    with pytest.raises(sf.SceneError, match=r"\bt\b.*(rename|may depend on q only)"):
        named(sp.Symbol("t", **kind), place)


def test_time_itself_is_welcome_without_a_value():
    assert scene(force=-K * X + sp.sin(sf.TIME)).horizon == 10


@pytest.mark.parametrize(
    ("e", "message"),
    [
        (sp.Function("u")(sf.TIME).diff(), r"contains Derivative\(u\(t\), t\); write derivatives with states"),
        (sp.Function("x")(sf.TIME).diff(sf.TIME, 2), r"contains Derivative\(x\(t\), \(t, 2\)\); write derivatives"),
        (sp.Function("g")(X), r"contains g\(x\), a function without a formula.*sympy.Symbol\('g'\)"),
        (sf.slip("belt"), r"contains slip\(belt\), which only outputs know; write the slip itself"),
        (sf.friction_force("belt"), r"contains friction_force\(belt\), which only outputs know;.* spring"),
        (sf.stored_energy("belt"), r"contains stored_energy\(belt\), which only outputs know"),
        (sf.dissipated_power("wall"), r"contains dissipated_power\(wall\), which only outputs know"),
    ],
    ids=str,
)
@pytest.mark.parametrize("place", [e for e in PLACES if e not in ("coordinate", "velocity", "input", "output", "list")])
def test_what_an_equation_cannot_contain_is_named_with_its_place(place, e, message):
    places = {"mass": "mass", "initial": "initial value of x", "memory": "", "own": "", "static": "", "kinetic": ""}
    with pytest.raises(sf.SceneError, match=message) as told:
        named_expression(e, place)
    assert "\n" not in str(told.value)
    assert places.get(place, "" if place == "speed" else place) in str(told.value)


def named_expression(e, place):
    """A scene with an expression in one place."""
    if place in ("force", "slip", "normal", "profile"):
        return scene(**{place: {"force": -K * X, "slip": U - V_B, "normal": 1, "profile": 1}[place] + e})
    if place == "mass":
        return scene(system=sf.System([X], [U], [[1 + e]], [-K * X]))
    if place == "initial":
        return scene(initial={X: e, U: 0.0})
    laws = {
        "static": lambda: sf.laws.coulomb(0.3 + e),
        "kinetic": lambda: sf.laws.stribeck(0.4, e, 0.1),
        "speed": lambda: sf.laws.cubic(0.4, 0.25, 1 + e),
        "memory": lambda: sf.laws.dahl(0.3, 1 + e),
        "own": lambda: sf.laws.custom(0.3 + e, 1.0),
    }
    return scene(law=laws[place]())


@pytest.mark.parametrize(
    ("outputs", "message"),
    [
        ({"f": sf.Max(sf.friction_force("blet"))}, r"output 'f' uses contact 'blet'; did you mean belt\?"),
        ({"s": sf.Integral(sf.slip("wall") ** 2)}, "output 's' uses contact 'wall'; known: belt"),
        ({"m": sf.Max(sp.Symbol("y"))}, "no value for y"),
        ({"m": sf.Max}, "output 'm' is .*; use sf.End"),
        ({"m": X}, "output 'm' is x; use sf.End"),
        ({1: sf.End()}, "1 is not the name of an output; use a string"),
        ([sf.End()], "give a mapping of names"),
    ],
)
def test_outputs(outputs, message):
    with pytest.raises(sf.SceneError, match=message):
        scene(outputs=outputs)


@pytest.mark.parametrize("kind", [sf.Max, sf.Min, sf.HalfRange, sf.Integral])
def test_expressions_of_outputs(kind):
    with pytest.raises(sf.SceneError, match=f"the expression of {kind.__name__} is the string 'x'"):
        kind("x")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: sf.Signal([1.0], 0.1), r"shape \(1,\); give an array of two or more samples"),
        (lambda: sf.Signal([[1.0, 2.0]], 0.1), r"shape \(1, 2\)"),
        (lambda: sf.Signal([1.0, math.nan, 2.0], 0.1), "sample 1 of a signal is not finite"),
        (lambda: sf.Signal([1.0, 2.0], 0.0), "sampling interval dt is 0.0; it must be positive"),
        (lambda: sf.Signal([1.0, 2.0], "fast"), "sampling interval dt is 'fast', not a number"),
        (lambda: sf.Signal([1.0, 2.0], 0.1, t0=math.inf), "start t0 of a signal is inf"),
        (lambda: scene(inputs={"g": sf.Signal([0, 1], 1)}), "input g is used by no expression"),
        (lambda: scene(force=-K * X + Y, inputs={Y: [0, 1]}), r"input y is \[0, 1\]; give a sf.Signal"),
    ],
)
def test_signals(make, message):
    with pytest.raises(sf.SceneError, match=message):
        make()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: sf.laws.coulomb(-0.1), "static coefficient is -0.1.*must not be negative"),
        (lambda: sf.laws.coulomb("0.3"), "mu_s of coulomb is the string '0.3'"),
        (lambda: sf.laws.coulomb(math.nan), "nan; it must be finite"),
        (
            lambda: sf.laws.custom(0.3, 0.3, breaks=[1, 0.5]),
            "breaks of a law must increase and be positive; 0.50* follows 1",
        ),
        (lambda: sf.laws.custom(0.3, 0.3, breaks=[-1]), "must increase and be positive"),
        (lambda: sf.laws.piecewise_linear(0.3, [0, 1], [0.3]), "2 speeds and 1 values; give one value for each speed"),
        (
            lambda: sf.laws.piecewise_linear(0.3, [0.1, 1], [0.3, 0.2]),
            "first speed of a piecewise-linear law must be 0",
        ),
        (lambda: sf.laws.piecewise_linear(0.3, [], []), "first speed"),
        (lambda: sf.laws.piecewise_linear(0.3, [0], [0.3]), "needs last_slope"),
        (lambda: sf.laws.piecewise_linear(0.3, [0, 1, 0.5], [0.3, 0.2, 0.1]), "must increase; 0.5 follows 1"),
        (lambda: sf.laws.piecewise_linear(0.3, [0, 1, 1], [0.3, 0.2, 0.1]), "must increase; 1 follows 1"),
        (lambda: sf.laws.piecewise_linear(0.3, [0, 2, 1], [0.3, 0.2, 0.1], last_slope=0), "must increase; 1 follows 2"),
        (lambda: LAW.regularised(0), "v_s of a regularisation is 0; it must be positive"),
        (lambda: LAW.regularised(-1e-3), "must be positive"),
        (lambda: LAW.regularised(1e-3, "cubic"), "no regularisation of shape 'cubic'; there are linear, arctan, tanh"),
        (lambda: LAW.averaged(-1), "intensity q of the fast vibration is -1; it must not be negative"),
        (lambda: LAW.averaged("1"), "is the string '1'"),
        (lambda: sf.laws.coulomb(K)(0.1), r"the law has no number for k; use law.where"),
    ],
)
def test_laws(make, message):
    with pytest.raises(sf.SceneError, match=message):
        make()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda s: s.where({"vb": 0.3}), r"vb is no parameter of the scene; did you mean v_b\?"),
        (lambda s: s.where({"v_b": "0.3"}), "the value of v_b is '0.3', not a number"),
        (lambda s: s.where({sp.Symbol("mu"): 0.3}), "mu is no parameter of the scene; known: k, v_b"),
        (lambda s: s.starting({"xx": 0.3}), r"xx in Scene.initial is no state; did you mean x\?"),
        (lambda s: s.until(-1), "horizon is -1.0"),
        (lambda s: s.wanting({"f": sf.Max(sf.slip("bolt"))}), r"contact 'bolt'; did you mean belt\?"),
        (lambda s: s.regularised(0), "must be positive"),
    ],
)
def test_changes_of_a_scene(change, message):
    with pytest.raises(sf.SceneError, match=message):
        change(scene())


def test_values_to_be_given_later():
    belt = sf.scenes.mass_on_belt(sf.laws.coulomb(sp.Symbol("mu_s")), v_b=0.2)
    with pytest.raises(sf.SceneError, match=r"no value for mu_s; add it to Scene.values, or scene.where\(\{'mu_s'"):
        belt.numbers()
    with pytest.raises(sf.SceneError, match="no value for mu_s"):
        belt.parameter_values()
    assert belt.where({"mu_s": 0.3}).numbers()[sp.Symbol("mu_s")] == 0.3


def test_scene_of_something_else():
    with pytest.raises(sf.SceneError, match="give a sf.System"):
        scene(system="belt")


@pytest.mark.parametrize(
    "number", [1, 1.0, np.float64(1), np.int32(1), sp.Integer(1), sp.Rational(1, 2) * 2, sp.pi / sp.pi]
)
def test_all_kinds_of_numbers_are_numbers(number):
    assert scene(values={K: number, V_B: 0.2}).values[K] == 1.0


def test_errors_are_value_errors_of_one_line():
    with pytest.raises(ValueError, match="no value for v_b") as info:
        scene(values={K: 1.0})
    assert "\n" not in str(info.value)


def test_a_matrix_is_no_scalar_force():
    with pytest.raises(sf.SceneError, match=r"force\[0\] is .*not a scalar expression"):
        system(force=[sp.eye(2)])
