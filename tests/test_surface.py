"""Every public function that takes a scene, on scenes of every shape: a right answer, or one line that names the cure.

Without contacts, without kinks, without parameters, with first-order states, with one coordinate or twenty.
"""

import inspect
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import symfric as sf
from symfric.report.study.study import study
from symfric.scenefile import read_scene_text

X, U, Z = sp.symbols("x u z", real=True)
P, W, V = sp.symbols("p w v_b", positive=True)
T = sf.TIME
CUBIC = sf.laws.cubic(0.4, 0.25, 0.5)
REFUSALS = sf.SceneError, sf.NotFound, sf.NoRoute, sf.RunFailed


def scene(force, contacts=(), values=None, z=(), z_rate=(), inputs=None):
    initial = {X: 1.0, U: 0.0, **dict.fromkeys(z, 0.0)}
    system = sf.System([X], [U], [[1]], [force], z, z_rate)
    return sf.Scene(system, contacts, values or {}, initial, 40.0, inputs=inputs or {})


def twenty(contacts=(), forced=False):
    """A chain of twenty masses, the first driven or displaced, the last perhaps on a belt."""
    n = 20
    q, u = sp.symbols(f"x1:{n + 1}", real=True), sp.symbols(f"u1:{n + 1}", real=True)
    ends = (sp.S.Zero, *q, sp.S.Zero)
    force = [ends[i] + ends[i + 2] - 2 * q[i] - u[i] / 50 for i in range(n)]
    force[0] += P * sp.cos(W * T) if forced else 0
    belt = [sf.Contact("belt", slip=u[-1] - V, normal=1, law=CUBIC)] if contacts else []
    values = {**({V: 0.2} if belt else {}), **({P: 0.3, W: 0.7} if forced else {})}
    initial = {**dict.fromkeys((*q, *u), 0.0), q[0]: 0.0 if belt or forced else 1.0}
    return sf.Scene(sf.System(q, u, sp.eye(n), force), belt, values, initial, 40.0)


BELT = [sf.Contact("belt", slip=U - V, normal=1, law=CUBIC)]
FLOOR = [sf.Contact("floor", slip=U, normal=1, law=sf.laws.coulomb(0.3, 0.2))]
SMOOTH = {
    "van der Pol": scene(-X + P * (1 - X**2) * U, values={P: 1.0}),
    "no parameter": scene(-X + (1 - X**2) * U),
    "damped": scene(-X - P * U, values={P: 0.1}),
    "undamped": scene(-X),
    "forced": scene(-X - U / 5 + P * sp.cos(W * T), values={P: 1.0, W: 1.3}),
    "forced without parameter": scene(-X - U / 5 + sp.cos(T)),
    "free": scene(sp.S.Zero),
    "falling": scene(-P, values={P: 1.0}),
    "transient": scene(-X - U / 10 + sp.exp(-T)),
    "record": scene(-X - U / 10 + P, inputs={P: sf.Signal([0.0, 1.0, 0.0, -1.0, 0.0], 0.5)}),
    "first order": scene(-X + P * (1 - X**2) * U + Z / 10, values={P: 0.5}, z=[Z], z_rate=[X - Z]),
    "no value": scene(-X - P * U, values={P: None}),
}
KINKED = {
    "kink": scene(-X + P * (1 - sp.Abs(X)) * U, values={P: 0.5}),
    "kink without parameter": scene(-X + (1 - sp.Abs(X)) * U),
    "stop": scene(-X - U / 10 - 10 * sp.Max(0, X - P) + sp.cos(W * T), values={P: 0.5, W: 1.2}),
    "pieces": scene(-X - U / 10 + sp.Piecewise((0, X < P), (P - X, True)) + sp.cos(T), values={P: 0.3}),
    "first order with kink": scene(-X - U / 5 - Z + P * sp.cos(T), (), {P: 0.5}, [Z], [U - sp.Abs(U) * Z]),
}
RUBBING = {
    "belt": sf.scenes.mass_on_belt(v_b=0.2, horizon=40.0),
    "floor": scene(-X - U / 10 + P * sp.cos(W * T), FLOOR, {P: 1.0, W: 1.3}),
    "floor without parameter": scene(-X, FLOOR),
    "belt and kink": scene(-X - sp.Abs(X) * X, BELT, {V: 0.2}),
    "belt and first order": scene(-X - Z / 10, BELT, {V: 0.2}, [Z], [U - Z]),
    "regularised": sf.scenes.mass_on_belt(v_b=0.2, horizon=40.0).regularised(1e-2),
}
PRESSED = sp.symbols("y v_y", real=True)
OPENING = {
    "stops": scene(-X - U / 10 + P * sp.cos(W * T), sf.stops(X, -1.2, 1.2, 0.7), {P: 1.0, W: 1.3}),
    "stop and belt": scene(-X - U / 10, [*BELT, sf.Contact("stop", None, sf.Unilateral(2 - X, 0.5))], {V: 0.2}),
    "belt pressed on": sf.Scene(
        sf.System([X, PRESSED[0]], [U, PRESSED[1]], sp.eye(2), [-X, -1 - PRESSED[0] / 10]),
        [sf.Contact("belt", slip=U - V, normal=sf.Unilateral(PRESSED[0], 0.3), law=CUBIC)],
        {V: 0.2},
        {X: 0.0, PRESSED[0]: 0.0, U: 0.0, PRESSED[1]: 0.0},
        40.0,
    ),
}
LARGE = {"twenty": twenty(), "twenty forced": twenty(forced=True), "twenty on a belt": twenty(BELT)}
SCENES = {**SMOOTH, **KINKED, **RUBBING, **OPENING, **LARGE}


