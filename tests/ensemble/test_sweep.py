"""Sweeps: the numbers of single runs on a labelled grid, whoever computes them."""

import warnings
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp
from small_sweep import X, shaken, small_grid, small_scene

import symfric as sf
from symfric.ensemble.progress import Progress, duration


def test_every_case_is_its_single_run(small):
    assert dict(small.sizes) == {"v_b": 9, "beta": 3, "a": 2, "state": 2}
    program = sf.prepare(small_scene())
    for v_b, beta, a in np.array(np.meshgrid(*small_grid().values(), indexing="ij")).reshape(3, -1).T:
        run = program.run({"v_b": v_b, "beta": beta, "a": a}).checked()
        case = small.sel(v_b=v_b, beta=beta, a=a)
        assert case.x_max.item() == run["x_max"]
        assert case.half.item() == run["half"]
        assert case.status.item() == sf.Status.OK
        np.testing.assert_array_equal(case.end.values, run.final)
        assert np.isnan(case.stop.item())
    fresh = sf.simulate(small_scene().where({"v_b": 0.25, "beta": 0.03, "a": 0.001}))
    assert small.x_max.sel(v_b=0.25, beta=0.03, a=0.001).item() == pytest.approx(fresh["x_max"], abs=1e-8)


@pytest.mark.parametrize("jobs", [2, 5, -1])
def test_threads_do_not_change_a_bit(small, jobs):
    assert small.identical(sf.sweep(small_scene(), small_grid(), jobs=jobs))


def test_an_executor_of_threads_does_not_change_a_bit(small):
    with ThreadPoolExecutor(2) as executor:
        assert small.identical(sf.sweep(small_scene(), small_grid(), executor=executor))


def test_dask_does_not_change_a_bit(small):
    pytest.importorskip("distributed", reason="the extra `distributed` is not installed")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # its own, from imports and from closing
        from distributed import Client, LocalCluster

        with (
            LocalCluster(
                n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs="CRITICAL"
            ) as cluster,
            Client(cluster) as client,
        ):
            found = sf.sweep(small_scene(), small_grid(), executor=client.get_executor())
    assert small.identical(found)


def test_values_that_are_still_open_come_from_the_grid():
    mu_s, mu_m = sp.symbols("mu_s mu_m", positive=True)
    scene = sf.scenes.mass_on_belt(sf.laws.cubic(mu_s, mu_m, 0.5), v_b=0.2, horizon=9.0).wanting({"top": sf.Max(X)})
    found = sf.sweep(scene, {mu_s: [0.4, 0.5], mu_m: [0.25]})
    assert found.top.sel(mu_s=0.4).item() == pytest.approx(
        sf.simulate(scene.where({"mu_s": 0.4, "mu_m": 0.25}))["top"], abs=1e-8
    )


def test_motions_take_the_place_of_an_input():
    burst = sf.motions.sine_burst(2.0, 1.0, 3, ramp=1, dt=0.02)
    motions = [burst, burst.scaled(3.0), burst.resampled(0.1)]
    found = sf.sweep(shaken(), {"k": [10.0, 20.0], "a_g": motions}, jobs=2)
    assert found.a_g.values.tolist() == ["sine burst", "sine burst (2)", "sine burst (3)"]
    for i, motion in enumerate(motions):
        scene = replace(shaken(), inputs={"a_g": motion.signal()})
        for k in (10.0, 20.0):
            single = sf.prepare(scene).run({"k": k})
            assert found.high.sel(k=k)[i].item() == single["high"]
    named = sf.sweep(shaken(), {"a_g": {"weak": burst.signal(), "none": sf.Signal([0.0, 0.0], 1.0)}})
    assert named.high.sel(a_g="none").item() == 0.0
    assert named.high.sel(a_g="weak").item() > 0.0


def test_several_scenes_make_an_axis():
    found = sf.sweep(
        {"short": shaken(1.0), "long": shaken(2.0)}, {"a_g": [sf.motions.sine_burst(2.0, 1.0)], "k": [9.0]}
    )
    assert found.high.dims == ("scene", "a_g", "k")
    assert found.scene.values.tolist() == ["short", "long"]
    assert found.high.sel(scene="long").item() >= found.high.sel(scene="short").item()


def test_a_failed_case_is_a_status():
    x, u = sp.symbols("x u", real=True)
    load, x0, tilt = sp.symbols("load x0 tilt", real=True)
    scene = sf.Scene(
        system=sf.System(q=[x], u=[u], mass=[[1]], force=[-x]),
        contacts=[sf.Contact("floor", slip=u, normal=load + tilt * x, law=sf.laws.coulomb(0.1))],
        values={load: 1.0, x0: 1.0, tilt: 0.5},
        initial={x: sp.sqrt(x0), u: 0.0},
        horizon=9.0,
        outputs={"low": sf.Min(x)},
    )
    found = sf.sweep(scene, {"x0": [1.0, -1.0], "tilt": [0.5, 4.0]})
    assert found.status.values.tolist() == [[sf.Status.OK, sf.Status.LOST_CONTACT], [-1, -1]]
    np.testing.assert_array_equal(np.isfinite(found.low.values), [[True, False], [False, False]])
    names = dict(zip(found.status.flag_values.tolist(), found.status.flag_meanings.split(), strict=True))
    assert (names[0], names[6], names[-1]) == ("OK", "LOST_CONTACT", "REFUSED")


