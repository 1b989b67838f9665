"""The one reading of the excitation: its frequencies, its period and the derivatives of that, in odd cases too."""

import ast
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.model.excitation import common_rate, excitation_of, is_excited, later, periodic

ROOT = Path(sf.__file__).parent
X, U, A = sp.symbols("x u a", real=True)
W, B, F = sp.symbols("w b f", positive=True)
T = sf.TIME


def scene(force=0, values=None, slip=None, normal=1, inputs=None):
    contacts = [sf.Contact("floor", U if slip is None else slip, normal, sf.laws.coulomb(0.1))]
    system = sf.System([X], [U], [[1]], [-X - 0.1 * U + force])
    return sf.Scene(system, contacts, values or {}, {X: 1.0, U: 0.0}, 10.0, inputs=inputs or {})


def test_two_frequencies_have_the_period_of_their_common_part():
    found = excitation_of(scene(sp.cos(W * T) + F * sp.sin(B * T), {W: 0.9, B: 0.6, F: 2.0}))
    assert set(found.rates) == {W, B}
    assert found.parameters == {"w", "b"}
    assert found.period({"w": 0.9, "b": 0.6}) == pytest.approx(2 * np.pi / 0.3, rel=1e-14)
    with pytest.raises(sf.SceneError, match=r"no common period: .*w = 0.91"):
        found.period({"w": 0.91234567, "b": 0.6})


@pytest.mark.parametrize("seed", range(20))
def test_the_order_of_frequencies_does_not_count(seed):
    rng = np.random.default_rng(seed)
    base, whole = 10 ** rng.uniform(-8, 8), rng.choice([1, 2, 3, 5, 7, 40, 1500], 3, replace=False)
    whole = whole // np.gcd.reduce(whole)
    signs = rng.choice([-1.0, 1.0], 3)
    for order in ([0, 1, 2], [2, 1, 0], [1, 0, 2]):
        rates = (base * whole * signs)[order]
        assert common_rate([*rates, 0.0]) == pytest.approx(base, rel=1e-13)


@pytest.mark.parametrize("far", [1.0, 30.0, 1e3, 1e5, 1e9])
def test_independent_numbers_have_no_common_part_however_far_apart(far):
    rng = np.random.default_rng(3)
    pairs = [(1.0, far * rng.uniform(1, 2)) for _ in range(200)]
    assert [common_rate(pair) for pair in pairs] == [None] * 200
    assert [common_rate(pair[::-1]) for pair in pairs] == [None] * 200


def test_a_frequency_of_zero_is_no_frequency():
    given = scene(sp.cos(W * T) + sp.cos(B * T), {W: 0.0, B: 0.5})
    assert excitation_of(given).rates == (B,)
    found = excitation_of(given, frozenset({"w"}))
    assert found.period({"w": 0.0, "b": 0.5}) == pytest.approx(4 * np.pi)
    with pytest.raises(sf.SceneError, match="frequencies of the excitation are zero"):
        found.period({"w": 0.0, "b": 0.0})
    with pytest.raises(sf.SceneError, match="changes some frequencies"):  # one that begins to move leaves no period
        found.period_by({"w": 0.0, "b": 0.5}, ("w",))
    assert found.period_by({"w": 0.0, "b": 0.5}, ("f",)) == pytest.approx([0.0])
    assert not is_excited(scene(F * sp.cos(T), {F: 0.0}))
    assert is_excited(scene(F * sp.cos(T), {F: 0.0}), frozenset({"f"}))


def test_a_frequency_that_is_no_number_is_named():
    k = sp.Symbol("k", real=True)
    found = excitation_of(scene(sp.cos(sp.sqrt(k) * T), {k: 4.0}))
    assert found.period({"k": 4.0}) == pytest.approx(np.pi)
    with pytest.raises(sf.SceneError, match=r"frequency sqrt\(k\) of the excitation is"):
        found.period({"k": -4.0})


