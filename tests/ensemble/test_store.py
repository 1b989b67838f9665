"""Stores: no finished case is lost or computed again, whatever ends a sweep."""

import json
import os
import shutil
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from small_sweep import X, shaken, small_grid, small_scene

import symfric as sf
from symfric.ensemble.grid import fingerprint
from symfric.ensemble.store import Store

KILLS = """
import multiprocessing, os, random, signal, sys, time
from concurrent.futures import ProcessPoolExecutor
sys.path.insert(0, sys.argv[1])
import numpy as np
from small_sweep import X, small_scene
import symfric as sf
from symfric.ensemble.grid import fingerprint
scene = sf.scenes.mass_on_belt(v_b=0.2, horizon=120.0).wanting({"half": sf.HalfRange(X), "end": sf.End()})
grid = {"v_b": np.linspace(0.05, 0.45, 30), "beta": np.linspace(0.0, 0.06, 10)}
store, random = sys.argv[2], random.Random(20261121)
begin = time.perf_counter()
whole = sf.sweep(scene, grid)
span = time.perf_counter() - begin
record, kept = 8 * 6, []
for kill in range(5):
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        def report(at):
            os.write(writing, b"%d " % at.done)
        import symfric.ensemble.progress as progress
        progress.INTERVAL = 0.0
        sf.sweep(scene, grid, store=store, jobs=1 + kill % 2, progress=report)
        os._exit(0)
    os.close(writing)
    time.sleep(0.15 * span * random.uniform(0.2, 2.0) + 0.1)
    os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    told = b""
    while part := os.read(reading, 65536):
        told += part
    os.close(reading)
    files = [os.path.join(store, f) for f in sorted(os.listdir(store)) if f.endswith(".bin")] if os.path.isdir(store) else []
    here = sum(os.path.getsize(f) // record for f in files)
    done = 300 if os.path.exists(os.path.join(store, "result.nc")) else here
    told = int(told.split()[-1]) if told.split() else 0
    assert done >= told, (done, told)  # nothing that was said to be done is lost
    kept.append(done)
assert kept == sorted(kept), kept
resumed = []
result = sf.sweep(scene, grid, store=store, progress=resumed.append)
again = sf.sweep(scene, grid, store=store)
assert whole.identical(result) and whole.identical(again)
assert {v: result[v].values.tobytes() for v in result} == {v: whole[v].values.tobytes() for v in whole}
with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("fork")) as executor:
    assert whole.identical(sf.sweep(scene, grid, executor=executor))
    assert whole.identical(sf.sweep(scene, grid, executor=executor, store=store + "-of-processes"))
print(fingerprint(small_scene()))
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="kills a forked process; this system has no fork")
def test_a_sweep_killed_five_times_or_on_processes_ends_in_the_same_bits(tmp_path):
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", KILLS, os.path.dirname(__file__), str(tmp_path / "store")],
        capture_output=True,
        text=True,
        timeout=300,
        env={**os.environ, "PYTHONHASHSEED": "77"},
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == fingerprint(small_scene())  # the same in every process


def interrupted(store, after, **arguments):
    """Run the small sweep until some cases are reported done, then interrupt it."""

    def report(at):
        if at.done >= after:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sf.sweep(small_scene(), small_grid(), store=store, progress=report, **arguments)


@pytest.mark.parametrize("jobs", [1, 3])
def test_an_interrupted_sweep_goes_on(small, jobs, tmp_path, monkeypatch):
    monkeypatch.setattr("symfric.ensemble.progress.INTERVAL", 0.0)
    monkeypatch.setattr("symfric.ensemble.scheduler.INTERVAL", 1e-4)
    interrupted(tmp_path / "s", 10, jobs=jobs)
    ran = []
    from symfric.ensemble import scheduler

    run_cases = scheduler.run_cases
    monkeypatch.setattr(
        scheduler, "run_cases", lambda p, t, rows, h: ran.extend(map(tuple, rows.tolist())) or run_cases(p, t, rows, h)
    )
    files = list((tmp_path / "s").glob("cases-*.bin"))
    there = sum(f.stat().st_size for f in files) // (8 * 8)
    assert there >= 10
    assert small.identical(sf.sweep(small_scene(), small_grid(), jobs=jobs, store=tmp_path / "s"))
    assert len(ran) == len(set(ran)) == 54 - there
    assert sorted(p.name for p in (tmp_path / "s").iterdir()) == ["result.nc", "sweep.json"]
    assert small.identical(sf.sweep(small_scene(), small_grid(), store=tmp_path / "s"))
    assert len(ran) == 54 - there


def test_the_result_is_a_netcdf_file(small, tmp_path):
    sf.sweep(small_scene(), small_grid(), store=tmp_path / "s")
    with xr.open_dataset(tmp_path / "s" / "result.nc", engine="scipy") as found:
        xr.testing.assert_equal(found, small)
        assert found.status.flag_meanings.split()[2] == "OK"


def test_records_that_were_cut_off_or_damaged_are_computed_again(small, tmp_path, monkeypatch):
    monkeypatch.setattr("symfric.ensemble.progress.INTERVAL", 0.0)
    monkeypatch.setattr("symfric.ensemble.scheduler.INTERVAL", 1e-4)
    interrupted(tmp_path / "s", 10)
    file = tmp_path / "s" / "cases-0000.bin"
    data = bytearray(file.read_bytes())
    data[8 * 8 * 3 + 20] ^= 1  # one bit of the fourth record
    file.write_bytes(data[: 8 * 8 * 7 + 13])
    starts = []
    result = sf.sweep(small_scene(), small_grid(), store=tmp_path / "s", progress=lambda at: starts.append(at.done))
    assert small.identical(result)
    assert starts[0] >= 6


def refused(match, scene=None, grid=None, **arguments):
    with pytest.raises(sf.SceneError, match=match):
        sf.sweep(scene or small_scene(), grid or small_grid(), **arguments)


def test_the_store_of_another_sweep_is_refused(tmp_path):
    store = tmp_path / "s"
    sf.sweep(small_scene(), {"v_b": [0.1, 0.2]}, store=store)
    refused(r"holds another sweep, over v_b \(2\); name another store", store=store)
    two = {"grid": {"v_b": [0.1, 0.2]}, "store": store}
    refused("another sweep", **{**two, "grid": {"v_b": [0.1, 0.2 + 1e-16 * 2]}})
    refused("another sweep", small_scene().where({"beta": 0.06}), **two)
    refused("another sweep", small_scene().until(31.0), **two)
    refused("another sweep", small_scene().starting({"x": 1e-9}), **two)
    refused("another sweep", small_scene().wanting({"x_max": sf.Max(X)}), **two)
    refused("another sweep", **two, tolerance=1e-8)
    refused("another sweep", **two, route=sf.Taylor(order=20))
    about = json.loads((store / "sweep.json").read_text())
    (store / "sweep.json").write_text(json.dumps({**about, "code": "0"}))
    refused("another version of symfric", **two)
    (store / "sweep.json").write_text("{")
    refused("cannot be read", **two)


def test_folders_that_are_no_store_are_refused(tmp_path):
    (tmp_path / "file").write_text("")
    refused("is a file", store=tmp_path / "file")
    refused("holds other files", store=tmp_path)
    refused("cannot write", store=tmp_path / "file" / "below")
    refused("cannot write", store="a\0b")
    refused("netCDF", small_scene().wanting({"a/b": sf.Max(X)}), store=tmp_path / "s")
    sf.sweep(small_scene(), {"v_b": [0.1]}, store=tmp_path / "s")
    (tmp_path / "s" / "result.nc").write_bytes(b"CDF\x01")
    refused("result.nc is damaged", grid={"v_b": [0.1]}, store=tmp_path / "s")


def test_a_full_disk_is_said_in_a_line(tmp_path, monkeypatch):
    def full(_file, _data):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("symfric.ensemble.store.os.write", full)
    with pytest.raises(sf.RunFailed, match="No space left on device"):
        sf.sweep(small_scene(), {"v_b": [0.1]}, store=tmp_path / "s")


def test_the_fingerprint_sees_a_sample():
    scene = shaken()
    signal = sf.Signal(np.array([0.0, 1e-300]), 1.0)
    assert fingerprint(scene) != fingerprint(replace(scene, inputs={"a_g": signal}))


def brief(horizon=5.0):
    base = sf.scenes.coulomb_oscillator(0.1, horizon=horizon)
    return base.wanting({"top": sf.Max(base.system.q[0])}), {"delta": [0.05, 0.1, 0.15]}


def test_a_flipped_bit_of_the_result_is_said_wherever_it_is(tmp_path):
    right = sf.sweep(*brief(), store=tmp_path / "s")
    place = tmp_path / "s" / "result.nc"
    whole, rnd = place.read_bytes(), np.random.default_rng(5)
    for at in [0, len(whole) - 1, whole.index(b"sha256:") + 2, *rnd.integers(0, len(whole), 20)]:
        changed = bytearray(whole)
        changed[at] ^= 1 << int(rnd.integers(8))
        place.write_bytes(changed)
        refused("damaged or of another sweep", *brief(), store=tmp_path / "s")
    for changed in (b"", whole[:-1], whole + b"\0", whole.replace(b"sha256:", b"")):
        place.write_bytes(changed)
        refused("damaged or of another sweep", *brief(), store=tmp_path / "s")
    place.write_bytes(whole)
    assert right.identical(sf.sweep(*brief(), store=tmp_path / "s"))
    place.unlink()  # the cure that the message names
    assert right.identical(sf.sweep(*brief(), store=tmp_path / "s"))


def test_files_of_another_sweep_are_not_taken_for_its_own(tmp_path, monkeypatch):
    right = sf.sweep(*brief(), store=tmp_path / "s")
    sf.sweep(*brief(horizon=0.5), store=tmp_path / "other")
    (tmp_path / "s" / "result.nc").write_bytes((tmp_path / "other" / "result.nc").read_bytes())
    refused("of another sweep", *brief(), store=tmp_path / "s")
    (tmp_path / "s" / "result.nc").unlink()
    with monkeypatch.context() as patch:
        patch.setattr(Store, "finish", lambda self, _: self.close())
        sf.sweep(*brief(horizon=0.5), store=tmp_path / "third")
    (cases,) = (tmp_path / "third").glob("cases-*.bin")
    (tmp_path / "s" / cases.name).write_bytes(cases.read_bytes())
    assert right.identical(sf.sweep(*brief(), store=tmp_path / "s"))


def test_two_sweeps_that_begin_at_once_do_not_share_a_store(tmp_path):
    abouts = [{"sweep": str(k), "code": "1"} for k in range(8)]
    gate = threading.Barrier(len(abouts))

    def claim(about):
        gate.wait()
        try:
            return Store(tmp_path / "s", about, 1)._identity.decode()
        except sf.SceneError as error:
            return str(error)

    for turn in range(10):
        with ThreadPoolExecutor(len(abouts)) as pool:
            found = list(pool.map(claim, abouts))
        assert sum("another sweep" in f for f in found) == len(abouts) - 1, (turn, found)
        shutil.rmtree(tmp_path / "s")


def test_two_processes_may_finish_one_sweep(tmp_path):
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda _: sf.sweep(*brief(), store=tmp_path / "s", jobs=1), range(4)))
    assert all(f.identical(found[0]) for f in found)
    assert found[0].identical(sf.sweep(*brief(), store=tmp_path / "s"))
    assert not list((tmp_path / "s").glob("*.part"))
