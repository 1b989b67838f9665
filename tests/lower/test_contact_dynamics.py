"""The one place where the equations of motion are written: it is the only one, and they are the right ones."""

import ast
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.lower.contact_dynamics import ContactDynamics
from symfric.model.symbols import SPEED, TIME

ROOT = Path(sf.__file__).parent


def callers(*names):
    """Return the modules of the package that call a function of one of these names."""
    found = set()
    for path in ROOT.rglob("*.py"):
        text = path.read_text()
        if not any(name in text for name in names):
            continue
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Call) and getattr(node.func, "attr", getattr(node.func, "id", "")) in names:
                found.add(path.relative_to(ROOT).as_posix())
    return found


def test_nothing_else_translates_forces_or_solves_for_accelerations():
    assert callers("ldl", "ldl_solve") == {"lower/contact_dynamics.py"}
    # starting values, a law over the speed alone, one driven by a given motion, and samples are no equations of motion
    others = {"lower/at_instants.py", "lower/clocks.py"} | {
        "lower/variational_equations.py",
        "design/quench/averaged_damping.py",
        "identification/loops.py",
    }
    assert callers("Printer") == {"lower/printer.py", "lower/contact_dynamics.py"} | others


@pytest.fixture
def written(monkeypatch):
    """Count how often equations are written down."""
    found = []
    once = ContactDynamics.__init__

    def counted(self, *arguments, **named):
        found.append(self)
        once(self, *arguments, **named)

    monkeypatch.setattr(ContactDynamics, "__init__", counted)
    return found


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    "scene",
    [
        sf.scenes.mass_on_belt(v_b=0.2),
        sf.scenes.coulomb_oscillator(0.03, x0=1.0).wanting({"end": sf.End(), "path": sf.Trajectory()}),
    ],
    ids=["belt", "oscillator"],
)
@pytest.mark.parametrize("route", [None, "exact", "taylor", "integrators"])
def test_a_scene_is_lowered_once(scene, route, written):
    try:
        program = sf.prepare(scene, route=route)
    except sf.NoRoute:
        pass
    else:
        assert len(written) == 1
        run = program.run()
        assert len(written) == 1
        run.energy_residual()  # with the parameters as such: it serves for all their values
        assert len(written) <= 2
    written.clear()
    sf.explain(scene)
    assert len(written) == 1


def random_scene(seed):
    """Three masses that couple, two contacts that turn with the position and the time, and a law with two branches."""
    rng = np.random.default_rng(seed)
    q, u = sp.symbols("q:3", real=True), sp.symbols("u:3", real=True)
    a, b = sp.symbols("a b", positive=True)
    mass = sp.diag(2 + sp.cos(q[1]), 3, a) + sp.Matrix(3, 3, lambda i, j: sp.Rational(1, 5 + i + j))
    force = [-a * q[0] + sp.sin(TIME), sp.Abs(q[1] - u[0]) - u[1], q[0] * q[2] - b * u[2] ** 3]
    law = sf.laws.custom(sp.Piecewise((0.4 - 0.1 * SPEED, SPEED < 1), (0.3, True)), 0.5, breaks=(1.0,))
    rows = rng.integers(-3, 4, (2, 3)) + 0.5
    slips = [sum(float(r) * e for r, e in zip(row, u, strict=True)) for row in rows]
    contacts = [
        sf.Contact("c0", slips[0] + q[2] * u[1] - sp.sin(TIME), 2 + sp.cos(q[0]), law),
        sf.Contact("c1", slips[1], a, sf.laws.exponential(0.3, 0.5)),
    ]
    system = sf.System(q=q, u=u, mass=mass, force=force)
    start = dict.fromkeys([*q, *u], 0.0)
    return sf.Scene(system=system, contacts=contacts, values={a: 2.0, b: 0.7}, initial=start, horizon=1.0)


@pytest.mark.parametrize("seed", range(3))
def test_graphs_are_the_equations(seed):
    scene = random_scene(seed)
    model = ContactDynamics.of(scene)
    rng = np.random.default_rng(seed)
    y, t, d = rng.normal(size=6), rng.normal(), rng.choice([-1.0, 1.0], 2)
    p = np.array([float(scene.values[s]) for s in model.parameters])
    graphs = [model.mass, model.force, model.slopes, model.drift, model.load, model.slip, model.sliding]
    graphs = model.unswitched([ca.densify(e) for e in graphs])
    graphs = [ca.substitute(e, model.d, ca.SX(d)) for e in graphs]
    found = ca.Function("all", [model.y, model.t, model.p], graphs)(y, t, p)
    M, f, J, drift, load, slip, sliding = (np.array(e) for e in found)
    at = {**dict(zip(scene.system.states, y, strict=True)), TIME: t, **dict(zip(model.parameters, p, strict=True))}
    number = lambda e: float(sp.sympify(e).subs(at).doit())  # noqa: E731
    assert pytest.approx(np.array(scene.system.mass.subs(at), dtype=float), rel=1e-14) == M
    assert f.ravel() == pytest.approx([number(e) for e in scene.system.force], rel=1e-13)
    for i, c in enumerate(scene.contacts):
        assert slip[i, 0] == pytest.approx(number(c.slip), rel=1e-13)
        assert load[i, 0] == pytest.approx(number(c.normal * c.profile), rel=1e-14)
        assert J[i] == pytest.approx([number(c.slip.diff(u)) for u in scene.system.u], rel=1e-14)
        moving = sum(c.slip.diff(q) * u for q, u in zip(scene.system.q, scene.system.u, strict=True))
        assert drift[i, 0] == pytest.approx(number(moving + c.slip.diff(TIME)), rel=1e-13, abs=1e-15)
        mu = float(c.law.kinetic.subs(SPEED, d[i] * slip[i, 0]))
        assert sliding[i, 0] == pytest.approx(-d[i] * load[i, 0] * mu, rel=1e-13)


@pytest.mark.parametrize("seed", range(3))
def test_a_mode_obeys_newton_and_holds_what_sticks(seed):
    scene = random_scene(seed)
    model = ContactDynamics.of(scene)
    rng = np.random.default_rng(10 + seed)
    y, t, d = rng.normal(size=6), rng.normal(), rng.choice([-1.0, 1.0], 2)
    p = np.array([float(scene.values[s]) for s in model.parameters])
    rate, friction = model.accelerations(tested=True)
    graphs = model.unswitched([rate, friction, ca.densify(model.mass), model.force, model.slopes, model.drift])
    together = ca.Function("mode", [model.y, model.t, model.p, model.s, model.d], graphs)
    for s in ([0, 0], [1, 0], [0, 1], [1, 1]):
        a, force, M, f, J, c = (np.array(e) for e in together(y, t, p, s, d))
        assert pytest.approx(f + J.T @ force, rel=1e-11, abs=1e-11) == M @ a
        assert (J @ a + c).ravel()[np.array(s) == 1] == pytest.approx(0.0, abs=1e-11)
