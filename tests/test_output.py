"""What is printed and written when the terminal lacks letters, the disk is full or nobody reads."""

import errno
import io
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from symfric.cli import COMMANDS, main
from symfric.cli.streams import plain
from symfric.files import write_together, write_whole
from tests.longer import longer

resource = pytest.importorskip("resource", reason="limits of a process are set through resource; this system has none")
PROGRAM = "from symfric.cli import main; main(prog_name='symfric')"
SCENE = """
title = "Größe − 10⁻¹² µm → ω ≤ 中"
[scene]
model = "mass_on_belt"
horizon = 20
[values]
v_b = 0.2
[outputs]
x_max = "max(x)"
[sweep]
from = 0.1
to = 0.2
number = 2
settle = 20
window = 20
[identify]
record = "record.csv"
starts = 1
[identify.unknowns]
beta = [0.01, 0.2]
"""
SIMPLE = '[scene]\nmodel = "coulomb_oscillator"\n[values]\ndelta = 0.03\n'
RECORD = "t,x\n" + "".join(f"{k / 2},{0.3 * (-1) ** k}\n" for k in range(1, 30))
CALLS = {  # every command that ends by itself, with arguments that make it print
    "study": ["study", "{file}", "-o", "{out}"],
    "explain": ["explain", "{file}"],
    "sweep": ["sweep", "{file}", "-o", "{out}", "-j", "1"],
    "identify": ["identify", "{file}", "-o", "{out}"],
    "export": ["export", "{file}", "--to", "c", "--step", "0.05", "-o", "{out}.c"],
    "scenes": ["scenes"],
    "new": ["new", "{out}.toml"],
    "reproduce": ["reproduce", "rolling-table-2", "-o", "{out}"],
    "bench": ["bench", "--problem", "P1", "--rounds", "1", "--quick", "-o", "{out}"],
    "stress": ["stress", "--scenes", "1", "-j", "1"],
}
LEFT = {
    "study": {"study.html", "study.json", "amplitude.csv"},
    "sweep": {"sweep.csv", "store"},
    "identify": {"identify.html", "identify.json"},
    "reproduce": {"index.html", "rolling-table-2.txt"},
    "bench": {"bench.json", "bench.png"},
}


@pytest.fixture
def scene(tmp_path):
    file = tmp_path / "scene.toml"
    file.write_text(SCENE, encoding="utf-8")
    (tmp_path / "record.csv").write_text(RECORD)
    return file


def run(command, scene, stream, monkeypatch, errors=None):
    """Run a command in this process with a stream as standard output; return the status and what stderr got."""
    said = io.TextIOWrapper(io.BytesIO(), encoding="utf-8") if errors is None else errors
    arguments = [a.format(file=scene, out=scene.parent / "out") for a in CALLS[command]]
    with monkeypatch.context() as patch:
        patch.setattr(sys, "stdout", stream)
        patch.setattr(sys, "stderr", said)
        with pytest.raises(SystemExit) as ended:
            main.main(arguments, prog_name="symfric")
    said.flush()
    return ended.value.code or 0, said.buffer.getvalue().decode() if errors is None else ""


def test_every_command_is_tried():
    assert set(CALLS) == set(COMMANDS) - {"explore"}


@pytest.mark.one_in(10)
@pytest.mark.parametrize("encoding", longer(["ascii", "latin-1", "cp1252", "utf-8"], ["latin-1", "cp1252", "utf-8"]))
@pytest.mark.parametrize("command", CALLS)
def test_every_encoding_can_show_what_a_command_prints(command, encoding, scene, monkeypatch):
    stream = io.TextIOWrapper(io.BytesIO(), encoding=encoding, errors="strict")
    errors = io.TextIOWrapper(io.BytesIO(), encoding=encoding, errors="strict")
    status, _ = run(command, scene, stream, monkeypatch, errors)
    assert status == 0
    text = stream.buffer.getvalue().decode(encoding)  # bytes of this encoding, not of another one
    assert len(text) > 20
    if command == "study":
        assert ("Größe − 10⁻¹² µm → ω ≤ 中" in text) is (encoding == "utf-8")
        assert ("Grosse - 10^-12 um -> omega <= ?" in text) is (encoding == "ascii")


