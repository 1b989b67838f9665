"""One program in several threads, in its own progress callback, after failures, in other processes; its memory."""

import gc
import multiprocessing
import os
import pickle
import random
import subprocess
import sys
import threading
import time
from concurrent import futures

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.solve.loop import compiled_model
from symfric.solve.loop.compiled_model import CompiledModel
from tests.longer import longer
from tests.threads.together import THREADS, difference, together

X = sp.Symbol("x", real=True)
SAMPLES = sf.Signal(np.sin(0.05 * np.arange(400)), 0.05)
SCENES = {
    "series": lambda: sf.scenes.mass_on_belt(v_b=0.2, horizon=40.0),
    "scalars": lambda: sf.scenes.mass_on_belt(v_b=0.2, horizon=40.0).wanting({"high": sf.Max(X), "end": sf.End()}),
    "closed form": lambda: sf.scenes.coulomb_oscillator(0.01),
    "record": lambda: sf.scenes.rolling_isolator(C=1.0, m=10.0, motion=SAMPLES, profile=0.02).wanting(
        {"path": sf.Trajectory()}
    ),
    "matrices": lambda: sf.scenes.two_slides(r=0.5, zeta=0.1, s1=0.05, s2=0.02, fc1=0.2, fs1=0.3, horizon=40.0),
}
VARIED = {"series": "v_b", "scalars": "beta", "closed form": "x0", "record": "mu", "matrices": "fs1"}


def values_of(name, k):
    return {VARIED[name]: {"v_b": 0.1, "beta": 0.0, "x0": 1.0, "mu": 0.01, "fs1": 0.3}[VARIED[name]] + 0.01 * k}


def program_of(name, **options):
    return sf.prepare(SCENES[name](), 1e-9, **options)


def shared(program, values, rounds, most=12):
    """Run one program from several threads with different values; return what differs from the serial runs."""
    serial = [program.run(values(k)) for k in range(most)]

    def work(thread):
        rng = random.Random(thread)
        order = [rng.randrange(most) for _ in range(rounds)]
        return [d for k in order if (d := difference(serial[k], program.run(values(k)), f"run {k}"))]

    return [d for part in together(work) for d in part]


@pytest.mark.one_in(6)
@pytest.mark.parametrize("rounds", longer([500, 3000], [3000]))
@pytest.mark.parametrize("name", SCENES)
def test_one_program_with_different_values(name, rounds):
    assert shared(program_of(name), lambda k: values_of(name, k), rounds) == []


@pytest.mark.long(beside="test_one_program_with_different_values")
@pytest.mark.parametrize("options", [{"route": "integrators"}, {"sensitivities": ["v_b", "x"]}], ids=str)
def test_one_program_of_the_other_routes(options):
    program = sf.prepare(SCENES["series"]().until(15.0), 1e-6, **options)
    assert shared(program, lambda k: {"v_b": 0.1 + 0.01 * k}, 6, most=4) == []


def test_what_a_program_is_widened_for_does_not_depend_on_the_runs_before():
    runs = [{"a": 0.01, "Omega": 3.0}, {"beta": 0.1}, {"a": 0.02, "Omega": 3.0, "gamma2": 1.1}, {}]
    scene = sf.scenes.mass_on_belt(v_b=0.2, beta=0.0, horizon=20.0)
    alone = [sf.prepare(scene).run(values) for values in runs]
    program = sf.prepare(scene)
    for k in (0, 1, 2, 3, 1, 0, 3, 2):
        assert difference(alone[k], program.run(runs[k]), str(k)) == ""
    fresh = sf.prepare(scene)
    assert [difference(alone[k], r) for k, r in enumerate(together(lambda k: fresh.run(runs[k])))] == [""] * THREADS


def test_a_flow_and_a_function_are_shared():
    scene = SCENES["scalars"]()
    function = sf.as_function(scene, ["v_b"], ["high"], 1e-9)
    jacobian = function.jacobian()
    serial = [(float(function(0.1 + 0.01 * k)), float(jacobian(0.1 + 0.01 * k, 0))) for k in range(8)]

    def work(thread):
        order = [(thread + 3 * k) % 8 for k in range(24)]
        return [serial[k] == (float(function(0.1 + 0.01 * k)), float(jacobian(0.1 + 0.01 * k, 0))) for k in order]

    assert all(map(all, together(work)))


@pytest.mark.parametrize("rounds", longer([1, 50], [50]))
def test_limit_cycles_with_one_cached_flow(rounds):
    speeds = np.linspace(0.05, 0.39, 12)
    size = lambda v: sf.limit_cycle(sf.scenes.mass_on_belt(v_b=float(v))).half_range  # noqa: E731
    serial = [size(v) for v in speeds]
    for _ in range(rounds):
        for part in together(lambda k: [(i, size(speeds[i])) for i in range(k, len(speeds), THREADS)]):
            assert [i for i, found in part if not np.array_equal(found, serial[i])] == []


