"""Calls of over a second show what they are at: on a terminal, in a notebook, in scripts; an interrupt leaves nothing."""

import logging
import os
import re
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric import long_calls, shown_progress
from symfric.long_calls import logged, tell, tell_of_run
from tests.longer import longer

BELT = sf.scenes.mass_on_belt(v_b=0.4)
X = BELT.system.q[0]
COUNTED = """
import sys, time
from symfric import long_calls
import symfric as sf
long_calls.PATIENCE = 0.2
@long_calls.logged
def count(n):
    for k in range(n):
        long_calls.tell(f"{k} of {n}", k / n)
        time.sleep(0.1)
"""


@pytest.fixture
def shown(monkeypatch):
    """What is shown, as (name, words, fraction), with the ends as (name, "end", None)."""
    said = []

    class Kept(shown_progress.Surface):
        def __init__(self, name, _log):
            self.name = name

        def update(self, words, fraction, spent):
            said.append((self.name, words, fraction))

        def close(self, spent):
            said.append((self.name, "end", None))

    monkeypatch.setattr(long_calls, "opened", Kept)
    monkeypatch.setattr(long_calls, "PATIENCE", 0.02)
    monkeypatch.setattr(long_calls, "INTERVAL", 0.02)
    watch = long_calls._Watch()  # that of the module may sleep after an earlier call
    watch.shown = True
    monkeypatch.setattr(long_calls, "_watch", watch)
    return said


@logged
def inner(parts):
    for k in range(parts):
        tell(f"part {k}", k / parts)
        time.sleep(0.01)


@logged
def outer(parts):
    tell("outside", 0.5)
    inner(parts)


def test_a_call_tells_what_it_is_at_and_ends(shown):
    inner(20)
    assert [s for s in shown if s[1].startswith("part") and 0 < s[2] < 1]
    assert shown[-1] == ("inner", "end", None)
    assert len([s for s in shown if s[1] == "end"]) == 1
    assert long_calls._watch._calls == []


def test_a_call_within_another_adds_words_and_no_fraction(shown):
    outer(20)
    assert {s[0] for s in shown} == {"outer"}
    assert [s for s in shown if re.fullmatch(r"outside, part \d+", s[1])]
    assert {s[2] for s in shown if s[1].startswith("outside")} == {0.5}


def test_a_short_call_shows_nothing(shown):
    sf.equilibrium(BELT)
    assert shown == []


