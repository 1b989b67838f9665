"""Commands: exit status, one clear line on bad input, and pages that stand alone."""

import contextlib
import json
import os
import re
import shutil
import signal
import stat
import subprocess
import sys
import time
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace

import pytest
from click.testing import CliRunner

from symfric.cli import COMMANDS, main
from symfric.cli.console import progress_on_stderr
from symfric.theory import drive
from tests.longer import longer

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.toml"))
VOID = {"meta", "img", "br", "hr", "link", "input", "mspace"}
PROGRAM = "from symfric.cli import main; main(prog_name='symfric')"


def call(*arguments):
    return CliRunner().invoke(main, [str(a) for a in arguments])


def spawn(*arguments, cwd=None):
    return subprocess.run(
        [sys.executable, "-c", PROGRAM, *map(str, arguments)], capture_output=True, text=True, cwd=cwd, timeout=180
    )


class Page(HTMLParser):
    """Collects tags and attributes; fails on tags that do not close."""

    def __init__(self, text: str):
        super().__init__()
        self.open, self.tags, self.attributes, self.words = [], [], [], []
        self.feed(text)
        self.close()
        assert not self.open, f"not closed: {self.open}"

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += [(tag, *a) for a in attrs]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, f"</{tag}> closes another tag"

    def handle_data(self, data):
        self.words.append(data)

    def values(self, tag, name):
        return [v for t, n, v in self.attributes if (t, n) == (tag, name)]


LONG = (
    "brake_pad.toml",
    "disc_brake.toml",
    "machine_slide.toml",
    "rig_record.toml",
    "shaken_table.toml",
    "two_masses.toml",
    "violin_string.toml",
)


@pytest.fixture(scope="module", params=longer(EXAMPLES, [p for p in EXAMPLES if p.name in LONG]), ids=lambda p: p.stem)
def studied(request, tmp_path_factory):
    """One study of each example, with fewer points in its sweep: its file, folder and printed JSON."""
    place = tmp_path_factory.mktemp("study")
    path, folder = place / request.param.name, place / "new" / request.param.stem
    path.write_text(re.sub(r"(?m)^number = \d+", "number = 7", request.param.read_text()))
    for beside in request.param.parent.glob(f"{request.param.stem}*"):
        if beside.suffix in (".npz", ".csv"):
            shutil.copy(beside, place)
    result = call("study", path, "-o", folder, "--json")
    assert result.exit_code == 0, result.output
    return path, folder, result.stdout


@pytest.mark.one_in(3)
def test_page_stands_alone(studied):
    _, folder, _ = studied
    text = (folder / "study.html").read_text(encoding="utf-8")
    page = Page(text)
    images = page.values("img", "src")
    assert len(images) >= 3
    assert all(i.startswith("data:image/") for i in images)
    assert all(len(a) > 10 for a in page.values("img", "alt"))
    assert len(page.values("img", "alt")) == len(images)
    assert "script" not in page.tags
    assert "link" not in page.tags
    assert set(page.values("a", "href")) <= {"study.json", "motion.csv", "amplitude.csv", "flutter.csv", "shapes.csv"}
    assert all((folder / name).exists() for name in page.values("a", "href"))
    without_pictures = re.sub(r'"data:image/[^"]*"', '""', text)
    assert not re.search(r"https?://|url\(|@import", without_pictures)
    assert "math" in page.tags
    assert page.values("meta", "name") == ["viewport"]


def test_page_says_what_was_asked(studied):
    path, folder, _ = studied
    words = " ".join(Page((folder / "study.html").read_text(encoding="utf-8")).words)
    for heading in ("In short", "The scene", "stability", "The motion", "Friction", "How it was computed"):
        assert heading in words
    assert "nan" not in re.split(r"\W+", words.lower())
    assert "None" not in words
    assert path.name in words


def test_json_holds_the_numbers(studied):
    path, folder, printed = studied
    data = json.loads(printed)
    assert data == json.loads((folder / "study.json").read_text())
    assert (data["stability"] is None) == (path.stem == "shaken_table")  # it does not slide steadily, and has no sweep
    assert (data["sweep"] is None) == (path.stem == "shaken_table")
    if data["stability"] is not None:
        assert data["stability"]["stable"] is (path.stem == "two_slides")  # whose cycle lies beside stable sliding
    assert data["motion"]["status"] == "OK"
    assert data["steady"]["half_range"] > 0
    if data["sweep"] is not None:
        assert len(data["sweep"]["values"]) == len(data["sweep"]["half_range"])
    assert data["seconds"] > 0


