"""Scenes as the peers take them: every loop that is there finds the motion of the package's own routes."""

import importlib.util
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import symfric as sf
from symfric_evidence.bench import larger
from symfric_evidence.bench.many_digits import many_digits
from symfric_evidence.bench.peers import casadi_peer, diffrax_peer, heyoka_peer, scipy_peer, sundae_peer
from symfric_evidence.bench.peers.written_out import form_of
from symfric_evidence.bench.problems import named

LOOPS = {
    "scipy": scipy_peer.prepare_events,
    "casadi": casadi_peer.prepare_interpreted,
    "heyoka": heyoka_peer.prepare,
    "sksundae": sundae_peer.prepare,
    "diffrax": diffrax_peer.prepare,
}
SCENES = {  # made when a test takes them, not where tests are collected
    "slides": lambda: larger.slides().until(12.0),
    "chain": lambda: larger.chain(2, horizon=6.0),
    "record": lambda: larger.isolator().until(1.6),
    "bristles": lambda: larger.bristles().until(1.0),
    "settles": lambda: sf.scenes.coulomb_oscillator(0.1, x0=1.0).wanting({"end": sf.End()}),
    "shaken and held": lambda: sf.scenes.mass_on_belt(v_b=0.2, a=0.15, Omega=1.3, horizon=12.0).wanting(
        {"end": sf.End()}
    ),
}


@cache
def truth(name):
    return sf.simulate(SCENES[name](), 1e-12).checked()


# diffrax' root finder fails on samples that end where the guard rises from zero; the benchmark does not give it records
PAIRS = [(name, loop) for name in SCENES for loop in LOOPS if (name, loop) != ("record", "diffrax")]


@pytest.mark.one_in(9)
@pytest.mark.parametrize(("name", "loop"), PAIRS)
def test_every_loop_finds_the_motion(name, loop):
    if importlib.util.find_spec(loop) is None:
        pytest.skip(f"{loop} is not installed")
    run = LOOPS[loop](replace(named("P8"), scene=SCENES[name]()), 1e-8)
    answer, again = run(), run()
    assert answer.values == pytest.approx(truth(name).final, abs=2e-6)
    assert answer.events == truth(name).stats["events"]
    assert again == answer


def test_a_loop_that_fails_says_so_in_one_line(capfd):
    pytest.importorskip("diffrax")
    with pytest.raises(RuntimeError, match=r"^The maximum number of steps was reached.*, after t = [0-9.]+$"):
        diffrax_peer.prepare(named("P3"), 1e-12)()
    assert capfd.readouterr() == ("", "")


def test_many_digits_agree_with_the_routes():
    scene = SCENES["slides"]().until(1.0)
    answer = many_digits(scene, 24)
    run = sf.simulate(scene, 1e-14).checked()
    assert np.array(answer.final, dtype=float) == pytest.approx(run.final, abs=2e-14)
    assert answer.events == run.stats["events"]


def test_scenes_that_the_loops_cannot_take_say_so():
    with pytest.raises(NotImplementedError, match="two contacts work on one body"):
        form_of(_doubled())
    with pytest.raises(NotImplementedError, match="a smooth friction law"):
        form_of(named("P4").scene)


def _doubled():
    scene = sf.scenes.mass_on_belt(v_b=0.2)
    (contact,) = scene.contacts
    return sf.Scene(
        scene.system, [contact, replace(contact, name="second")], scene.values, scene.initial, scene.horizon
    )


def test_references_of_the_sweep_are_the_half_ranges():
    problem = named("P5")
    assert len(problem.reference) == len(problem.speeds) == 1000
    for k in (3, 500, 900):
        first = sf.simulate(problem.scene.where({"v_b": problem.speeds[k]}).until(150.0), 1e-13).checked()
        second = (
            problem.scene.where({"v_b": problem.speeds[k]})
            .until(50.0)
            .starting(dict(zip("xu", first.final, strict=True)))
        )
        half = sf.simulate(second.wanting({"half": sf.HalfRange(second.system.q[0])}), 1e-13).outputs["half"]
        assert half == pytest.approx(float(problem.reference[k]), abs=1e-12)