def name(s):
    return s.parameters[0].name if s.parameters else "v_b"


def value(s):
    return (s.values[s.parameters[0]] if s.parameters else None) or 1.0


def around(s):
    return 0.95 * value(s), 1.05 * value(s)


def first(s):
    return s.system.q[0].name


def special(s):
    branch = sf.continue_cycle(s, name(s), around(s), most=10)
    names = [p.name for p in s.parameters]
    if not branch.special or len(names) < 2:
        return branch
    return sf.continue_special(branch.special[0], names[:2], ((0.5 * value(s), 2 * value(s)), (0.1, 10.0)), most=5)


def explored(s):
    pytest.importorskip("bokeh", reason="bokeh is not installed: pip install '.[explore]'")
    page = sf.explore(s)
    page.stop()
    return page


RECORD = np.linspace(0.5, 20.0, 40), np.sin(np.linspace(0.5, 20.0, 40))
MOTION = sf.motions.sine_burst(1.0, 1.0, cycles=4)
RUNS = {
    "simulate": sf.simulate,
    "simulate: exact": lambda s: sf.simulate(s, route="exact"),
    "simulate: integrators": lambda s: sf.simulate(s, 1e-6, route="integrators"),
    "simulate: by a start": lambda s: sf.simulate(s, sensitivities=[first(s)]).sensitivities,
    "simulate: by a value": lambda s: sf.simulate(s, sensitivities=[name(s)]).sensitivities,
    "prepare": lambda s: sf.prepare(s).run().energy_residual(),
    "explain": lambda s: (sf.explain(s).to_dict(), repr(sf.explain(s))),
    "Scene": lambda s: (s.equations(), s._repr_latex_(), repr(s), s.regularised(1e-2)),
    "poincare": sf.poincare,
    "poincare: a section": lambda s: sf.poincare(s, s.system.u[0].name),
    "sweep": lambda s: sf.sweep(s.wanting({"m": sf.Max(s.system.q[0])}), {name(s): [*around(s)]}, jobs=1),
    "bifurcation_diagram": lambda s: sf.bifurcation_diagram(s, name(s), [*around(s)], jobs=1),
    "as_function": lambda s: sf.as_function(s.wanting({"m": sf.Max(s.system.q[0])}), [name(s)], ["m"])(value(s)),
    "export.stepper": lambda s: sf.export.stepper(s, 0.01).run(until=0.5),
    "equilibrium": sf.equilibrium,
    "stability": lambda s: (lambda found: (found, found.hurwitz, found.statespace))(sf.stability(s)),
    "average": lambda s: sf.average(s).amplitudes,
    "explore": explored,
    "separate": sf.separate,
}
DESIGNS = {
    "design.quench": lambda s: sf.design.quench(s, speeds=(0.1, 0.3), Omega=(20.0, 60.0), a=(0.0, 0.1)),
    "design.damper": lambda s: sf.design.damper(s, name(s), (0.0, 1.0), (0.2, 0.4)),
    "design.positioning": lambda s: sf.design.positioning(s, name(s), (0.0, 1.0), (0.2, 0.4)),
    "design.controller": lambda s: sf.design.controller(s.until(20.0), name(s), (0.05, 1.0)),
    "design.contact_damper": lambda s: sf.design.contact_damper(s, {"f_n": (1.0, 12.0)}),
    "design.isolator": lambda s: sf.design.isolator(s, [MOTION], {"mu": (0.005, 0.05)}),
    "theory.damper_loop": lambda s: sf.theory.damper_loop(s, name(s)),
    "theory.root_locus": lambda s: sf.theory.root_locus(s, name(s), np.linspace(0.1, 0.3, 3)),
}
SLOW = {  # of twenty coordinates these take a minute each to compile
    "hopf": lambda s: sf.hopf(s, name(s), (0.3 * value(s), 3 * value(s))),
    "limit_cycle": lambda s: (lambda o: (o.run, o.to_dict(), repr(o)))(sf.limit_cycle(s)),
    "continue_cycle and continue_special": special,
    "lyapunov": lambda s: sf.lyapunov(s, 30.0),
    "frequency_response": lambda s: sf.frequency_response(s, name(s), around(s), most=1, tolerance=1e-9).peak,
    "identify": lambda s: sf.identify(s, {first(s): RECORD}, {name(s): around(s)}, starts=1).to_dict(),
    "basins": lambda s: sf.basins(s, {first(s): np.array([0.5, 1.0])}),
    "design.collocation": lambda s: sf.design.collocation(
        s, {name(s): (-1.0, 1.0)}, {first(s): 0.0}, time=(0.1, 5.0), elements=2
    ),
    "theory.symbolic_hurwitz": sf.theory.symbolic_hurwitz,
}
CALLS = {**RUNS, **DESIGNS, **SLOW}
PAIRS = [(s, f) for s in SCENES for f in CALLS if not (s in LARGE and f in SLOW)]