def test_csv_has_a_line_for_each_value(studied):
    _, folder, printed = studied
    sweep = json.loads(printed)["sweep"]
    if sweep is None:
        assert not (folder / "amplitude.csv").exists()
        return
    lines = (folder / "amplitude.csv").read_text().splitlines()
    assert len(lines) == 1 + len(sweep["values"])
    assert float(lines[1].split(",")[0]) == sweep["values"][0]


def test_belt_agrees_with_what_is_known(studied):
    path, _, printed = studied
    if path.stem != "belt":
        pytest.skip("speaks of the belt")
    data = json.loads(printed)
    assert data["hopf"]["value"] == pytest.approx(0.44095855184409843, abs=1e-12)
    assert data["steady"]["half_range"] == pytest.approx(0.286208719045775, rel=1e-8)
    assert data["steady"]["period"] == pytest.approx(6.7994214444721576, rel=1e-8)
    assert data["steady"]["stick_fraction"] == pytest.approx(1.62955844494 / 6.79942144447, rel=0.05)
    onset = [r for r in data["comparison"] if r["quantity"] == "belt speed below which it sticks"]
    assert all(r["computed"] == pytest.approx(0.39579028879783, rel=1e-6) for r in onset)
    assert abs(data["quench"]["objective"] / 0.36 - 1) < 0.05


def test_two_slides_agree_with_the_closed_form_of_their_cycle(studied):
    path, _, printed = studied
    if path.stem != "two_slides":
        pytest.skip("speaks of two slides")
    data = json.loads(printed)
    cycle = drive.two_slides_cycle(r=0.5, zeta=2, s1=0.2, s2=0.3, fc1=1, fs1=7.8)
    assert 2 * data["steady"]["half_range"] == pytest.approx(cycle.ranges[0], rel=1e-7)
    assert data["steady"]["period"] == pytest.approx(cycle.period, rel=1e-7)
    assert data["steady"]["stick_fraction"] == pytest.approx(cycle.stick_fraction, rel=0.01)
    sweep = data["sweep"]
    vibrating = [value for value, half in zip(sweep["values"], sweep["half_range"], strict=True) if half > 1e-6]
    assert vibrating == [v for v in sweep["values"] if v > drive.two_slides_threshold(r=0.5, zeta=2, s1=0.2, s2=0.3)]


def test_commands_without_work():
    assert call().exit_code == 0
    assert "study" in call().output
    assert call("--version").output.startswith("symfric")
    for command in COMMANDS:
        helped = call(command, "--help")
        assert helped.exit_code == 0
        assert f"Example: symfric {command}" in helped.output
    assert "Example: symfric" in call("--help").output


def test_scenes_are_listed():
    assert "mass_on_belt" in call("scenes").output
    listed = json.loads(call("scenes", "--json").output)
    assert {"scenes", "laws"} == set(listed)
    assert "coulomb_oscillator" in call("scenes", "--quiet").output.split()


def test_explain_says_the_route():
    result = call("explain", EXAMPLES[0])
    assert result.exit_code == 0
    assert "taylor" in result.output
    assert json.loads(call("explain", EXAMPLES[0], "--json").output)["file"] == str(EXAMPLES[0])


def bad_line(result) -> str:
    """The last line on stderr of a refused command."""
    assert result.exit_code == 2, result.output
    assert "Traceback" not in result.output
    assert not isinstance(result.exception, Exception) or isinstance(result.exception, SystemExit)
    lines = [line for line in result.stderr.splitlines() if line]
    assert lines[-1].startswith("Error: ")
    return lines[-1]


@pytest.mark.parametrize("command", ["study", "explain"])
def test_bad_files_end_with_status_2(command, tmp_path):
    (tmp_path / "hostile.toml").write_text(
        '[scene]\ncoordinates = "x"\nvelocities = "u"\nmass = 1\nhorizon = 1\ninitial = {x = 0, u = 0}\n'
        f"force = \"__import__('os').system('touch {tmp_path}/canary')\"\n"
    )
    (tmp_path / "binary.toml").write_bytes(bytes(range(256)))
    (tmp_path / "model.toml").write_text('[scene]\nmodel = "mass_on_bell"\n[values]\nv_b = 0.1\n')
    assert "scene.force[0]" in bad_line(call(command, tmp_path / "hostile.toml"))
    assert "not text" in bad_line(call(command, tmp_path / "binary.toml"))
    assert "did you mean mass_on_belt?" in bad_line(call(command, tmp_path / "model.toml"))
    assert "folder" in bad_line(call(command, tmp_path))
    assert "no such file" in bad_line(call(command, tmp_path / "none.toml"))
    assert "Missing argument" in bad_line(call(command))
    assert not (tmp_path / "canary").exists()
    assert len(os.listdir(tmp_path)) == 3


