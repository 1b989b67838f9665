"""Whatever is handed to a public name that it cannot use is one line: the argument, its value, what it takes."""

import logging
import pickle
import re
from inspect import isfunction, signature
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from docs.public_names import offered, public_names
from symfric.spelling import spelt

X, U = sp.symbols("x u", real=True)
K, V = sp.symbols("k v_b", positive=True)
BELT = sf.scenes.mass_on_belt(v_b=0.2, horizon=5.0)
SIZE = BELT.wanting({"m": sf.Max(BELT.system.q[0])})
LAW = sf.laws.cubic(0.4, 0.25, 0.5)
FACTORS = sf.theory.scaling.factors(4.0)
MOTION = sf.motions.sine_burst(1.0, 1.0, cycles=4)
PID = sf.scenes.positioning_stage(k_p=4.0, k_d=2.0, k_i=1.0, x0=0.5, horizon=200.0)
DRIVE = sf.scenes.drive_slide(mu1=-0.5, mu2=0.1, p_star=-0.2, epsilon=1.0, sigma=0.0)
SYSTEM = {"q": [X], "u": [U], "mass": [[1]], "force": [-K * X], "z": [], "z_rate": []}
GOOD = {
    sf.System: SYSTEM,
    sf.Contact: {"name": "c", "slip": U - V, "normal": 1, "law": LAW, "profile": 1},
    sf.Scene: {
        "system": sf.System(**SYSTEM),
        "contacts": [],
        "values": {K: 1.0},
        "initial": {X: 0.0, U: 0.0},
        "horizon": 10.0,
        "outputs": {"end": sf.End()},
        "inputs": {},
    },
    sf.Signal: {"samples": [0.0, 1.0], "dt": 0.1, "t0": 0.0},
    sf.mechanics.lagrange: {"kinetic": U**2 / 2, "potential": X**2 / 2, "loads": {X: 1}, "q": [X], "u": [U]},
    sf.scenes.mass_on_belt: {"law": LAW, "v_b": 0.2, "beta": 0.05, "horizon": 10.0},
    sf.scenes.contact_damper: {"f_n": 10.0, "mu_m": 0.1, "zeta": 0.0, "r": 1.0},
    sf.scenes.rolling_isolator: {"C": 1.0, "m": 1.0, "motion": MOTION, "profile": 0.1},
    sf.scenes.block_on_incline: {"slope": 0.2, "mu": 0.3, "speed": 1.0, "a": 1.0},
    sf.scenes.friction_pendulum: {"R": 2.0, "mu": 0.05, "m": 1.0, "motions": (MOTION, MOTION)},
    sf.scenes.drive_stop: {"mu1": -0.5, "mu2": 0.1, "lam": 4.0},
    sf.equilibrium: {"scene": BELT},
    sf.stability: {"scene": BELT},
    sf.hopf: {"scene": BELT, "parameter": "v_b", "bracket": (0.3, 0.6)},
    sf.as_function: {"scene": SIZE, "inputs": ["v_b"], "outputs": ["m"]},
    sf.design.quench: {"scene": BELT, "speeds": (0.1, 0.4), "Omega": (20, 60), "a": (0, 0.02)},
    sf.design.positioning: {"scene": DRIVE, "parameter": "sigma", "bounds": (0, 1), "speeds": (1.25, 5)},
    sf.design.controller: {"scene": PID, "parameter": "k_i", "bounds": (0.5, 6.0), "half_range": 0.1, "settle": 100.0},
    sf.design.absorber: {"mass_ratio": 0.1},
    sf.motions.synthetic: {"seed": 1, "pga": 0.3, "unit": "g"},
    sf.motions.read_at2: {"path": "x.at2"},
    sf.Max: {"expr": X},
    sf.Samples: {"expr": X, "times": [1.0, 2.0]},
    sf.theory.drive.threshold: {"mu1": -0.3, "mu2": 0.3, "p_star": -0.2},
    sf.theory.belt.onset_speed: {"scene": BELT},
    sf.structures.Structure: {"M": np.eye(2), "K": np.eye(2)},
    sf.explain: {"scene": BELT, "sensitivities": ["v_b"], "order": 1},
    sf.Taylor: {"order": 20, "max_steps": 10, "max_events": 10},
    sf.Exact: {"max_steps": 10, "max_events": 10, "general": sf.Taylor()},
    sf.Integrators: {"plugin": "erk", "max_step": 1.0, "elements": 10, "max_events": 10, "max_steps": 10},
    sf.laws.cubic: {"mu_s": 0.4, "mu_m": 0.25, "v_m": 0.5},
    sf.friction_force: {"contact": "floor", "component": 0},
    sf.control.pid: {"x": X, "ref": 1, "kp": 1, "ki": 1, "kd": 1, "every": 0.1, "rate": U, "limits": (-1, 1)},
    sf.control.dither: {"amplitude": 1, "frequency": 50, "phase": 0, "shape": "sine"},
    sf.patched_floor: {"length": 1.0, "n": 4, "mean": 0.01, "deviation": 0.002, "seed": 1},
    sf.structures.chain: {"n": 3, "mass": 1.0, "stiffness": 1.0, "damping": 0.1, "ends": "fixed", "ground": 0.0},
    sf.structures.beam: {"elements": 2, "damping": 0.1, "load": "axial", "left": "clamped", "right": "free"},
    sf.structures.write: {"structure": sf.structures.chain(2), "path": "chain.npz"},
    sf.motions.random_forcing: {"duration": 10.0, "band": (0.5, 5.0), "rms": 1.0, "number": 1, "seed": 1},
    sf.motions.sine_burst: {"pga": 1.0, "frequency": 1.0, "cycles": 4, "ramp": 1},
    sf.theory.falling_speeds: {"law": LAW},
    sf.theory.foundation.state_matrix: {"mass_ratio": 0.1, "stiffness": 0.2, "damping": 0.1, "main_damping": 0.0},
    sf.theory.absorber.state_matrix: {"mu": 0.1, "f": 0.9, "zeta": 0.2, "main_damping": 0.0},
    sf.theory.absorber.response: {"mass_ratio": 0.1, "tuning": 0.9, "damping": 0.2, "g": 1.0, "symbolic": False},
    sf.theory.symbolic_hurwitz_of_matrices: {"M": [[1]], "B": [[1]], "K": [[1]]},
}
BAD = [0.5, "y", object(), [1, 2, 3], -1.0, [], {}, np.nan, X, np.ones((2, 3)), np.array([1.0, np.nan]), sf.simulate]
REFUSALS = sf.SceneError, sf.NotFound, sf.NoRoute, sf.RunFailed
MISSPELT = [(f, name) for f, good in GOOD.items() for name in good]