@pytest.mark.long(beside="test_one_program_with_different_values")
def test_a_program_runs_inside_its_own_progress_callback():
    program = sf.prepare(sf.scenes.mass_on_belt(v_b=0.2, horizon=1.2e6).wanting({"high": sf.Max(X)}))
    plain, inner = program.run(), []

    def progress(_):
        if not inner:
            inner.append(program.run({"v_b": 1.0}))

    assert difference(plain, program.run(progress=progress)) == ""
    assert difference(inner[0], program.run({"v_b": 1.0})) == ""


@pytest.mark.long(beside="test_a_run_that_is_interrupted_leaves_nothing")
@pytest.mark.parametrize("output", [sf.Trajectory(), sf.Events(), sf.Max(X)], ids=lambda o: type(o).__name__)
def test_progress_is_told_about_once_in_a_million_steps_whatever_is_kept(output):
    program = sf.prepare(sf.scenes.mass_on_belt(v_b=0.2, horizon=2e6).wanting({"kept": output}))
    told = []
    run = program.run(progress=told.append)
    assert run.stats["steps"] // 1_000_000 >= 2
    assert len(told) in (run.stats["steps"] // 1_000_000, run.stats["steps"] // 1_000_000 - 1)
    assert told == sorted(told)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("failure", [RuntimeError, KeyboardInterrupt])
def test_a_run_that_is_interrupted_leaves_nothing(failure):
    program = sf.prepare(sf.scenes.mass_on_belt(v_b=0.2, horizon=1.2e6).wanting({"events": sf.Events()}))
    short = {"v_b": 1.0}
    expected = program.run(short)

    def progress(_):
        raise failure("stop")

    for _ in range(3):
        with pytest.raises(failure, match="stop"):
            program.run(progress=progress)
        assert difference(expected, program.run(short)) == ""


@pytest.mark.parametrize("name", SCENES)
def test_runs_change_nothing_of_the_model(name):
    program = program_of(name)
    before = {n: a.copy() for n, a in program._model.first.items()}
    for k in range(3):
        program.run(values_of(name, k))
    assert all(np.array_equal(before[n], a, equal_nan=True) for n, a in program._model.first.items())


def test_the_motion_does_not_depend_on_the_room_there_is():
    for name, scene in SCENES.items():
        first = sf.prepare(scene())
        once, again = first.run(), first.run()
        assert difference(once, again, name) == ""


def test_few_large_workspaces_are_kept():
    program = program_of("series")
    model: CompiledModel = program._model
    leases = [model.workspace() for _ in range(20)]
    for lease in leases:
        lease.large = True
        model.give_back(lease)
    assert len(model._idle) == 1
    for lease in leases:
        lease.large = False
        model.give_back(lease)
    assert len(model._idle) <= 16


@pytest.mark.parametrize("name", ["series", "closed form", "record"])
def test_pieces_of_a_trajectory_are_one_trajectory(name, monkeypatch):
    whole = program_of(name).run()
    program = program_of(name)
    monkeypatch.setattr(compiled_model, "_CHUNK_BYTES", 64 * 1024)
    assert difference(whole, program.run()) == ""
    assert difference(whole, program.run()) == ""


PEAK = """
import resource, sys
import symfric as sf
from symfric.solve.loop import compiled_model
compiled_model.PATH_BYTES = limit = 2**27
compiled_model._CHUNK_BYTES = 2**23
peak = lambda: 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
scene = {"series": sf.scenes.mass_on_belt(v_b=0.2), "closed": sf.scenes.coulomb_oscillator(1e-9)}[sys.argv[1]]
sf.simulate(scene.until(20.0))
program, before = sf.prepare(scene.until(1e9)), peak()
run = program.run()
assert run.status == sf.Status.STEP_BUDGET, run
assert run.path.coefficients.nbytes > 0.99 * limit
print((peak() - before) / limit)
"""


@pytest.mark.one_in(2)
@pytest.mark.skipif(sys.platform != "linux", reason="ru_maxrss is in kilobytes on Linux")
@pytest.mark.parametrize("kind", ["series", "closed"])
def test_a_full_trajectory_takes_little_more_memory_than_itself(kind):
    done = subprocess.run([sys.executable, "-c", PEAK, kind], capture_output=True, text=True, check=True)
    assert float(done.stdout) < 1.35  # times, modes, events and one piece come on top


COLD = """
import sys, threading
import symfric as sf
sys.setswitchinterval(1e-6)
found, start = [None] * 4, threading.Barrier(4)
def work(k):
    start.wait()
    run = sf.simulate(sf.scenes.mass_on_belt(v_b=0.2) if k % 2 else sf.scenes.coulomb_oscillator(0.1))
    found[k] = run.status.name, [v.hex() for v in run.final]
crew = [threading.Thread(target=work, args=(k,)) for k in range(4)]
[t.start() for t in crew]
[t.join() for t in crew]
assert found[0] == found[2] and found[1] == found[3], found
print(found[0][0], found[1][0])
"""


@pytest.mark.parametrize("cold", longer([False, True], [True]), ids=["compiled before", "nothing compiled"])
def test_the_first_call_ever_from_four_threads(cold, tmp_path):
    environment = {**os.environ, "SYMFRIC_CACHE_DIR": str(tmp_path / "cache")} if cold else None
    done = subprocess.run([sys.executable, "-c", COLD], capture_output=True, text=True, env=environment, check=True)
    assert done.stdout.split() == ["OK", "OK"]


def run_in_child(program, k):
    return program.run({"v_b": 0.1 + 0.01 * k})


def _final(run):
    return run.final.tobytes()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_a_fork_waits_for_a_thread_that_is_in_the_compiler():
    """As one is that lets go of machine code; a child would wait for it for ever."""
    from llvmlite.binding import ffi

    program_of("scalars")
    within, context = threading.Event(), multiprocessing.get_context("fork")

    def hold():
        with ffi.lib._lock:
            within.set()
            time.sleep(0.3)

    thread = threading.Thread(target=hold)
    thread.start()
    within.wait()
    child = context.Process(target=lambda: sf.prepare(SCENES["scalars"]()), daemon=True)
    child.start()
    thread.join()
    child.join(60)
    done = child.exitcode
    child.kill()
    assert done == 0


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_processes_forked_after_use_and_while_threads_run():
    program = program_of("scalars")
    expected = [_final(program.run({"v_b": 0.1 + 0.01 * k})) for k in range(4)]
    context = multiprocessing.get_context("fork")

    def child(channel, k):
        fresh = sf.simulate(SCENES["scalars"]().where({"v_b": 0.1 + 0.01 * k}))
        channel.send((_final(program.run({"v_b": 0.1 + 0.01 * k})), fresh.status.name))

    def work(thread):
        if thread:
            for k in range(20):
                program.run({"v_b": 0.1 + 0.01 * (k % 4)})
                sf.prepare(SCENES["scalars"]())
            return []
        ends = [context.Pipe(duplex=False) for _ in range(4)]
        children = [context.Process(target=child, args=(ends[k][1], k), daemon=True) for k in range(4)]
        for process in children:
            process.start()
        found = [receiver.recv() if receiver.poll(120) else None for receiver, _ in ends]
        for process in children:  # CPython may wait for a thread of the parent at the end of a child, seen once
            process.join(20)
            process.kill()
        return found

    (found, *_) = together(work, 3)
    assert found == [(e, "OK") for e in expected]


@pytest.mark.one_in(2)
@pytest.mark.parametrize("kind", ["fork", "spawn"])
def test_executors(kind):
    if kind not in multiprocessing.get_all_start_methods():
        pytest.skip(f"no {kind} here")
    program = program_of("scalars")
    expected = [run_in_child(program, k) for k in range(4)]
    with futures.ProcessPoolExecutor(2 if kind == "fork" else 1, multiprocessing.get_context(kind)) as pool:
        found = list(pool.map(run_in_child, [program] * 4, range(4)))
    assert [difference(a, b) for a, b in zip(expected, found, strict=True)] == [""] * 4
    with futures.ThreadPoolExecutor(THREADS) as pool:
        found = list(pool.map(run_in_child, [program] * 40, [k % 4 for k in range(40)]))
    assert [difference(expected[k % 4], b) for k, b in enumerate(found)] == [""] * 40


@pytest.mark.parametrize("options", [{}, {"route": "integrators"}, {"sensitivities": ["v_b"]}], ids=str)
def test_programs_pickle(options):
    program = sf.prepare(SCENES["series"]().until(10.0), 1e-6, **options)
    copy = pickle.loads(pickle.dumps(program))
    assert difference(program.run({"v_b": 0.3}), copy.run({"v_b": 0.3})) == ""


@pytest.mark.long(beside="test_one_program_with_different_values")
def test_a_program_that_is_let_go_takes_its_memory_with_it():
    program = program_of("series")
    together(lambda _: program.run())
    program.run()
    count = lambda: sum(isinstance(o, CompiledModel) for o in gc.get_objects())  # noqa: E731
    before = count()
    program = None
    gc.collect()
    assert count() < before