def test_misspelled_command_and_option():
    assert "did you mean study?" in bad_line(call("stdy"))
    assert "--jsno" in bad_line(call("scenes", "--jsno"))


def test_output_folder_that_cannot_be_written(tmp_path):
    occupied = tmp_path / "file"
    occupied.write_text("")
    assert "is a file" in bad_line(call("study", EXAMPLES[0], "-o", occupied))
    assert "cannot write" in bad_line(call("study", EXAMPLES[0], "-o", occupied / "below"))
    closed = tmp_path / "closed"
    closed.mkdir()
    closed.chmod(stat.S_IRUSR | stat.S_IXUSR)
    if not os.access(closed, os.W_OK):  # root may write anywhere
        assert "cannot write" in bad_line(call("study", EXAMPLES[0], "-o", closed))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["stdy"], "no command 'stdy'; did you mean study?; see symfric --help"),
        (["--vrsion"], "see symfric --help"),
        (["explain"], "Missing argument 'FILE'; see symfric explain --help"),
        (["scenes", "extra"], "unexpected extra argument (extra); see symfric scenes --help"),
        (["sweep", "{folder}"], "is a folder; name a scene file in it"),
        (["explain", "{unit}"], "values.v_b is the string '0.2 m/s', not a number; write the number without quotes"),
        (["reproduce", "thomsen-10"], "no figure 'thomsen-10'; did you mean thomsen-1?"),
        (["reproduce", "younes-2"], "younes-2 is not made: layout of the test rig"),
        (["reproduce", "thomsen-1", "-o", "{unit}"], "is a file; name a folder for the results with -o"),
        (["reproduce", "thomsen-1", "-o", "{unit}/below"], "name another folder with -o"),
        (["reproduce", "thomsen-1", "--records", "{unit}"], "is not a folder of records"),
        (["sweep", "{good}", "-o", "{unit}/below"], "name another folder with -o"),
        (["bench", "--problem", "Q1"], "no problem 'Q1'"),
        (["bench", "-o", "{unit}"], "is a file; name a folder for the results with -o"),
        (["bench", "--rounds", "few"], "'few' is not a valid integer"),
    ],
)
def test_what_is_typed_wrong_is_one_line(arguments, message, tmp_path):
    unit = tmp_path / "unit.toml"
    unit.write_text('[scene]\nmodel = "mass_on_belt"\n[values]\nv_b = "0.2 m/s"\n')
    places = {"folder": tmp_path, "unit": unit, "good": EXAMPLES[0]}
    result = call(*(a.format(**places) for a in arguments))
    assert message in bad_line(result)
    assert len(result.stderr.splitlines()) == 1
    assert result.stdout == ""
    assert list(tmp_path.iterdir()) == [unit]


def test_an_interrupted_reproduction_keeps_what_is_finished(monkeypatch, tmp_path):
    from symfric_evidence.sources import reproduction

    def stop(_inputs):
        raise KeyboardInterrupt

    known = reproduction.reproductions()
    stopping = type(known["thomsen-1"])("Stops.", stop)
    monkeypatch.setattr(reproduction, "reproductions", lambda: {"thomsen-1": known["thomsen-1"], "guida-1": stopping})
    result = call("reproduce", "-q", "-o", tmp_path)
    assert result.exit_code == 130
    assert result.stderr == f"interrupted; 1 of 2 are finished, see {tmp_path / 'index.html'}\n"
    assert "thomsen-1.png" in (tmp_path / "index.html").read_text()


def test_failures_of_the_question_end_with_status_1(monkeypatch):
    import symfric.cli.commands as commands
    from symfric import NoRoute

    def refuse(_path):
        raise NoRoute("no solver takes the scene")

    monkeypatch.setattr("symfric.scenefile.read_scene_file", refuse)
    result = CliRunner().invoke(main, ["explain", "any.toml"])
    assert commands.explain.name == "explain"
    assert result.exit_code == 1
    assert result.stderr == "Error: no solver takes the scene\n"


def test_exit_status_of_the_process(tmp_path):
    """Of a refused command; `test_quiet_is_silent` sees that of one that does its work."""
    (tmp_path / "empty.toml").touch()
    refused = spawn("study", "empty.toml", cwd=tmp_path)
    assert refused.returncode == 2
    assert refused.stderr == "Error: empty.toml: is empty; a scene file has at least a section [scene]\n"
    assert refused.stdout == ""


