"""Many cases at once: the bits of single runs, whatever the neighbours, the order and the threads."""

import numpy as np
import pytest
import sympy as sp
from longer import longer

import symfric as sf

X, U, Y, W, Z = sp.symbols("x u y w z", real=True)
P, Q, V = sp.symbols("p q v_b", positive=True)
CUBIC = sf.laws.cubic(0.4, 0.25, 0.5)
RNG = np.random.default_rng(20)
SIGNAL = sf.Signal(np.random.default_rng(3).standard_normal(60), 0.25)
BURST = sf.motions.sine_burst(2.0, 1.0, 5, ramp=1, dt=0.02)


def one(force, contacts=(), values=None, horizon=30.0, **rest):
    z = rest.pop("z", {})
    system = sf.System([X], [U], [[1]], [force], list(z), list(z.values()))
    initial = {X: 0.5, U: 0.0, **dict.fromkeys(z, 0.0)}
    return sf.Scene(system, contacts, values or {}, initial, horizon, **rest)


def two(normal=1):
    """Two masses on one belt, coupled by a spring."""
    force = [-X - P * (X - Y) - U / 20, -Y - P * (Y - X)]
    contacts = [sf.Contact("left", U - V, normal, CUBIC), sf.Contact("right", W - V, 1, sf.laws.coulomb(0.3, 0.2))]
    initial = {X: 0.0, Y: 0.1, U: 0.0, W: 0.0}
    return sf.Scene(sf.System([X, Y], [U, W], sp.eye(2), force), contacts, {P: 0.5, V: 0.2}, initial, 30.0)


FLOOR = [sf.Contact("floor", U, 1, sf.laws.coulomb(0.3, 0.2))]
BELT = sf.scenes.mass_on_belt(v_b=0.2, horizon=60.0)
# scene, its outputs beside the usual ones, the names that vary and between what
SCENES = {
    "belt": (BELT, {"work": sf.Integral(X * U), "s": sf.Samples(U, [0.0, 0.5, 7.0])}, {"v_b": (0.05, 0.45)}),
    "shaken belt": (sf.scenes.mass_on_belt(v_b=0.2, a=0.01, Omega=20.0, horizon=20.0), {}, {"Omega": (15.0, 30.0)}),
    "two contacts": (two(), {"force": sf.Max(sf.friction_force("left"))}, {"v_b": (0.05, 0.3), "p": (0.2, 1.0)}),
    "switch": (one(-X - U / 10 - 10 * sp.Max(0, X - P) + sp.cos(1.2 * sf.TIME), values={P: 0.5}), {}, {"p": (0.3, 0.9)}),
    "input": (one(-X - U / 20 + Q, FLOOR, {P: 1.0}, inputs={Q: SIGNAL}, horizon=20.0, outputs={"a": sf.Max(X * P)}), {}, {"p": (0.5, 2.0)}),
    "first order": (one(-X - U / 5 - Z + P * sp.cos(sf.TIME), (), {P: 0.5}, z={Z: U - sp.Abs(U) * Z}), {}, {"p": (0.2, 0.9)}),
    "smooth law": (BELT.regularised(1e-2), {}, {"v_b": (0.1, 0.4)}),
    "tanh": (BELT.until(20.0).regularised(1e-2, "tanh"), {}, {"v_b": (0.1, 0.4)}),
    "oscillator": (sf.scenes.coulomb_oscillator(0.1), {"size": sf.Max(sp.Abs(X))}, {"delta": (0.01, 0.1)}),
    "record": (sf.scenes.rolling_isolator(C=1.0, m=10.0, motion=BURST, profile=0.03), {}, {"C": (0.5, 30.0), "mu": (0.01, 0.2)}),
    "matrices": (sf.scenes.two_slides(r=0.5, zeta=0.1, s1=0.05, s2=0.02, fc1=0.2, fs1=0.3, damping="omega1").until(40.0), {}, {"s2": (0.01, 0.1)}),
}  # fmt: skip
LONG = ("smooth law", "tanh", "first order")