@pytest.mark.one_in(18)
@pytest.mark.parametrize("function", GOOD, ids=lambda f: f.__name__)
def test_arguments_of_every_other_kind_are_one_line(function):
    for name in GOOD[function]:
        for value in BAD:
            try:
                function(**{**GOOD[function], name: value})
            except REFUSALS as refusal:
                line = str(refusal)
                assert re.fullmatch(r"[^\n]{10,400}", line), (name, value)


@pytest.mark.parametrize(("function", "name"), MISSPELT, ids=lambda p: getattr(p, "__name__", p))
def test_a_misspelt_keyword_is_named(function, name):
    given = {n: v for n, v in GOOD[function].items() if n != name} | {f"{name}_": 1}
    with pytest.raises(
        TypeError, match=rf"{function.__name__}.*unexpected .* '{name}_'(; did you mean|. Did you mean)"
    ):
        function(**given)


@pytest.mark.parametrize("name", [n for n, t in public_names().items() if isfunction(t) and signature(t).parameters])
def test_every_public_function_answers_an_unknown_keyword_with_a_cure(name):
    function = public_names()[name]
    with pytest.raises(TypeError, match=r"unexpected keyword argument 'zzz'; (known: \w|give \w+=)"):
        function(zzz=1)


def _switches():
    """Yield every public function with each of its arguments that is True or False, and what it requires besides."""
    for name, thing in public_names().items():
        if not isfunction(thing):
            continue
        known = signature(thing).parameters
        required = [n for n, p in known.items() if p.default is p.empty and p.kind is not p.VAR_KEYWORD]
        for switch, parameter in known.items():
            if parameter.annotation in (bool, "bool"):
                yield pytest.param(thing, switch, [n for n in required if n != switch], id=f"{name}-{switch}")


