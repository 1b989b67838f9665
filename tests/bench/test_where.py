"""The table of where CPU time goes: all of it is shared out, and known work counts as what it is."""

import json
import signal
import time

import pytest
import sympy as sp
from click.testing import CliRunner

import symfric as sf
from symfric.cli import main
from symfric.errors import SceneError
from symfric_evidence.bench import where
from symfric_evidence.bench.calls import CALLS

pytestmark = pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no timer of CPU time on this system")
BELT = sf.scenes.mass_on_belt(v_b=0.2)


def sampled(call):
    sampler = where.Sampler()
    before = time.process_time()
    sampler.measure(call)
    return sampler, time.process_time() - before


def test_all_time_is_shared_out():
    sampler, taken = sampled(lambda: sf.limit_cycle(BELT))
    assert set(sampler.seconds) == set(where.KINDS)
    assert sum(sampler.seconds.values()) == pytest.approx(taken, rel=0.1, abs=2e-3)
    assert 0 < sampler.varied < sampler.runs


def expanded():
    x = sp.Symbol("x")
    return sp.expand((x + sum(sp.symbols("a:12"))) ** 5)


@pytest.fixture(scope="module")
def many_runs():
    program = sf.prepare(BELT.wanting({"end": sf.End()}).until(2e4))
    program.run()
    return lambda: [program.run() for _ in range(20)]


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("call", "kind"), [(lambda _: expanded, "equations"), (lambda runs: runs, "runs")])
def test_known_work_counts_as_what_it_is(call, kind, many_runs):
    sampler, taken = sampled(call(many_runs))
    assert taken > 0.02
    assert sampler.seconds[kind] > 0.5 * taken


def test_the_sampler_leaves_nothing_behind():
    before, drive = signal.getsignal(signal.SIGPROF), where.compiled_model.Workspace.drive
    with pytest.raises(ZeroDivisionError):
        where.Sampler().measure(lambda: 1 / 0)
    assert signal.getsignal(signal.SIGPROF) is before
    assert where.compiled_model.Workspace.drive is drive
    assert signal.getitimer(signal.ITIMER_PROF) == (0.0, 0.0)


@pytest.mark.long(beside="test_known_work_counts_as_what_it_is")
def test_a_call_is_measured_in_new_processes(tmp_path, monkeypatch):
    name = "limit cycle, two masses"
    cold, warm, again = where.where([name])
    if cold.seconds["compilation"] < 5 * warm.seconds["compilation"]:  # 7 to 9; loading takes few ticks of the timer
        cold, warm, again = where.where([name])
    assert [share.state for share in (cold, warm, again)] == list(where.STATES)
    assert cold.total > warm.total > again.total
    assert cold.seconds["compilation"] > 5 * warm.seconds["compilation"]
    assert cold.runs == warm.runs == again.runs
    monkeypatch.setattr(where, "where", lambda progress: (cold,))
    told = CliRunner().invoke(main, ["bench", "--where", "--json", "--quiet", "-o", str(tmp_path)])
    assert told.exit_code == 0, told.output
    assert json.loads(told.output)["where"] == [cold.to_dict()] == json.loads((tmp_path / "where.json").read_text())
    printed = CliRunner().invoke(main, ["bench", "--where", "--quiet"], env={"COLUMNS": "200"})
    assert name in printed.output


def test_unknown_calls_are_named():
    with pytest.raises(SceneError, match="no call 'bread'; there are limit cycle, two masses"):
        where.where(["bread"])
    assert len(CALLS) == 10