def test_calls_from_several_threads_are_shown_side_by_side(shown):
    threads = [threading.Thread(target=inner, args=(20,)) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len([s for s in shown if s[1] == "end"]) == 3
    assert long_calls._watch._calls == []


def test_no_thread_is_left_once_there_are_no_calls(shown):
    inner(5)
    until = time.monotonic() + 10
    while long_calls._watch._thread is not None:
        assert time.monotonic() < until
        time.sleep(0.01)
    inner(20)
    assert [s for s in shown if s[1].startswith("part")]


def test_an_interrupted_call_is_no_longer_shown(shown, monkeypatch):
    def interrupted():
        time.sleep(0.1)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        logged(interrupted)()
    assert shown[-1][1] == "end"
    assert long_calls._watch._calls == []


def test_nothing_is_shown_when_switched_off(shown):
    sf.show_progress(False)
    inner(8)
    sf.show_progress(True)
    assert shown == []


def test_a_long_run_of_a_program_is_shown_with_its_fraction(shown):
    program = sf.prepare(BELT.where({"v_b": 0.2}).until(2.0e6).wanting({"end": sf.End()}))
    shown.clear()
    program.run()
    fractions = [f for name, _, f in shown if name == "run" and f is not None]
    assert fractions
    assert np.all(np.diff(fractions) >= 0)
    assert 0 < fractions[-1] <= 1


KINDS = {
    "limit_cycle": lambda: sf.limit_cycle(BELT.where({"v_b": 0.2})),
    "continue_cycle": lambda: sf.continue_cycle(BELT, "v_b", (0.39, 0.41)),
    "lyapunov": lambda: sf.lyapunov(BELT, 50.0),
    "map": lambda: sf.prepare(BELT.wanting({"x": sf.Max(X)})).map({"v_b": np.linspace(0.1, 0.4, 2000)}),
    "sweep": lambda: sf.sweep(BELT.wanting({"x": sf.Max(X)}), {"v_b": np.linspace(0.1, 0.4, 20)}),
    "damper": lambda: sf.design.damper(BELT, "beta", bounds=(0, 1), speeds=(0.3, 0.45)),
}


@pytest.mark.parametrize("kind", longer(KINDS, ["limit_cycle", "map", "sweep", "damper"]))
def test_the_package_tells_what_its_long_calls_are_at(shown, monkeypatch, kind):
    """Words or fractions of every kind of call, whether or not it is long enough to be seen here."""
    told = []
    KINDS[kind]()  # loads the modules that tell
    for name, module in list(sys.modules.items()):
        if name.startswith("symfric.") and vars(module).get("tell") is tell:
            monkeypatch.setattr(module, "tell", lambda words, fraction=None: told.append((words, fraction)))
    KINDS[kind]()
    assert told
    if kind == "continue_cycle":
        assert any(re.match(r"6 orbits to v_b = 0\.\d+", words) for words, _ in told)
    if kind == "lyapunov":
        assert all(0 <= f <= 1 for _, f in told)


def test_a_short_call_costs_microseconds():
    @logged
    def nothing():
        pass

    nothing()
    costs = []
    for _ in range(5):
        begin = time.process_time()
        for _ in range(1000):
            nothing()
        costs.append((time.process_time() - begin) / 1000)
    assert min(costs) < 2e-5


def script(code, **environment):
    return subprocess.run(
        [sys.executable, "-c", COUNTED + code],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=True,
    )


SCRIPTS = [  # what is before the call, and what it then writes on stderr
    ("", r"symfric: count: \d+ %, \d of 5\nsymfric: count: \d+\.\d s\n"),
    (
        "import logging; logging.basicConfig(level='INFO', format='LOG %(message)s'); ",
        r"LOG count: \d+ %, \d of 5\nLOG count: 0\.\d s\n",
    ),
    ("import logging; logging.basicConfig(); ", ""),
    ("sf.show_progress(False); ", ""),
]


@pytest.mark.parametrize("way", longer(range(len(SCRIPTS)), [2, 3]))
def test_a_script_gets_lines_on_stderr_or_from_its_log_or_none(way):
    before, written = SCRIPTS[way]
    assert re.fullmatch(written, script(f"{before}count(5)").stderr)


@pytest.mark.long(beside="test_a_script_gets_lines_on_stderr_or_from_its_log_or_none")
def test_a_script_may_switch_lines_off_or_have_no_stderr():
    assert script("count(5)", SYMFRIC_PROGRESS="0").stderr == ""
    assert script("sys.stderr.close(); count(5); print('ended')").stdout == "ended\n"


def on_terminal(code, interrupt_at=None):
    """Return what a program writes on a terminal, and its exit status."""
    import pty

    main, side = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-c", COUNTED + code],
        stdin=side,
        stdout=side,
        stderr=side,
        env={**os.environ, "TERM": "xterm", "COLUMNS": "100"},
        start_new_session=True,
    )
    os.close(side)
    written = b""
    while True:
        try:
            new = os.read(main, 4096)
        except OSError:
            break
        if not new:
            break
        written += new
        if interrupt_at and interrupt_at in written:
            process.send_signal(signal.SIGINT)
            interrupt_at = None
    os.close(main)
    return written.decode(), process.wait(60)


@pytest.mark.long(beside="test_an_interrupt_leaves_no_bar_on_a_terminal")
@pytest.mark.skipif(os.name != "posix", reason="terminals of POSIX")
def test_a_terminal_has_a_bar_that_disappears():
    written, status = on_terminal("count(8); print('after')")
    assert status == 0
    assert re.search(r"count: \d of 8", written)
    assert "\x1b[?25h" in written  # the cursor is back
    last = written[written.rindex("of 8") :]
    assert "\x1b[2K" in last  # the line of the bar is erased
    assert re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", last).strip().endswith("after")