@pytest.mark.parametrize(("function", "switch", "required"), [*_switches()])
def test_what_is_neither_true_nor_false_is_no_switch(function, switch, required):
    """It is refused first, before the other arguments, and is never read as a yes."""
    for wrong in ([1, 2], np.ones(2), "no", None, 1.0):
        with pytest.raises((sf.SceneError, TypeError), match=rf"^{switch} is .*; give True or False$"):
            function(**dict.fromkeys(required, 1.0), **{switch: wrong})


def test_an_error_of_the_same_words_from_within_is_left_alone():
    def inner(a):
        return a

    @spelt
    def outer(b):
        return inner(c=b)

    with pytest.raises(TypeError, match=r"inner\(\) got an unexpected keyword argument 'c'$"):
        outer(1)
    with pytest.raises(TypeError, match=r"outer\(\) got an unexpected keyword argument 'a'; known: b$"):
        outer(a=1)


@pytest.mark.parametrize(
    ("wrong", "near"),
    [
        ("simulat", "simulate"),
        ("theory.belt.onset_sped", "onset_speed"),
        ("scenes.mass_on_bel", "mass_on_belt"),
        ("design.quenc", "quench"),
        ("motions.synthetc", "synthetic"),
        ("structures.flater", "flutter"),
        ("theory.transient.stop_tim", "stop_time"),
    ],
)
def test_a_misspelt_name_names_the_nearest(wrong, near):
    *path, last = wrong.split(".")
    module = sf
    for part in path:
        module = getattr(module, part)
    with pytest.raises(AttributeError, match=f"has no name '{last}'; did you mean {near}?"):
        getattr(module, last)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: sf.scenes.mass_on_belt(), r"mass_on_belt\(\) missing .*: 'v_b'"),
        (lambda: sf.System([X]), r"System.* missing .*: 'u', 'mass', and 'force'"),
        (lambda: sf.hopf(BELT), r"hopf\(\) missing .*: 'parameter' and 'bracket'"),
        (lambda: sf.laws.stribeck(0.5, 0.3), r"stribeck\(\) missing .*: 'v_s'"),
        (lambda: BELT.where(v_b=0.3), r"Scene.where\(\) got an unexpected .* 'v_b'; give values={'v_b': ...}"),
        (lambda: BELT.where("v_b", 0.3), r"takes 2 positional arguments but 3 were given; give values={'name': ...}"),
        (lambda: BELT.starting(x=0.1), r"unexpected keyword argument 'x'; give initial={'x': ...}"),
        (lambda: sf.sweep(BELT, v_b=[0.1, 0.2]), r"unexpected keyword argument 'v_b'; give grid={'v_b': ...}"),
        (lambda: sf.Scene(force=[-X]), r"unexpected keyword argument 'force'; it is an argument of sf.System"),
        (lambda: sf.simulate(BELT, max_steps=9), r"unexpected .* 'max_steps'; it is an argument of sf.Taylor"),
        (lambda: sf.simulate(BELT, rtol=1e-6), r"unexpected keyword argument 'rtol'; it is called tolerance here"),
        (lambda: sf.Contact(velocity=U), r"unexpected keyword argument 'velocity'; it is called slip here"),
        (lambda: sf.simulate(BELT, 1, 2, 3, 4, 5, 6), r"7 were given; known: order, progress, route, scene"),
        (lambda: BELT.until(), r"Scene.until\(\) missing .*: 'horizon'"),
        (lambda: BELT.until(horzon=3), r"unexpected keyword argument 'horzon'; did you mean horizon\?"),
        (
            lambda: sf.simulate(BELT, tol=1e-6),
            r"simulate\(\) got an unexpected keyword argument 'tol'; did you mean tolerance\?",
        ),
        (
            lambda: sf.simulate(BELT).plot(axes=1),
            r"Run.plot\(\) got an unexpected keyword argument 'axes'; did you mean ax",
        ),
    ],
)
def test_a_call_that_lacks_something_names_it(call, said):
    with pytest.raises(TypeError, match=said):
        call()


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: BELT.where(("v_b", 0.3)), "values is .*; give a mapping, {'name': 1.0}"),
        (lambda: BELT.where("v_b"), "values is 'v_b'; give a mapping, {'name': 1.0}"),
        (lambda: sf.simulate(BELT)("1"), "t is '1'; give numbers"),
        (lambda: LAW(["0.1"]), "give numbers"),
        (lambda: sf.Contact("c", U, 1, sf.laws.coulomb), r"is coulomb; call it: sf.laws.coulomb\(...\)"),
        (lambda: sf.System([X], [U], 1, [-X]), r"mass is 1, not a matrix; give mass=\[\[m\]\]"),
        (lambda: sf.as_function(SIZE, "v_b", ["m"]), r"inputs=\['v_b'\]"),
        (lambda: sf.as_function(SIZE, ["v_b"], "m"), r"outputs=\['m'\]"),
        (lambda: sf.design.damper(BELT.where({}), "beta", (0, 1), (1, 2), speed="w"), "speeds is the range of w"),
        (lambda: sf.scenes.rolling_isolator(C=1, m=1, motion=MOTION, profile="0.1"), "profile is '0.1'; give a number"),
        (lambda: sf.theory.transient.energy_balance(None), "run is None; give a Run"),
        (lambda: sf.theory.transient.decisions(BELT), "run is .*; give a Run"),
        (
            lambda: sf.theory.scaling.isolator_model(FACTORS, C=1, m=1, motion=[0.0, 1.0], profile=0.1),
            r"motion is \[0.0, 1.0\]; give a sf.Signal or what sf.motions reads",
        ),
        (lambda: sf.theory.scaling.returned_ratio(1.0, "2", 3.0), "prototype is '2'; give numbers"),
        (lambda: sf.theory.scaling.returned_ratio(1.0, K, "3"), "factor is '3'; give numbers"),
        (lambda: sf.structures.flutter_map([1, 2], [0.1], mu=(0, 1)), r"make is \[1, 2\]; give a function"),
        (lambda: sf.structures.flutter_map(lambda c: c, [0.1], mu=(0, 1)), r"make\(0.1\) is 0.1; give a Structure"),
        (lambda: sf.laws.piecewise_linear(0.4, [0, 1], ["a", "b"]), r"values\[0\] is the string 'a'; give a SymPy"),
        (lambda: sf.System(**SYSTEM, linear=[1.0]), r"linear is \[1.0\]; give a LinearPart"),
        (lambda: sf.System(**SYSTEM, made=0.5), "made is 0.5; give a whole number"),
        (lambda: sf.theory.waviness.slip_over_a_wave(0.4, -0.1), "hill is -0.1; it must not be negative"),
    ],
)
def test_values_of_the_wrong_kind_name_the_cure(call, said):
    with pytest.raises(sf.SceneError, match=said):
        call()