def test_every_function_that_takes_a_scene_is_here():
    called = {f.split(":")[0] for f in CALLS} | {"continue_cycle", "continue_special"}
    public = {n: getattr(sf, n) for n in sf.__all__} | {f"design.{n}": getattr(sf.design, n) for n in sf.design.__all__}
    takes = {n for n, f in public.items() if inspect.isfunction(f) and "scene" in inspect.signature(f).parameters}
    assert takes <= called


@pytest.mark.one_in(100)
@pytest.mark.parametrize(("of", "ask"), PAIRS, ids=[f"{f}-{s}" for s, f in PAIRS])
def test_a_right_answer_or_one_clear_line(of, ask):
    try:
        answer = CALLS[ask](SCENES[of])
    except REFUSALS as refusal:
        line = str(refusal)
        assert "\n" not in line.strip()
        assert 15 < len(line) < 400
        assert not any(word in line for word in ("casadi", "Traceback", "ufunc", "ndarray", "<class"))
    else:
        assert answer is not None


GIVEN_LOADS = (
    "export.stepper",
    "equilibrium",
    "stability",
    "average",
    "separate",
    "hopf",
    "theory.damper_loop",
    "theory.root_locus",
    "theory.symbolic_hurwitz",
    *(f for f in CALLS if f.startswith("design.")),
)
EXCITED = ("poincare", "bifurcation_diagram", "frequency_response")


