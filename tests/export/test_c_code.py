"""The C code computes the bits of the Python evaluation, and the FMU the numbers of the event-driven solution."""

import ctypes
import json
import re
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from click.testing import CliRunner

import symfric as sf
from symfric.cli import main
from symfric.export.fmu import build, compiler
from tests.export.scenes_for_steps import SCENES, WAVE, k, one, pair, u, v_b, x

compiled = pytest.mark.skipif(compiler() is None, reason="no C compiler on this computer")
KINDS = ("kink", "sliders", "pad between masses", "record", "late samples", "two at one zero", "belts that step")
H = 0.02
Floats = ctypes.POINTER(ctypes.c_double)


@pytest.fixture(scope="module")
def library(tmp_path_factory, request):
    """The scenes that this run asks for as one library: their names do not clash."""
    own = "test_c_code_computes_the_same_bits"
    cases = [item for item in request.session.items if getattr(item, "originalname", None) == own]
    asked = sorted({2, *(item.callspec.params["n"] for item in cases)})
    folder = tmp_path_factory.mktemp("c")
    for n in asked:
        sf.export.write_c(SCENES[KINDS[n]], folder / f"scene{n}.c", H)
    return ctypes.CDLL(str(build(folder, "scenes", [f"scene{n}.c" for n in asked])))


def pointer(array):
    return array.ctypes.data_as(Floats)


@pytest.mark.one_in(8)
@compiled
@pytest.mark.parametrize("n", range(len(KINDS)))
def test_c_code_computes_the_same_bits(library, n):
    s = sf.export.stepper(SCENES[KINDS[n]], H)
    expected = s.run()
    n_x, memory = len(s.states), s.advance.nnz_in(1)
    state, p = np.zeros(3 + n_x + memory), s.values
    function = lambda what: getattr(library, f"scene{n}_{what}")  # noqa: E731
    function("reset")(pointer(state), pointer(p), pointer(np.array([0.0])))
    rows, modes = np.zeros(max(1, len(s.outputs))), np.zeros(max(1, len(s.contacts)))
    for j in range(expected.t.size):
        t = expected.t.values[j]
        assert state[0] == t
        v = np.array([WAVE(t)])
        dv = (WAVE(t + H) - v) / H
        function("look")(pointer(state), pointer(p), pointer(v), pointer(rows), pointer(modes))
        assert state[1 : 1 + n_x].tobytes() == expected.x.values[:, j].tobytes()
        assert np.array_equal(modes[: len(s.contacts)], expected["mode"].values[:, j])
        assert [r for r, _ in zip(rows, s.outputs, strict=False)] == [float(expected[o][j]) for o in s.outputs]
        assert function("step")(pointer(state), pointer(p), pointer(v), pointer(dv)) == 0
    assert expected.t.size > 500
    assert len(np.unique(expected["mode"])) > 1 or KINDS[n] == "kink"


FORCED = sf.Scene(
    sf.System([x], [u], [[1]], [-2 * x + 0.7 * sp.sin(2 * sf.TIME)]),
    [sf.Contact("belt", u - 0.2, 1, sf.laws.coulomb(0.4, 0.3))],
    {},
    {x: 0.3, u: 0.1},
    20.0,
)
STEPS = 3000


@pytest.fixture(scope="module")
def forced(tmp_path_factory):
    """A forced scene in steps that have no finite binary fraction, as a library."""
    folder = tmp_path_factory.mktemp("forced")
    sf.export.write_c(FORCED, folder / "forced.c", 1e-3)
    return ctypes.CDLL(str(build(folder, "forced", ["forced.c"])))


def marched(library, state, steps):
    """Take steps without inputs; return the state after the last."""
    for _ in range(steps):
        assert library.forced_step(pointer(state), None, None, None) == 0
    return state


@pytest.mark.long(beside="test_inputs_of_the_unit_are_followed")
@compiled
def test_bits_and_clock_are_those_of_python_after_many_steps(forced):
    s = sf.export.stepper(FORCED, 1e-3)
    run = s.run(until=1e-3 * STEPS)
    state = np.zeros(3 + 2 + s.advance.nnz_in(1))
    forced.forced_reset(pointer(state), None, None)
    marched(forced, state, STEPS)
    assert run.t.size == STEPS + 1
    assert state[0] == run.t.values[-1] == 1e-3 * STEPS
    assert np.cumsum(np.full(STEPS, 1e-3))[-1] != 1e-3 * STEPS  # the clock of a sum of steps
    assert state[1:3].tobytes() == run.x.values[:, -1].tobytes()