def prepared(name):
    scene, more, ranges = SCENES[name]
    first = scene.system.q[0]
    # of a ready scene its scalar outputs, too
    own = {n: o for n, o in scene.outputs.items() if not o.keeps_path}
    wanted = {**own, "top": sf.Max(first), "half": sf.HalfRange(first), "end": sf.End(), "rest": sf.StopTime(), **more}
    if name == "oscillator":
        wanted["size"] = sf.Max(sp.Abs(first))
    return sf.prepare(scene.wanting(wanted), 1e-9), ranges


def drawn(ranges, n, seed=1):
    rng = np.random.default_rng(seed)
    return {name: rng.uniform(low, high, n) for name, (low, high) in ranges.items()}


def case(values, k):
    return {name: float(row[k]) for name, row in values.items()}


def same(a, b):
    """Whether two batches have the same bits."""
    rows = [("final", a.final, b.final), ("t_final", a.t_final, b.t_final), ("status", a.status, b.status)]
    rows += [(n, a[n], b[n]) for n in a.outputs] + [(n, a.stats[n], b.stats[n]) for n in a.stats]
    for name, own, other in rows:
        np.testing.assert_array_equal(own, other, err_msg=name)


def some(batch, chosen):
    from dataclasses import replace

    return replace(
        batch,
        outputs={n: rows[..., chosen] for n, rows in batch.outputs.items()},
        final=batch.final[:, chosen],
        t_final=batch.t_final[chosen],
        status=batch.status[chosen],
        stats={n: row[chosen] for n, row in batch.stats.items()},
    )


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", longer(SCENES, LONG))
def test_a_case_is_its_single_run_whatever_its_neighbours(name):
    program, ranges = prepared(name)
    n = 23
    values = drawn(ranges, n)
    batch = program.map(values)
    assert len(batch) == n
    assert batch.final.shape == (len(batch.names), n)
    for k in range(n):
        run = program.run(case(values, k))
        assert batch.status[k] == run.status
        np.testing.assert_array_equal(batch.final[:, k], run.final)
        assert batch.t_final[k] == run.t_final
        for output, value in run.outputs.items():
            np.testing.assert_array_equal(batch[output][..., k], value, err_msg=output)
        assert {s: row[k] for s, row in batch.stats.items()} == run.stats
    order = RNG.permutation(n)
    shuffled = {name: row[order] for name, row in values.items()}
    for threads in (1, 2, 4):
        same(program.map(shuffled, threads=threads), some(batch, order))
    for chosen in ([n - 1], [4, 4, 4], list(range(0, n, 3))):
        same(program.map({name: row[chosen] for name, row in values.items()}), some(batch, chosen))


def test_many_cases_are_each_what_they_are_alone():
    program = sf.prepare(sf.scenes.coulomb_oscillator(0.1).wanting({"stop": sf.StopTime(), "low": sf.Min(X)}))
    delta = RNG.uniform(0.01, 0.1, 30_000)
    batch = program.map({"delta": delta}, threads=2)
    assert np.all(batch.ok)
    np.testing.assert_allclose(batch["low"], -(1.0 - 2.0 * delta), rtol=1e-12)  # after the first half cycle
    same(program.map({"delta": delta[::-1][:1000]}), some(batch, slice(-1, -1001, -1)))


def test_no_case_one_case_and_numbers_for_all():
    program = sf.prepare(BELT.wanting({"end": sf.End(), "m": sf.Max(X), "s": sf.Samples(X, [1.0, 2.0])}))
    none = program.map({"v_b": []}, threads=3)
    assert [none["end"].shape, none["m"].shape, none["s"].shape, none.final.shape] == [(2, 0), (0,), (2, 0), (2, 0)]
    assert len(none) == 0
    assert none.checked().to_dict()["status"] == []
    run = program.run({"v_b": 0.3}, {"x": 0.1})
    for values, initial in (
        ({"v_b": 0.3}, {"x": 0.1}),
        ({"v_b": [0.3]}, {"x": np.float64(0.1)}),
        ({V: np.array(0.3)}, {X: [0.1]}),
    ):
        one = program.map(values, initial)
        assert one["m"].tolist() == [run["m"]]
        assert one.final[:, 0].tolist() == run.final.tolist()
    wide = program.map({"v_b": 0.3}, {"x": [0.1, 0.2, 0.3], "u": [0.0]})
    assert wide["m"].shape == (3,)
    assert wide["m"][0] == run["m"]
    assert program.map()["m"].tolist() == [program.run()["m"]]