@pytest.mark.parametrize("jobs", [1, 2])
def test_an_unforeseen_error_is_a_status(monkeypatch, caplog, jobs):
    from symfric.solve.taylor.program import TaylorProgram

    whole = TaylorProgram.map

    def failing(self, values=None, initial=None, threads=1, progress=None):
        if 0.3 in values["v_b"]:
            raise ZeroDivisionError("on purpose")
        return whole(self, values, initial, threads, progress)

    monkeypatch.setattr(TaylorProgram, "map", failing)
    found = sf.sweep(small_scene(), {"v_b": [0.2, 0.3, 0.4, 0.35, 0.25]}, jobs=jobs)
    assert found.status.values.tolist() == [0, -2, 0, 0, 0]
    assert "on purpose" in caplog.text


class Broken(Executor):
    """An executor that loses every chunk."""

    def submit(self, *_arguments, **_named):
        future = Future()
        future.set_exception(OSError("the worker is gone"))
        return future


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"grid": {}}, "no axis"),
        ({"grid": []}, "give a mapping"),
        ({"grid": {"v_c": [1.0]}}, "v_c is no parameter .* did you mean v_b"),
        ({"grid": {"v_b": []}}, "at least one"),
        ({"grid": {"v_b": 0.2}}, "shape"),
        ({"grid": {"v_b": [0.1, np.nan]}}, "value 1 of v_b is not finite"),
        ({"grid": {"v_b": "fast"}}, "not numbers"),
        ({"grid": {"v_b": [0.1], sp.Symbol("v_b"): [0.2]}}, "given twice"),
        ({"grid": {"x": [0.1]}}, "x is no parameter"),
        ({"jobs": 0}, "jobs is 0"),
        ({"jobs": 1.5}, "jobs is 1.5"),
        ({"executor": 3}, "executor is 3"),
        ({"progress": "bar"}, "progress is 'bar'"),
        ({"tolerance": 1.0}, "tolerance is 1.0"),
        ({"route": "fast"}, "no route 'fast'"),
        ({"scene": 3}, "neither a sf.Scene"),
        ({"scene": {}}, "neither a sf.Scene"),
        ({"scene": small_scene().wanting({"path": sf.Trajectory()})}, "no scalar output"),
        ({"scene": small_scene().wanting({"v_b": sf.Max(X)})}, "rename the output"),
        ({"scene": small_scene().wanting({"status": sf.Max(X)})}, "rename the output"),
        ({"scene": {"a": small_scene(), "b": shaken()}, "grid": {"v_b": [0.1]}}, "v_b is no parameter"),
        ({"scene": {"a": small_scene(), "b": small_scene().wanting({"end": sf.End()})}}, "different outputs"),
        ({"scene": shaken(), "grid": {"a_g": [1.0]}}, "give motions or sf.Signal"),
        ({"scene": shaken(), "grid": {"a_g": []}}, "no motions"),
        ({"scene": shaken(), "grid": {"a_g": sf.motions.sine_burst(1.0, 1.0)}}, "give a list"),
    ],
)
def test_bad_requests_name_the_cure(change, message):
    with pytest.raises(sf.SceneError, match=message):
        sf.sweep(**{"scene": small_scene(), "grid": {"v_b": [0.1, 0.2]}, **change})


def test_no_route_is_said_at_the_door():
    with pytest.raises(sf.NoRoute):
        sf.sweep(small_scene(), {"v_b": [0.1]}, route="exact")


def test_a_broken_executor_is_said_in_a_line():
    with pytest.raises(sf.RunFailed, match="the worker is gone"):
        sf.sweep(small_scene(), {"v_b": [0.1, 0.2]}, executor=Broken())


def test_progress_tells_rate_and_time_left(capsys):
    reports = []
    sf.sweep(small_scene(), small_grid(), progress=reports.append)
    assert (reports[-1].done, reports[-1].total, reports[-1].left) == (54, 54, 0.0)
    assert [r.done for r in reports] == sorted(r.done for r in reports)
    assert str(Progress(20, 100, 4.0, 20.0)) == "20 of 100 cases, 4/s, 20 s left"
    assert [duration(s) for s in (8.2, 250.0, 7500.0)] == ["8 s", "4 min 10 s", "2 h 5 min"]
    sf.sweep(small_scene(), {"v_b": [0.1]}, progress=True)
    assert capsys.readouterr().err == ""