def broken_pipe():
    """Return a stream whose reader is gone."""
    reading, writing = os.pipe()
    os.close(reading)
    return os.fdopen(writing, "w")


@pytest.mark.one_in(10)
@pytest.mark.parametrize("command", CALLS)
def test_a_reader_that_has_enough_ends_nothing(command, scene, monkeypatch):
    stream = broken_pipe()
    status, said = run(command, scene, stream, monkeypatch)
    assert (status, "Error" in said, "Traceback" in said) == (0, False, False)
    assert {p.name for p in (scene.parent / "out").glob("*")} >= LEFT.get(command, set())
    stream.close()  # nothing is left in it that would fail when Python ends


@pytest.mark.one_in(10)
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
@pytest.mark.parametrize("command", CALLS)
def test_output_that_is_lost_is_one_line_and_status_1(command, scene, monkeypatch):
    with open("/dev/full", "w") as stream:
        status, said = run(command, scene, stream, monkeypatch)
    assert status == 1
    assert said.splitlines()[-1] == "Error: cannot write to standard output (No space left on device)"
    assert said.count("Error") == 1
    assert {p.name for p in (scene.parent / "out").glob("*")} >= LEFT.get(command, set())


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
def test_nothing_printed_is_nothing_lost(scene, monkeypatch):
    scene.write_text(SIMPLE)
    monkeypatch.setitem(CALLS, "scenes", ["study", "{file}", "-q", "-o", "{out}"])
    with open("/dev/full", "w") as stream, open("/dev/full", "w") as errors:
        assert run("scenes", scene, stream, monkeypatch, errors) == (0, "")
    monkeypatch.setitem(CALLS, "scenes", ["explain", "missing.toml"])
    with open("/dev/full", "w") as stream, open("/dev/full", "w") as errors:
        assert run("scenes", scene, stream, monkeypatch, errors) == (2, "")


SHELL = [
    ("scenes >&-", 1, "Error: cannot write to standard output (it is closed)\n"),
    ("scenes --quiet >&- 2>&-", 1, ""),
    ("--help > /dev/full", 1, "Error: cannot write to standard output (No space left on device)\n"),
    ("--version > /dev/full", 1, "Error: cannot write to standard output (No space left on device)\n"),
    ("scenes | true", 0, ""),
    ("scenes | head -n 1 > /dev/null", 0, ""),
    ("stdy 2>&-", 2, ""),
    ("stdy", 2, "Error: no command 'stdy'; did you mean study?; see symfric --help\n"),
]