@pytest.mark.parametrize("law", ["stribeck(0.5, 0.3, {})", "cubic(0.4, 0.2, {})", "lorentz(0.4, {})", "gauss(0.4, {})"])
def test_speeds_of_laws_are_positive(law):
    for wrong in ("0", "-0.1"):
        with pytest.raises(sf.SceneError, match=r"v_\w of \w+ is -?0.*must be positive"):
            eval("sf.laws." + law.format(wrong))


def test_results_have_no_attributes_but_their_own():
    run, point = sf.simulate(BELT), sf.hopf(BELT, "v_b", (0.3, 0.6))
    for result, wrong in ((run, "xs"), (run, "energy_residul"), (point, "omegas")):
        with pytest.raises(AttributeError, match=rf"'{type(result).__name__}' object has no attribute '{wrong}'"):
            getattr(result, wrong)
        assert not hasattr(result, "_repr_svg_")
    assert pickle.loads(pickle.dumps(point)).value == point.value


@pytest.mark.parametrize(
    "module", [sf, sf.scenes, sf.theory, sf.theory.transient, sf.design, sf.motions, sf.structures, sf.export]
)
def test_helpers_do_not_show(module):
    assert [n for n in dir(module) if not n.startswith("__")] == sorted(offered(module))


def test_single_things_where_lists_are_meant_show_the_list():
    for name, value in (("q", X), ("u", U), ("force", -X)):
        with pytest.raises(sf.SceneError, match=re.escape(f"give a list, {name}=[")):
            sf.System(**{**SYSTEM, name: value})
    with pytest.raises(sf.SceneError, match=re.escape("give mass=[[m]]")):
        sf.System(**{**SYSTEM, "mass": 1})
    with pytest.raises(sf.SceneError, match=re.escape("bracket=(lower, upper)")):
        sf.hopf(BELT, "v_b", bracket=0.5)
    with pytest.raises(sf.SceneError, match="ax is 'y'; plot takes the matplotlib Axes"):
        sf.simulate(BELT).plot("y")
    with pytest.raises(sf.SceneError, match="sf.read"):
        sf.simulate("belt.toml")