@pytest.mark.skipif(os.name != "posix", reason="terminals of POSIX")
def test_an_interrupt_leaves_no_bar_on_a_terminal():
    code = "\ntry:\n    count(600)\nexcept KeyboardInterrupt:\n    print('after')"
    written, status = on_terminal(code, interrupt_at=b"of 600")
    assert status == 0
    last = written[written.rindex("of 600") :]
    assert "\x1b[?25h" in last
    assert "\x1b[2K" in last
    assert re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", last).strip().endswith("after")


def test_a_notebook_has_a_bar_below_the_cell_of_the_call():
    pytest.importorskip("ipykernel", reason="no notebooks without the extra docs")
    NotebookClient = pytest.importorskip("nbclient").NotebookClient
    from nbformat.v4 import new_code_cell, new_notebook

    cells = [new_code_cell(COUNTED + "count(5)"), new_code_cell("print('second')\ncount(5)"), new_code_cell("count(1)")]
    shown = {k: [] for k in range(len(cells))}
    client = NotebookClient(new_notebook(cells=cells), timeout=120, kernel_name="python3")
    output = client.output

    def noted(outs, message, display_id, cell_index):
        shown[cell_index].append(message)
        return output(outs, message, display_id, cell_index)

    client.output = noted
    client.execute()
    for k in (0, 1):
        told = [m for m in shown[k] if m["msg_type"] == "display_data"]
        assert len(told) == 1
        assert "<progress" in told[0]["content"]["data"]["text/html"]
        (left,) = [o for o in client.nb.cells[k].outputs if o.output_type == "display_data"]
        assert left.data["text/html"] == ""  # nothing is left of it
    assert client.nb.cells[2].outputs == []


def interrupt_after(monkeypatch, module, count):
    """Interrupt a call when it tells something for the given time."""
    calls = iter(range(10**9))

    def telling(words, fraction=None):
        if next(calls) >= count:
            raise KeyboardInterrupt

    monkeypatch.setattr(module, "tell", telling)


def test_an_interrupted_branch_is_kept_on_request(monkeypatch, caplog):
    from symfric.orbits.continuation import walk

    whole = sf.continue_cycle(BELT, "v_b", (0.38, 0.42))
    for count in (1, 4):
        interrupt_after(monkeypatch, walk, count)
        with pytest.raises(KeyboardInterrupt):
            sf.continue_cycle(BELT, "v_b", (0.38, 0.42))
        interrupt_after(monkeypatch, walk, count)
        with sf.keep_when_interrupted():
            part = sf.continue_cycle(BELT, "v_b", (0.38, 0.42))
        assert part.ends == ("interrupted", "interrupted")
        assert "interrupted" in repr(part)
        assert len(part.orbits) == count + 2
        there = [int(np.argmin(abs(whole.values - v))) for v in part.values]
        assert np.allclose(whole.values[there], part.values, rtol=1e-9)
    assert "continue_cycle was interrupted" in caplog.text


def test_an_interrupted_sweep_keeps_its_cases_and_goes_on_in_its_store(monkeypatch, tmp_path):
    from symfric.ensemble import scheduler

    scene, grid = BELT.wanting({"x": sf.Max(X)}), {"v_b": np.linspace(0.1, 0.4, 400)}
    whole, count, original = sf.sweep(scene, grid), [0], scheduler.Meter.__call__

    def interrupted(self, done, last=False):
        count[0] += 1
        if count[0] == 2:
            raise KeyboardInterrupt
        return original(self, done, last)

    monkeypatch.setattr(scheduler, "INTERVAL", 0.002)
    monkeypatch.setattr(scheduler, "BLOCK_SECONDS", 1e-4)
    monkeypatch.setattr(scheduler.Meter, "__call__", interrupted)
    with sf.keep_when_interrupted():
        part = sf.sweep(scene, grid, store=tmp_path / "cases")
    missing = part.status.values == -3
    assert missing.any()
    assert np.isnan(part.x.values[missing]).all()
    assert np.array_equal(part.x.values[~missing], whole.x.values[~missing])
    monkeypatch.setattr(scheduler.Meter, "__call__", original)
    assert np.array_equal(sf.sweep(scene, grid, store=tmp_path / "cases").x, whole.x)