@pytest.mark.one_in(4)
@pytest.mark.skipif(not Path("/bin/bash").exists(), reason="closes streams as a shell does; there is no bash here")
@pytest.mark.parametrize(("line", "status", "said"), SHELL, ids=[line for line, _, _ in SHELL])
def test_the_status_of_the_process(line, status, said):
    words, pipe, reader = line.partition(" |")
    script = f'"$0" -c "$1" {words}{pipe}{reader}; exit ${{PIPESTATUS[0]}}'
    done = subprocess.run(["/bin/bash", "-c", script, sys.executable, PROGRAM], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (status, said)


def test_a_closed_stream_lends_its_number_to_no_file(scene):
    """Descriptor 1 closed: a table must not be mixed with what libraries print there."""
    code = f"import os; os.close(0); os.close(1); {PROGRAM}"
    done = subprocess.run(
        [sys.executable, "-c", code, "sweep", str(scene), "-o", str(scene.parent / "out"), "-q"],
        capture_output=True,
        text=True,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert (scene.parent / "out" / "sweep.csv").read_text().startswith("v_b,x_max,status\n")


def test_help_is_in_letters_that_every_encoding_has():
    for words in ([], ["--version"], *([name, "--help"] for name in COMMANDS)):
        stream = io.TextIOWrapper(io.BytesIO(), encoding="ascii", errors="strict")
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(sys, "stdout", stream)
            with pytest.raises(SystemExit) as ended:
                main.main(words, prog_name="symfric")
        assert not ended.value.code
        assert stream.buffer.getvalue().isascii()


def test_signs_become_words_that_ascii_has():
    assert plain("1.2·10⁻³ ≤ |µ| → ∞, Ω′ − é²") == "1.2*10^-3 <= |u| -> inf, omega' - e^2"
    assert plain("中\x80\ud800") == "???"
    assert "x²-⁻¹".encode("latin-1", "symfric.plain") == "x²-^-1".encode("latin-1")


def small_files(size: int):
    """Return a function for a child process that may write no file longer than so many bytes."""
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


@pytest.mark.long(beside="test_a_second_file_that_fails_leaves_the_first_as_it_was")
@pytest.mark.parametrize("command", longer(["study", "reproduce"], ["study"]))
def test_a_full_disk_leaves_the_files_of_before(command, scene):
    out = scene.parent / "out"
    out.mkdir()
    (out / "study.html").write_text("before")
    words = [a.format(file=scene, out=out) for a in CALLS[command]]
    words[words.index("rolling-table-2") if command == "reproduce" else 0] = {"reproduce": "guida-12"}.get(
        command, "study"
    )
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, *words, "-q"], capture_output=True, text=True, preexec_fn=small_files(8000)
    )
    assert done.returncode == 2
    assert done.stderr.startswith("Error: cannot write ")
    assert done.stderr.endswith("(File too large); make room, or name another folder with -o\n")
    assert len(done.stderr.splitlines()) == 1
    assert [p.name for p in out.iterdir()] == ["study.html"]
    assert (out / "study.html").read_text() == "before"


FAILURES = {"write": "fdopen", "flush": "fsync", "rename": "replace"}


@pytest.mark.parametrize("failing", FAILURES.values(), ids=FAILURES)
@pytest.mark.parametrize("error", [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt()])
def test_a_failure_leaves_no_part(failing, error, tmp_path, monkeypatch):
    def fail(*_arguments):
        raise error

    (tmp_path / "a").write_text("before")
    with monkeypatch.context() as patch:
        patch.setattr(f"symfric.files.os.{failing}", fail)
        with pytest.raises(type(error)):
            write_together({tmp_path / "a": "after", tmp_path / "b": b"new"})
    assert [p.name for p in tmp_path.iterdir()] == ["a"]
    assert (tmp_path / "a").read_text() == "before"
    write_together({tmp_path / "a": "after", tmp_path / "b": b"new"})
    assert {p.name: p.read_text() for p in tmp_path.iterdir()} == {"a": "after", "b": "new"}


def test_a_second_file_that_fails_leaves_the_first_as_it_was(tmp_path):
    (tmp_path / "a").write_text("before")
    with pytest.raises(OSError, match="No such file"):
        write_together({tmp_path / "a": "after", tmp_path / "missing" / "b": "new"})
    assert (tmp_path / "a").read_text() == "before"
    assert [p.name for p in tmp_path.iterdir()] == ["a"]


def test_files_have_the_permissions_of_any_other(tmp_path):
    before = os.umask(0o027)
    try:
        write_whole(tmp_path / "a", "text")
        write_whole(tmp_path / "b", "text", mode=0o600)
    finally:
        os.umask(before)
    assert (tmp_path / "a").stat().st_mode & 0o777 == 0o640
    assert (tmp_path / "b").stat().st_mode & 0o777 == 0o600


def test_the_name_of_a_file_that_is_no_text_is_written_all_the_same(tmp_path):
    name = os.fsdecode(b"belt\xff.toml")
    scene = tmp_path / name
    scene.write_text(SIMPLE)
    stream = io.TextIOWrapper(io.BytesIO(), encoding="utf-8", errors="strict")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "stdout", stream)
        with pytest.raises(SystemExit) as ended:
            main.main(["study", str(scene), "-o", str(tmp_path / "out")], prog_name="symfric")
    assert not ended.value.code
    assert "belt?.toml" in (tmp_path / "out" / "study.html").read_text(encoding="utf-8")
    json.loads((tmp_path / "out" / "study.json").read_text())