def test_derivatives_of_the_period():
    found = excitation_of(scene(sp.cos(2 * W * T / B) + sp.sin(3 * W / B * T - 1), {W: 1.0, B: 2.0}))
    values, names = {"w": 1.3, "b": 2.2}, ("w", "f", "b")
    slopes = found.period_by(values, names)
    assert slopes[1] == 0
    for k in (0, 2):
        errors = []
        for step in (1e-2, 5e-3):
            high, low = (found.period(values | {names[k]: values[names[k]] + side * step}) for side in (1, -1))
            errors.append(abs((high - low) / (2 * step) - slopes[k]))
        assert errors[1] < 0.3 * errors[0] + 1e-12
    apart = excitation_of(scene(sp.cos(W * T) + sp.cos(B * T), {W: 1.0, B: 2.0}))
    with pytest.raises(sf.SceneError, match="changes some frequencies"):
        apart.period_by({"w": 1.0, "b": 2.0}, ("w",))


@pytest.mark.parametrize("unit", [1e-9, 2.54, 1e9])
def test_other_units_of_time_change_the_period_only(unit):
    given = scene(sp.cos(W * T) + sp.sin(B * T), {W: 0.7 * unit, B: 0.3 * unit})
    assert periodic(given).period({"w": 0.7 * unit, "b": 0.3 * unit}) * unit == pytest.approx(20 * np.pi, rel=1e-13)


def test_time_anywhere_is_seen():
    assert is_excited(scene(slip=U - sp.sin(2 * T)))
    assert periodic(scene(slip=U - sp.sin(2 * T))).period({}) == pytest.approx(np.pi)
    assert periodic(scene(normal=1 + 0.5 * sp.sin(3 * T))).period({}) == pytest.approx(2 * np.pi / 3)
    assert periodic(scene()) is None
    for force, words in {sp.exp(-T): "outside sines", sp.sin(X * T): "outside sines", A: "sampled input"}.items():
        inputs = {A: sf.Signal(np.zeros(5), 0.1)} if force == A else None
        found = excitation_of(scene(force, inputs=inputs))
        assert found
        assert words in found.note
        with pytest.raises(sf.SceneError, match=words):
            periodic(scene(force, inputs=inputs))


def test_a_load_that_swings_is_refused_where_time_must_not_enter():
    f = sp.Symbol("push", real=True)
    given = scene(f, {f: 0.0}, normal=1 + 0.5 * sp.sin(T))
    with pytest.raises(sf.SceneError, match="depends on time"):
        sf.design.collocation(given, {f: (-1.0, 1.0)}, {X: 0.0, U: 0.0}, time=(0.1, 10.0))


def test_a_later_start_is_the_same_motion():
    given = scene(sp.cos(W * T) + sp.exp(-T / 5), {W: 1.3}).wanting({"end": sf.End()})
    half = sf.simulate(given.until(4.0)).final
    rest = later(given, 4.0).starting(dict(zip((X, U), half.tolist(), strict=True))).until(6.0)
    assert sf.simulate(rest).final == pytest.approx(sf.simulate(given).final, abs=1e-8)


def called(node):
    return getattr(node.func, "attr", getattr(node.func, "id", "")) if isinstance(node, ast.Call) else ""


def test_nothing_else_reads_the_frequencies_of_a_scene():
    """Beside this module sines of time are taken apart only where they become forces or states."""
    apart, common = set(), set()
    for path in ROOT.rglob("*.py"):
        text = path.read_text()
        if not any(name in text for name in ("atoms", "common_rate", "limit_denominator")):
            continue
        for node in ast.walk(ast.parse(text)):
            if called(node) == "atoms" and {"sin", "cos"} <= {getattr(a, "attr", "") for a in node.args}:
                apart.add(path.relative_to(ROOT).as_posix())
            if called(node) in ("common_rate", "limit_denominator"):
                common.add(path.relative_to(ROOT).as_posix())
    assert apart == {"theory/separation.py", "lower/linear_modes.py"}
    units = {"model/dimensions.py", "model/unit_texts.py"}  # exponents of units are fractions, too
    assert common == {"model/excitation.py"} | units