@pytest.mark.one_in(4)
@pytest.mark.parametrize(("route", "threads"), [("taylor", 1), ("taylor", 2), ("integrators", 1), ("integrators", 2)])
def test_an_interrupted_map_keeps_its_cases(monkeypatch, route, threads):
    from symfric.solve.loop import cases as case_loop

    monkeypatch.setattr(case_loop, "_INTERVAL", 0.001)
    program = sf.prepare(BELT.wanting({"x": sf.Max(X)}).until(20.0), 1e-8, route=route)
    size = 12 if route == "integrators" else 20_000
    cases = {"v_b": np.linspace(0.3, 0.4, size)}
    whole = program.map(cases)
    told = []

    def interrupted(part):
        told.append(part)
        if part > 0:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        program.map(cases, threads=threads, progress=interrupted)
    with sf.keep_when_interrupted():
        part = program.map(cases, threads=threads, progress=interrupted)
    missing = part.status == -3
    assert 0 < missing.sum() < size
    assert np.isnan(part["x"][missing]).all()
    assert np.isnan(part.final[:, missing]).all()
    assert np.array_equal(part["x"][~missing], whole["x"][~missing])
    assert part.to_dict()["status"].count("NOT_COMPUTED") == missing.sum()
    assert part.to_xarray().status.attrs["flag_meanings"].startswith("NOT_COMPUTED")
    with pytest.raises(sf.RunFailed, match="NOT_COMPUTED"):
        part.checked()


def test_a_sweep_does_not_take_a_part_of_a_map_for_the_whole(monkeypatch):
    from symfric.solve.loop import cases

    interrupt_after(monkeypatch, cases, 0)
    with sf.keep_when_interrupted():
        part = sf.sweep(BELT.wanting({"x": sf.Max(X)}), {"v_b": np.linspace(0.1, 0.4, 50)})
    assert (part.status.values == -3).all()


def test_interrupted_basins_keep_their_attractors(monkeypatch):
    from symfric.ensemble import basins

    scene = sf.scenes.mass_on_belt(sf.laws.exponential(0.4), v_b=1.6).until(400)
    starts = {"x": [0.5, 3.0, 0.6]}
    whole = sf.basins(scene, starts)
    interrupt_after(monkeypatch, basins, 1)
    with pytest.raises(KeyboardInterrupt):
        sf.basins(scene, starts)
    interrupt_after(monkeypatch, basins, 1)
    with sf.keep_when_interrupted():
        part = sf.basins(scene, starts)
    left = part.status == -3
    assert left.any()
    assert (part.label[left] == -1).all()
    assert not left.all()
    kinds = [[None if k < 0 else found.attractors[k].kind for k in found.label] for found in (part, whole)]
    assert all(one is None or one == other for one, other in zip(*kinds, strict=True))


def test_interrupted_exponents_and_fits_are_kept(monkeypatch):
    from symfric.identification import starts
    from symfric.orbits import lyapunov

    interrupt_after(monkeypatch, lyapunov, 300)
    with sf.keep_when_interrupted():
        part = sf.lyapunov(BELT, 200.0)
    assert 0 < part.times[-1] < 200.0
    assert part.times.size == part.history.size
    interrupt_after(monkeypatch, lyapunov, 3)
    with sf.keep_when_interrupted(), pytest.raises(KeyboardInterrupt):  # within the transient
        sf.lyapunov(BELT, 200.0)
    scene = sf.scenes.coulomb_oscillator(0.03)
    t = np.linspace(0.1, 40.0, 100)
    y = sf.simulate(scene)(t)[0] + 0.01 * np.random.default_rng(0).standard_normal(t.size)
    minimise, tries = starts.minimise, []

    def interrupted(*args):
        tries.append(1)
        if len(tries) > 2:
            raise KeyboardInterrupt
        return minimise(*args)

    monkeypatch.setattr(starts, "minimise", interrupted)
    with sf.keep_when_interrupted():
        fit = sf.identify(scene, {"x": (t, y)}, {"delta": (0.001, 0.05)}, starts=6)
    assert abs(fit.values["delta"] - 0.03) < 5 * fit.standard_errors["delta"]