@compiled
def test_a_time_that_is_set_goes_on_from_there(forced):
    states = []
    for begun in (True, False):
        state = np.zeros(3 + 2 + sf.export.stepper(FORCED, 1e-3).advance.nnz_in(1))
        forced.forced_reset(pointer(state), None, None)
        marched(forced, state, 7)
        state[0], state[1:3] = 1.2345, (0.25, -0.1)
        if begun:
            forced.forced_begin(pointer(state), None, None)
        states.append(marched(forced, state, 1000))
        assert state[0] == 1.2345 + 1000 * 1e-3
    assert states[0][:3].tobytes() == states[1][:3].tobytes()


@compiled
def test_a_step_of_another_length_between_does_not_stop_the_clock(forced):
    state = np.zeros(3 + 2 + sf.export.stepper(FORCED, 1e-3).advance.nnz_in(1))
    forced.forced_reset(pointer(state), None, None)
    marched(forced, state, 10)
    forced.forced_advance(pointer(state), None, None, None, ctypes.c_double(0.3e-3))
    origin = 10 * 1e-3 + 0.3e-3
    assert state[0] == origin
    marched(forced, state, 1000)
    assert state[0] == origin + 1000 * 1e-3


@compiled
def test_the_documented_program_runs(tmp_path):
    text = (Path(__file__).parents[2] / "docs" / "howto" / "realtime.md").read_text(encoding="utf-8")
    (tmp_path / "main.c").write_text(re.search(r"```c\n(.*?)```", text, re.DOTALL)[1])
    scene = sf.scenes.mass_on_belt(v_b=0.2)
    sf.export.write_c(scene, tmp_path / "belt.c", 0.01)
    options = re.search(r"```sh\ncc (.*)\n```", text)[1].split()
    subprocess.run([compiler(), *options], cwd=tmp_path, check=True)
    said = subprocess.run([tmp_path / "a.out"], capture_output=True, text=True, check=True).stdout
    exact = sf.simulate(scene.where({"v_b": 0.25}).until(30.0), 1e-11).final[0]
    assert float(re.fullmatch(r"x = (\S+), friction = \S+\n", said)[1]) == pytest.approx(exact, abs=1e-7)


@compiled
def test_values_and_start_stand_in_the_library(library):
    values = (ctypes.c_double * 2).in_dll(library, "scene2_parameters")
    assert list(values) == list(SCENES["pad between masses"].values.values())
    assert list((ctypes.c_double * 4).in_dll(library, "scene2_initial")) == [0.5, 0.0, 0.0, 0.05]


def test_the_header_names_everything(tmp_path):
    found = sf.export.write_c(SCENES["pad between masses"], tmp_path / "pads.c", 1e-3)
    header = (tmp_path / "pads.h").read_text()
    assert "enum { PADS_X_x, PADS_X_x2, PADS_X_u, PADS_X_u2, PADS_STATES };" in header
    assert "enum { PADS_C_pad, PADS_C_belt, PADS_CONTACTS };" in header
    assert "#define PADS_STEP 0.001" in header
    assert found.to_dict()["files"] == [str(tmp_path / "pads.c"), str(tmp_path / "pads.h")]
    assert "SCENE_" not in header + (tmp_path / "pads.c").read_text()


@pytest.fixture(scope="module")
def unit(tmp_path_factory):
    """The pad between two masses as a unit."""
    pytest.importorskip("fmpy", reason="FMPy is not installed")
    place = tmp_path_factory.mktemp("fmu") / "pads.fmu"
    assert sf.export.write_fmu(SCENES["pad between masses"], place, H).compiled
    return str(place)


@pytest.mark.long(beside="test_the_documented_program_runs")
@compiled
def test_the_unit_runs_to_the_numbers_of_the_event_driven_solution(unit):
    import fmpy
    from fmpy.validation import validate_fmu

    scene = SCENES["pad between masses"]
    assert validate_fmu(unit) == []
    found = fmpy.simulate_fmu(unit, stop_time=scene.horizon, output_interval=0.1)
    run, stepper = sf.simulate(scene, 1e-11), sf.export.stepper(scene, H)
    exact, error = run(found["time"]), stepper.error()
    assert error < 1e-5
    for j, state in enumerate(run.names):
        assert np.max(np.abs(found[state] - exact[j])) <= 1.01 * error * np.max(np.abs(exact[j]))
    shown = stepper.run().sel(t=found["time"], method="nearest")
    assert np.array_equal(found["pad.mode"], shown["mode"].sel(contact="pad"))
    assert np.all(found["status"] == 0)
    changed = {"v_b": 0.3, "u": 0.1}
    other = fmpy.simulate_fmu(unit, stop_time=3.0, output_interval=0.1, start_values=changed)
    moved = scene.where({"v_b": 0.3}).starting({"u": 0.1}).until(3.0).wanting({"end": sf.End()})
    assert other["x"][-1] == pytest.approx(sf.simulate(moved, 1e-11).final[0], abs=1e-5)