def test_an_interrupt_that_was_swallowed_comes_back():
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with progress_on_stderr(quiet=True) as progress:
            progress("work", 0.1)
            with contextlib.suppress(KeyboardInterrupt):
                signal.raise_signal(signal.SIGINT)
            with pytest.raises(KeyboardInterrupt):
                progress("work", 0.2)
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.long(beside="test_an_interrupted_reproduction_keeps_what_is_finished")
def test_interrupt_ends_with_130(tmp_path):
    text = '[scene]\nmodel = "mass_on_belt"\n[values]\nv_b = 0.2\n[sweep]\nfrom = 0.1\nto = 0.4\nnumber = 10000\n'
    (tmp_path / "long.toml").write_text(text + "settle = 1e5\n")
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, "study", "long.toml"],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        while "%" not in (line := process.stderr.readline()) and line:  # the first line of progress: the work has begun
            pass
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        _, rest = process.communicate(timeout=180)
    finally:
        process.kill()
    assert "%" in line
    assert process.returncode == 130
    assert rest.strip().splitlines()[-1] == "interrupted"
    assert "Traceback" not in rest


def test_compiling_the_event_loop_is_announced(capsys, caplog, monkeypatch, tmp_path):
    import logging

    from symfric.cli.console import progress_on_stderr
    from symfric.codegen import loop_loader

    kept = []
    monkeypatch.setattr(loop_loader, "store", lambda name, code: kept.append(code))
    monkeypatch.setattr(loop_loader, "load", lambda name: None)
    monkeypatch.setattr(loop_loader, "link", lambda code: SimpleNamespace(get_function_address=lambda name: 1))
    monkeypatch.setattr(loop_loader, "_compiled", lambda module: b"name\ncode")
    monkeypatch.setattr(loop_loader, "sources", lambda module, followed=(): [])

    def open_anew():
        monkeypatch.setattr(loop_loader, "_opened", {})
        loop_loader.load_loop("a.loop", "the event loop")

    line = "compiling the event loop, once for this machine"
    with progress_on_stderr(quiet=False):
        open_anew()
        loop_loader.load_loop("a.loop", "the event loop")
        assert capsys.readouterr().err == line + "\n"
    with progress_on_stderr(quiet=True):
        open_anew()
    assert capsys.readouterr().err == ""
    with caplog.at_level(logging.INFO, "symfric"):
        open_anew()
    assert [(r.name, r.getMessage()) for r in caplog.records][-1:] == [("symfric", line)]
    assert kept == 3 * [b"name\ncode"]


def test_quiet_is_silent(tmp_path):
    simple = tmp_path / "simple.toml"
    simple.write_text('[scene]\nmodel = "coulomb_oscillator"\n[values]\ndelta = 0.03\n')
    result = spawn("study", simple, "--quiet", cwd=tmp_path)
    assert (result.returncode, result.stdout, result.stderr) == (0, "", "")
    assert (tmp_path / "simple-study" / "study.html").exists()


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    "text",
    [
        '[scene]\nmodel = "coulomb_oscillator"\n[values]\ndelta = 0.03\n',
        pytest.param(
            '[scene]\nmodel = "mass_on_belt"\nhorizon = 30\n[values]\nv_b = 0.2\na = 0.01\nOmega = 50\n',
            marks=pytest.mark.long,
        ),
        '[scene]\ncoordinates = "x"\nvelocities = "u"\nmass = 1\nforce = "-x"\nhorizon = 9\ninitial = {x = 1, u = 0}\n',
        '[scene]\nmodel = "mass_on_belt"\nhorizon = 30\n[values]\nv_b = 0.2\n[sweep]\nparameter = "gamma2"\n'
        "from = 0.5\nto = 1\nnumber = 3\n",
    ],
    ids=["free oscillator", "shaken", "frictionless", "sweep of another value"],
)
def test_what_does_not_apply_is_said_in_a_sentence(text, tmp_path):
    (tmp_path / "any.toml").write_text(text)
    result = call("study", tmp_path / "any.toml", "-o", tmp_path)
    assert result.exit_code == 0, result.output
    Page((tmp_path / "study.html").read_text(encoding="utf-8"))
    data = json.loads((tmp_path / "study.json").read_text())
    assert data["motion"]["status"] == "OK"
    assert "design" in data["skipped"]