def test_an_interrupted_comparison_holds_the_laws_and_settings_tried(monkeypatch):
    from symfric.identification import comparison, experiments

    scene, t = sf.scenes.coulomb_oscillator(0.03, delta_s=0.05), np.linspace(0.1, 40.0, 100)
    y = sf.simulate(scene)(t)[0] + 0.01 * np.random.default_rng(0).standard_normal(t.size)
    laws, ask = {"one": scene, "two": scene, "three": scene}, ({"x": (t, y)}, {"delta": (0.001, 0.05)})

    def after(patch, module, name, count):
        """Interrupt the call of a function after so many."""
        own, calls = getattr(module, name), []

        def interrupted(*args, **kwargs):
            calls.append(1)
            if len(calls) > count:
                raise KeyboardInterrupt
            return own(*args, **kwargs)

        patch.setattr(module, name, interrupted)

    with monkeypatch.context() as patch:
        after(patch, comparison, "identify", 1)
        with sf.keep_when_interrupted():
            table = sf.compare_laws(laws, *ask, starts=2)
        assert [s.name for s in table] == ["one"]
        assert table.failed == {"two": "interrupted", "three": "interrupted"}
        with sf.keep_when_interrupted(), pytest.raises(KeyboardInterrupt):  # nothing was fitted
            sf.compare_laws(laws, *ask, starts=2)
    fit = sf.identify(scene, *ask, starts=2)
    whole = sf.test_design(fit, {"x0": [0.5, 1.0, 2.0]})
    after(monkeypatch, experiments, "_information", 2)
    with sf.keep_when_interrupted():
        part = sf.test_design(fit, {"x0": [0.5, 1.0, 2.0]})
    assert part.candidates == whole.candidates[:2]
    assert part.gains == pytest.approx(whole.gains[:2])
    with pytest.raises(KeyboardInterrupt):
        sf.test_design(fit, {"x0": [0.5, 1.0, 2.0]})


def test_an_interrupt_within_a_design_ends_it_even_then(monkeypatch):
    """A design must not take a part of a branch for the whole."""
    from symfric.orbits.continuation import walk

    interrupt_after(monkeypatch, walk, 0)
    with sf.keep_when_interrupted(), pytest.raises(KeyboardInterrupt):
        sf.design.damper(BELT, "beta", bounds=(0, 1), speeds=(0.3, 0.45), half_range=0.1)


def test_interrupted_designs_are_the_best_ones_until_then(monkeypatch):
    from symfric.design.damper import best_load
    from symfric.design.isolator import design

    W, N, x, u = *sp.symbols("W N", positive=True), *sp.symbols("x u", real=True)
    system = sf.System([x], [u], [[1]], [-x - u / 50 + sp.cos(W * sf.TIME)])
    joint = sf.Contact("joint", slip=u, normal=N, law=sf.laws.coulomb(0.5))
    scene = sf.Scene(system, [joint], {W: 0.9, N: 0.4}, {x: 0, u: 0}, horizon=100.0)
    ask = {"bounds": (0.5, 1.2), "speeds": (0.9, 1.1), "speed": "W"}
    interrupt_after(monkeypatch, best_load, 2)
    with pytest.raises(KeyboardInterrupt):
        sf.design.damper(scene, "N", **ask)
    interrupt_after(monkeypatch, best_load, 2)
    with sf.keep_when_interrupted():
        part = sf.design.damper(scene, "N", **ask)
    assert part.status == "unverified"
    assert "interrupted" in part.doubts[0]
    assert part.curve.x.size == 2
    assert part.objective == part.curve.y.min()
    quake = sf.motions.sine_burst(3.0, 1.0, cycles=5)
    building = sf.scenes.rolling_isolator(C=1e5, m=3e5, motion=quake, profile=0.01)
    given = building, [quake], {"C": (1e3, 1e6)}
    interrupt_after(monkeypatch, design, 1)
    with sf.keep_when_interrupted():
        part = sf.design.isolator(*given, limits={"displacement": 0.15})
    assert part.status == "unverified"
    assert part.to_dict()["check"]["agrees"] is False
    interrupt_after(monkeypatch, design, 0)
    with sf.keep_when_interrupted(), pytest.raises(KeyboardInterrupt):  # nothing was computed
        sf.design.isolator(*given, limits={"displacement": 0.15})


def test_calls_outside_a_shown_one_tell_nothing():
    tell("nothing", 0.5)
    tell_of_run(0.5)
    assert logging.getLogger("symfric").handlers == []