def test_values_that_are_built_in_otherwise_do_not_change_their_neighbours():
    scene = sf.scenes.mass_on_belt(v_b=0.2, beta=0.0, horizon=20.0).wanting({"m": sf.Max(X), "end": sf.End()})
    program = sf.prepare(scene)
    assert "beta" in program.built_in
    beta = np.array([0.0, 0.05, 0.0, 0.1])
    batch = program.map({"beta": beta, "v_b": [0.1, 0.2, 0.3, 0.4]})
    for k, (b, v) in enumerate(zip(beta, (0.1, 0.2, 0.3, 0.4), strict=True)):
        assert batch["m"][k] == program.run({"beta": b, "v_b": v})["m"]
    told = []
    program.map({"beta": beta}, progress=told.append)
    assert told == sorted(told)
    assert told[-1] == 1.0


def failing_scene():
    load, x0, tilt = sp.symbols("load x0 tilt", real=True)
    floor = sf.Contact("floor", slip=U, normal=load + tilt * X, law=sf.laws.coulomb(0.1))
    system = sf.System(q=[X], u=[U], mass=[[1]], force=[-X])
    initial = {X: sp.sqrt(x0), U: 0.0}
    wanted = {"low": sf.Min(X), "end": sf.End(), "s": sf.Samples(X, [0.5, 8.0]), "stop": sf.StopTime()}
    return sf.Scene(system, [floor], {load: 1.0, x0: 1.0, tilt: 0.5}, initial, 9.0, wanted)


def test_a_case_that_fails_is_a_status_and_nan():
    program = sf.prepare(failing_scene())
    x0, tilt = np.array([1.0, -1.0, 1.0, 0.5]), np.array([0.5, 0.5, 4.0, 0.5])
    batch = program.map({"x0": x0, "tilt": tilt}, threads=2)
    assert batch.status.tolist() == [sf.Status.OK, sf.Status.NOT_FINITE, sf.Status.LOST_CONTACT, sf.Status.OK]
    assert batch.ok.tolist() == [True, False, False, True]
    for rows in (batch["low"], *batch["end"], *batch["s"], *batch.final):
        assert np.isfinite(rows).tolist() == [True, False, False, True]
    assert np.isnan(batch.t_final).tolist() == [False, True, False, False]  # that one did not begin
    assert 0 < batch.t_final[2] < 9
    alone = program.map({"x0": x0[[0, 3]], "tilt": 0.5})
    assert batch["low"][[0, 3]].tolist() == alone["low"].tolist()
    with pytest.raises(
        sf.RunFailed, match=r"2 of 4 cases failed, the first is case 1 \(x0 = -1, tilt = 0.5\): NOT_FINITE"
    ):
        batch.checked()


def test_starts_that_are_formulas_have_the_bits_of_single_runs():
    a, b = sp.symbols("a b", positive=True)
    plain, initial = one(-X, FLOOR), {X: a**3 * sp.exp(b) + sp.sin(a) ** b, U: sp.tanh(a)}
    scene = sf.Scene(plain.system, plain.contacts, {a: 1.0, b: 0.3}, initial, 9.0, {"end": sf.End()})
    program = sf.prepare(scene)
    values = {"a": RNG.uniform(0.5, 2.0, 37), "b": RNG.uniform(0.1, 0.5, 37)}
    batch = program.map(values)
    for k in range(37):
        assert batch["end"][:, k].tolist() == program.run(case(values, k)).final.tolist()


def test_one_program_in_many_threads_at_once():
    from concurrent.futures import ThreadPoolExecutor

    program, ranges = prepared("belt")
    values = drawn(ranges, 64)
    batch = program.map(values)
    with ThreadPoolExecutor(4) as crew:
        for found in crew.map(lambda k: program.map(values, threads=1 + k % 2), range(8)):
            same(found, batch)


def test_the_integrators_take_many_cases_too():
    program = sf.prepare(
        BELT.until(5.0).wanting({"m": sf.Max(X), "w": sf.Integral(X * X), "s": sf.Samples(X, [1.0, 2.0])}),
        1e-6,
        route="integrators",
    )
    batch = program.map({"v_b": [0.2, 0.3]}, threads=2)
    run = program.run({"v_b": 0.3})
    assert (batch["m"][1], batch["w"][1], batch["s"][:, 1].tolist()) == (run["m"], run["w"], run["s"].tolist())
    assert program.map({"v_b": []})["s"].shape == (2, 0)
    with pytest.raises(sf.SceneError, match=r"case 0: .*v_c"):
        program.map({"v_c": [0.2]})