@pytest.mark.one_in(16)
@pytest.mark.parametrize("of", OPENING)
@pytest.mark.parametrize("ask", CALLS)
def test_contacts_that_open_are_taken_or_refused_in_one_line(of, ask):
    """What rests on given normal loads refuses; runs and what stands on them answer, routes of their own kind apart."""
    given = OPENING[of]
    try:
        answer = CALLS[ask](given)
    except REFUSALS as refusal:
        line = str(refusal)
        assert "\n" not in line.strip()
        assert not any(word in line for word in ("casadi", "CasADi", "Traceback", "<class"))
        routes = ("simulate: exact", "simulate: integrators", "Scene")
        assert ask in (*GIVEN_LOADS, *routes) or (ask in EXCITED and given is not OPENING["stops"])
    else:
        assert answer is not None
        assert ask not in (*GIVEN_LOADS, "simulate: integrators", "Scene")


@pytest.mark.parametrize(
    ("ask", "opened"),
    [
        (lambda s: sf.design.quench(s, speeds=(0.1, 0.4), Omega=(20, 60), a=(0, 0.02)), {"a": 0.02, "Omega": 30.0}),
        (lambda s: sf.design.damper(s, "beta", (0.0, 0.5), (0.1, 0.4)), {}),
        (sf.theory.belt.onset_speed, {}),
        (sf.theory.belt.stick_slip_amplitude, {}),
        (sf.theory.belt.quench_intensity, {}),
        (lambda s: sf.structures.onset(s, "v_b", (0.3, 0.6)), {}),
    ],
)
def test_a_stop_that_is_added_is_not_overlooked(ask, opened):
    belt = sf.scenes.mass_on_belt(v_b=0.2, **opened)
    stop = sf.Contact("stop", slip=None, normal=sf.Unilateral(10 - belt.system.q[0]))
    with pytest.raises(sf.SceneError):
        ask(replace(belt, contacts=[*belt.contacts, stop]))


@pytest.mark.one_in(3)
@pytest.mark.parametrize("of", KINKED)
def test_orbits_with_kinks_and_no_contact_against_scipy(of):
    given = KINKED[of]
    orbit = sf.limit_cycle(given)
    numbers = dict(given.values)
    right = sp.lambdify(
        (T, *given.system.states),
        [e.subs(numbers) for e in (*given.system.u, *given.system.force, *given.system.z_rate)],
    )
    run = solve_ivp(lambda t, y: right(t, *y), (0, orbit.period), orbit.start, rtol=1e-11, atol=1e-13, max_step=0.01)
    assert run.y[:, -1] == pytest.approx(orbit.start, abs=1e-8)
    assert np.ptp(run.y[0]) == pytest.approx(2 * orbit.half_range[0], rel=1e-4)
    if given.parameters:
        branch = sf.continue_cycle(given, name(given), around(given), most=10)
        k = len(branch.orbits) // 2
        alone = sf.limit_cycle(given.where({name(given): branch.values[k]}), guess=branch.orbits[k])
        assert alone.half_range == pytest.approx(branch.orbits[k].half_range, rel=1e-9)


TEXT = """
[scene]
coordinates = "x"
velocities = "u"
mass = 1
force = "%s"
initial = { x = 1.0, u = 0.0 }
horizon = 20
%s
"""


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("force", "more"),
    [
        ("-x - 0.1*u", ""),
        ("-x + p*(1 - abs(x))*u", "[values]\np = 0.5\n[sweep]\nparameter = 'p'\nfrom = 0.4\nto = 0.6\nnumber = 2"),
        ("-x - 0.1*u + cos(t)", ""),
        ("-9.81", ""),
        ("-x - 0.1*u - 10*max(0, x - 0.5) + cos(w*t)", "[values]\nw = 1.2"),
    ],
)
def test_studies_without_contacts(force, more, tmp_path):
    result = study(read_scene_text(TEXT % (force, more)))
    assert result.motion.value.status == "OK"
    for topic, reason in result.skipped().items():
        assert "\n" not in reason, topic
        assert "casadi" not in reason