@compiled
def test_the_state_of_a_unit_is_kept_and_given_back(unit, tmp_path):
    import fmpy
    from fmpy.fmi2 import FMU2Slave

    about = fmpy.read_model_description(unit)
    slave = FMU2Slave(
        guid=about.guid,
        unzipDirectory=fmpy.extract(unit, str(tmp_path / "unpacked")),
        modelIdentifier=about.coSimulation.modelIdentifier,
        instanceName="one",
    )
    slave.instantiate()
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.exitInitializationMode()

    def ahead(start):
        for j in range(20):
            slave.doStep(start + 0.1 * j, 0.1)
        return slave.getReal([0, 1, 2, 3])

    ahead(0.0)
    kept = slave.getFMUstate()
    packed = slave.serializeFMUstate(kept)
    first = ahead(2.0)
    slave.setFMUstate(kept)
    assert ahead(2.0) == first
    slave.setFMUstate(slave.deSerializeFMUstate(packed))
    assert ahead(2.0) == first
    slave.freeFMUstate(kept)
    slave.terminate()
    slave.freeInstance()


@compiled
def test_inputs_of_the_unit_are_followed(tmp_path):
    fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed")
    sf.export.write_fmu(SCENES["record"], tmp_path / "shaken.fmu", H)
    t = np.arange(0, 12.0001, 0.8)
    record = np.array(list(zip(t, WAVE(t), strict=True)), dtype=[("time", float), ("a_g", float)])
    exact = sf.simulate(SCENES["record"], 1e-11)
    errors = []
    for interval in (0.08, 0.04):
        found = fmpy.simulate_fmu(str(tmp_path / "shaken.fmu"), stop_time=10.4, output_interval=interval, input=record)
        errors.append(np.max(np.abs(found["x"] - exact(found["time"])[0])))
    assert errors[1] < 0.05 * np.max(np.abs(exact.x[0]))
    assert errors[1] < 0.7 * errors[0]  # an input that is held is of first order


def test_without_a_compiler_the_unit_holds_its_sources(tmp_path, monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    found = sf.export.write_fmu(SCENES["belt"], tmp_path / "belt.fmu", H)
    assert not found.compiled
    inside = zipfile.ZipFile(found.files[0]).namelist()
    assert inside == ["modelDescription.xml", "sources/belt.c", "sources/belt.h", "sources/belt_fmi2.c"]
    first = found.files[0].read_bytes()
    sf.export.write_fmu(SCENES["belt"], tmp_path / "belt.fmu", H)
    assert found.files[0].read_bytes() == first  # the same scene gives the same file


@pytest.mark.parametrize("name", ["a-b", "1st", "while", ""])
def test_names_that_c_does_not_allow_are_refused(tmp_path, name):
    with pytest.raises(sf.SceneError, match=r"no name in C|no name for C code"):
        sf.export.write_c(SCENES["belt"], tmp_path / f"{name}.c", H)


def test_names_of_the_scene_may_be_any(tmp_path):
    odd = pair(sf.Contact("pad 1/ä", slip=u - v_b, normal=1, law=sf.laws.coulomb(0.3))).where({k: 2.0})
    text = sf.export.write_c(odd, tmp_path / "odd.c", H).files[1].read_text()
    assert "ODD_C_pad_1__," in text
    assert sf.export.write_c(one(-x), tmp_path / "bare.c", H).outputs == ()


def test_command(tmp_path):
    call = lambda *a: CliRunner().invoke(main, ["export", *map(str, a)])  # noqa: E731
    out = tmp_path / "belt.c"
    done = call("examples/belt.toml", "--to", "c", "--step", 0.05, "-o", out, "--json")
    told = json.loads(done.stdout)
    assert done.exit_code == 0
    assert told["files"] == [str(out), str(out.with_suffix(".h"))]
    assert told["error"] < 1e-4
    assert (
        "difference from the event-driven" in call("examples/belt.toml", "--to", "c", "--step", 0.05, "-o", out).stdout
    )
    assert "shorter --step" in call("examples/belt.toml", "--to", "c", "--step", 1.0, "-o", out).stdout
    for arguments, said in [
        (("--to", "c"), "Missing option '--step'"),
        (("--to", "c", "--step", -1), "step is -1; it must be positive"),
        (("--to", "fmu", "--step", 0.1, "-o", "belt.zip"), "ends in .fmu"),
        (("--to", "c", "--step", 0.1, "-o", tmp_path / "none" / "belt.c"), "cannot write"),
    ]:
        done = call("examples/belt.toml", *arguments)
        assert done.exit_code == 2
        assert said in done.stderr
        assert len(done.stderr.splitlines()) == 1 or "cannot write" in said