@pytest.mark.parametrize(
    ("call", "function"),
    [
        (lambda: BELT.where("v_b"), "where"),
        (lambda: BELT.parameter("v"), "parameter"),
        (lambda: sf.Max("x"), "__post_init__"),
        (lambda: sf.motions.sine_burst(1.0, "f"), "sine_burst"),
        (lambda: sf.theory.belt.onset_speed("belt"), "evaluated"),
        (lambda: sf.scenes.mass_on_belt(v_b="fast"), "mass_on_belt"),
        (lambda: sf.hopf("belt.toml", "v_b", (0.3, 0.6)), "hopf"),
    ],
)
def test_a_traceback_shows_the_line_of_the_user_and_then_the_function_that_was_called(call, function):
    with pytest.raises(sf.SceneError) as caught:
        call()
    frames = [(Path(e.path).name, e.frame.code.name) for e in caught.traceback]
    ours = [name for file, name in frames[2:] if file not in ("locks.py", "long_calls.py", "spelling.py", "<string>")]
    assert frames[1][0] == Path(__file__).name
    assert ours[0] == function


def test_public_names_keep_their_signature_and_can_be_pickled():
    assert list(signature(sf.simulate).parameters)[:2] == ["scene", "tolerance"]
    for thing in (sf.simulate, sf.scenes.mass_on_belt, sf.theory.stability, sf.Scene):
        assert pickle.loads(pickle.dumps(thing)) is thing


def test_a_call_of_over_a_second_is_logged(caplog, monkeypatch):
    monkeypatch.setattr("symfric.long_calls.PATIENCE", 0.0)
    with caplog.at_level(logging.INFO, "symfric"):
        sf.stability(BELT)
    assert re.search(r"stability: \d", caplog.text)
    caplog.clear()
    sf.stability(BELT)
    assert caplog.text == ""