def test_derivatives_of_many_cases():
    program = sf.prepare(BELT.until(20.0).wanting({"m": sf.Max(X), "end": sf.End()}), sensitivities=["v_b", "x"])
    values = {"v_b": np.array([0.2, 0.25, 0.3])}
    batch = program.map(values)
    for k in range(3):
        run = program.run(case(values, k))
        assert batch.sensitivities["v_b"][:, k].tolist() == run.sensitivities["v_b"].tolist()
        assert batch.output_sensitivities["m"]["x"][k] == run.output_sensitivities["m"]["x"]


@pytest.mark.parametrize(
    ("values", "initial", "message"),
    [
        ({"v_b": [0.1, np.nan]}, {}, "value 1 of v_b is nan; it must be finite"),
        ({"v_b": [[0.1, 0.2]]}, {}, r"the values of v_b have shape \(1, 2\)"),
        ({"v_b": [0.1, 0.2]}, {"x": [1.0, 2.0, 3.0]}, "different lengths: v_b has 2, x has 3"),
        ({"v_b": []}, {"x": [1.0, 2.0]}, "different lengths"),
        ({"v_c": [0.1]}, {}, "v_c is no parameter .* did you mean v_b"),
        ({"x": [0.1]}, {}, "x is no parameter"),
        ({}, {"v_b": [0.1]}, "v_b is no state"),
        ({"v_b": ["fast"]}, {}, "real numbers"),
        ({"v_b": "fast"}, {}, "not a number"),
        ({"v_b": [True, False]}, {}, "real numbers"),
        ({"v_b": [1j]}, {}, "real numbers"),
        ({"v_b": [0.1, None]}, {}, "value 1 of v_b is None"),
        ({"v_b": [0.1], sp.Symbol("v_b"): [0.2]}, {}, "given twice"),
        ([0.1], {}, "give a mapping"),
        ({3: [0.1]}, {}, "no name"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_one_line(values, initial, message):
    program = sf.prepare(BELT.wanting({"m": sf.Max(X)}))
    with pytest.raises(sf.SceneError, match=message) as refusal:
        program.map(values, initial)
    assert "\n" not in str(refusal.value)


def test_trajectories_and_threads_are_refused_by_name():
    for route in ("taylor", "integrators"):
        with pytest.raises(sf.SceneError, match=r"output 'path' is Trajectory\(\): `map` keeps neither"):
            sf.prepare(BELT, route=route).map()
    with pytest.raises(sf.SceneError, match="'events' is Events"):
        sf.prepare(BELT.wanting({"events": sf.Events()})).map()
    program = sf.prepare(BELT.wanting({"m": sf.Max(X)}))
    for threads in (0, -2, 1.5, True, "two"):
        with pytest.raises(sf.SceneError, match="threads is"):
            program.map(threads=threads)
    with pytest.raises(sf.SceneError, match="'n' is no output; there are: m"):
        program.map()["n"]


def test_what_progress_raises_ends_all():
    program, ranges = prepared("belt")

    class Enough(Exception):
        pass

    def enough(_part):
        raise Enough

    for threads in (1, 2):
        with pytest.raises(Enough):
            program.map(drawn(ranges, 4000), threads=threads, progress=enough)
    assert program.map({"v_b": 0.2})["top"].tolist() == [program.run({"v_b": 0.2})["top"]]


def test_a_batch_reads_well():
    program = sf.prepare(failing_scene())
    batch = program.map({"x0": [1.0, -1.0]})
    assert repr(batch) == "Batch(2 cases, 1 failed; outputs: low, end, s, stop)"
    assert batch.to_dict()["status"] == ["OK", "NOT_FINITE"]
    data = batch.to_xarray()
    assert data.low.dims == ("case",)
    assert data.s.dims == ("s_index", "case")
    assert data.x0.values.tolist() == [1.0, -1.0]
    assert "Batch" in batch._repr_html_()
