"""The command ``symfric sweep``: its files, its refusals, and what Ctrl-C leaves."""

import csv
import json
import signal
import subprocess
import sys
import time

import pytest
import xarray as xr
from click.testing import CliRunner

import symfric as sf
from symfric.cli import main
from symfric.scenefile import read_scene_text

BELT = """
[scene]
model = "mass_on_belt"
horizon = {horizon}
[values]
v_b = 0.2
[outputs]
x_max = "max(x)"
end = "end"
"""
GRID = "[sweep.grid]\nv_b = {start = 0.1, stop = 0.4, count = 4}\nbeta = [0.0, 0.05]\n"
PROGRAM = "from symfric.cli import main; main(prog_name='symfric')"


def call(*arguments):
    return CliRunner().invoke(main, ["sweep", *map(str, arguments)])


def write(folder, text, horizon=20):
    path = folder / "belt.toml"
    path.write_text(text.replace("{horizon}", str(horizon)))
    return path


def test_a_grid_becomes_a_table_and_a_netcdf_file(tmp_path):
    path = write(tmp_path, BELT + GRID)
    done = call(path, "-o", tmp_path / "out", "--jobs", 2)
    assert done.exit_code == 0, done.output
    assert done.stdout.startswith("8 cases: 8 OK\n  x_max: ")
    rows = list(csv.DictReader((tmp_path / "out" / "sweep.csv").read_text().splitlines()))
    assert list(rows[0]) == ["v_b", "beta", "x_max", "end_x", "end_u", "status"]
    assert [(r["v_b"], r["beta"]) for r in rows[:3]] == [("0.1", "0.0"), ("0.1", "0.05"), ("0.2", "0.0")]
    scene = read_scene_text(path.read_text()).scene
    found = sf.sweep(scene, {"v_b": [0.1, 0.2, 0.30000000000000004, 0.4], "beta": [0.0, 0.05]})
    assert [float(r["x_max"]) for r in rows] == found.x_max.values.ravel().tolist()
    with xr.open_dataset(tmp_path / "out" / "store" / "result.nc", engine="scipy") as kept:
        xr.testing.assert_equal(kept, found)
    printed = json.loads(call(path, "-o", tmp_path / "out", "--json", "--resume").stdout)
    assert printed["statuses"] == {"OK": 8}
    assert printed["cases"][2]["x_max"] == float(rows[2]["x_max"])
    again = call(path, "-o", tmp_path / "out", "--quiet")
    assert (again.exit_code, again.output) == (0, "")


def test_the_range_of_a_study_is_a_grid(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = call(write(tmp_path, BELT + "[sweep]\nfrom = 0.1\nto = 0.3\nnumber = 3\n"), "-q")
    assert done.exit_code == 0
    assert len((tmp_path / "belt-sweep" / "sweep.csv").read_text().splitlines()) == 4


def test_a_grid_alone_leaves_the_study_without_a_range():
    found = read_scene_text(BELT.replace("{horizon}", "9") + GRID)
    assert found.sweep is None
    assert found.grid["beta"] == (0.0, 0.05)
    assert found.grid["v_b"] == pytest.approx((0.1, 0.2, 0.3, 0.4), abs=1e-15)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (BELT, "there is no [sweep] section; add [sweep.grid]"),
        (BELT + "[sweep]\nnumber = 3\n", "sweep.from is missing; add it"),
        (BELT + "[sweep]\ncoordinate = 'x'\n[sweep.grid]\nv_b = [1]\n", "sweep.from is missing; add it"),
        (BELT + "[sweep.grid]\nv_c = [1]\n", "sweep.grid: no value 'v_c'; did you mean v_b?"),
        (BELT + "[sweep.grid]\nv_b = []\n", "sweep.grid.v_b has 0 values"),
        (BELT + "[sweep.grid]\nv_b = 3\n", "sweep.grid.v_b is not an axis; write a list"),
        (BELT + "[sweep.grid]\nv_b = ['a']\n", "sweep.grid.v_b is the string 'a', not a number"),
        (BELT + "[sweep.grid]\nv_b = [nan]\n", "sweep.grid.v_b is nan; it must be finite"),
        (BELT + "[sweep.grid]\nv_b = {start = 0, stop = 1}\n", "sweep.grid.v_b is not an axis"),
        (BELT + "[sweep.grid]\nv_b = {start = 0, stop = 1, count = 1e9}\n", "sweep.grid.v_b has the count"),
        (BELT + "[sweep.grid]\nv_b = {start = 0, stop = 1, count = 0}\n", "sweep.grid.v_b has the count 0"),
        (
            BELT + "[sweep.grid]\nv_b = {start=0, stop=1, count=99999}\na = {start=0, stop=1, count=99999}\n",
            "at most 1000000",
        ),
        (BELT.replace('x_max = "max(x)"\nend = "end"\n', 'events = "events"\n') + GRID, "[outputs] has no number"),
        ("", "is empty"),
    ],
)
def test_bad_files_end_in_one_line(text, message, tmp_path):
    done = call(write(tmp_path, text), "-o", tmp_path / "out")
    assert done.exit_code == 2, done.output
    line = done.stderr.strip().splitlines()[-1]
    assert line.startswith("Error: ")
    assert message in line
    assert "Traceback" not in done.output


def test_bad_options_end_in_one_line(tmp_path):
    path = write(tmp_path, BELT + GRID)
    assert "jobs is 0" in call(path, "-o", tmp_path / "out", "--jobs", 0).stderr
    assert "is a file" in call(path, "-o", path).stderr
    assert call(path, "--jobs", "many").exit_code == 2


def test_a_sweep_without_any_answer_has_status_1(tmp_path):
    text = (
        '[scene]\ncoordinates = "x"\nvelocities = "u"\nmass = 1\nforce = "-x"\nhorizon = 9\n'
        'initial = {x = "sqrt(x0)", u = 0}\n[values]\nx0 = 1\n[outputs]\nlow = "min(x)"\n[sweep.grid]\nx0 = [-1, -2]\n'
    )
    done = call(write(tmp_path, text), "-o", tmp_path / "out")
    assert done.exit_code == 1
    assert "2 REFUSED" in done.stdout
    assert done.stderr.strip().splitlines()[-1].startswith("Error: no case ran to its end")


def test_ctrl_c_leaves_what_is_finished(tmp_path):
    path = write(tmp_path, BELT + "[sweep]\nfrom = 0.1\nto = 0.4\nnumber = 1500\n", horizon=400)
    out, store = tmp_path / "out", tmp_path / "out" / "store"
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, "sweep", str(path), "-o", str(out), "-q", "--jobs", "2"],
        stderr=subprocess.PIPE,
        text=True,
    )
    while process.poll() is None and not (store.exists() and sum(f.stat().st_size for f in store.glob("*.bin")) > 999):
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=120)
    assert process.returncode == 130
    assert said.startswith("interrupted; ")
    assert said.endswith(f"go on with: symfric sweep {path} -o {out} --resume\n")
    kept = int(said.split()[1])
    assert 0 < kept < 1500
    refused = call(path, "-o", out)
    assert refused.exit_code == 2
    assert f"holds an unfinished sweep with {kept} finished cases; continue it with --resume" in refused.stderr
    path.write_text(path.read_text().replace("0.4", "0.3"))
    assert "holds another sweep" in call(path, "-o", out, "--resume").stderr
    path.write_text(path.read_text().replace("0.3", "0.4").replace("horizon = 400", "horizon = 400.0"))
    resumed = call(path, "-o", out, "--resume")
    assert resumed.exit_code == 0, resumed.output
    assert resumed.stdout.startswith("1500 cases: 1500 OK")
