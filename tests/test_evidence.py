"""What users install holds no evidence and needs none; the benchmark and the reproductions are a second package."""

import ast
import os
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

pytest.importorskip("hatchling", reason="builds the wheels")
ROOT = Path(__file__).parents[1]
EVIDENCE = ROOT / "derivations" / "evidence"
BUILD = "import sys; from hatchling.build import build_wheel; print(build_wheel(sys.argv[1]))"
COMMAND = "from symfric.cli import main; main(prog_name='symfric')"
IMPORT_ALL = """
import importlib, sys
from pathlib import Path
import symfric

root = Path(symfric.__file__).parents[1]
assert root == Path(sys.argv[1])
for path in root.glob("symfric/**/*.py"):
    parts = path.relative_to(root).with_suffix("").parts
    if parts[-1] != "__main__":
        importlib.import_module(".".join(parts).removesuffix(".__init__"))
assert not any(name.startswith("symfric_evidence") for name in sys.modules)
"""


def unpacked(source, folder):
    """Build the wheel of a folder without a network, and unpack it."""
    wheel = subprocess.run(
        [sys.executable, "-c", BUILD, folder], cwd=source, capture_output=True, text=True, check=True
    )
    with zipfile.ZipFile(folder / wheel.stdout.strip()) as archive:
        archive.extractall(folder / "unpacked")
    return folder / "unpacked"


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    if not (ROOT / "symfric").is_dir():
        pytest.skip("the sources are not here")
    return unpacked(ROOT, tmp_path_factory.mktemp("package"))


@pytest.fixture(scope="module")
def evidence(tmp_path_factory):
    return unpacked(EVIDENCE, tmp_path_factory.mktemp("evidence"))


def run(arguments, places, cwd):
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, places))}
    return subprocess.run([sys.executable, *arguments], env=environment, cwd=cwd, capture_output=True, text=True)


def test_the_wheel_of_users_holds_no_evidence(package):
    assert sorted(p.name for p in package.iterdir() if p.suffix != ".dist-info") == ["symfric"]
    names = {p.relative_to(package / "symfric").parts[0] for p in package.glob("symfric/**/*.py")}
    assert "solve" in names
    assert not names & {"bench", "stress", "event_reference", "peers"}


@pytest.mark.long(beside="test_the_package_never_imports_the_evidence")
def test_everything_in_the_wheel_of_users_imports(package, tmp_path):
    done = run(["-c", IMPORT_ALL, package], [package], tmp_path)
    assert done.returncode == 0, done.stderr


def test_the_package_never_imports_the_evidence():
    for path in (ROOT / "symfric").rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        for node in ast.walk(ast.parse(text if "symfric_evidence" in text else "")):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            names += [a.name for a in node.names] if isinstance(node, ast.Import) else []
            assert not any(n.split(".")[0] == "symfric_evidence" for n in names), path


@pytest.mark.parametrize("command", ["bench", "stress", "reproduce"])
def test_without_the_evidence_its_commands_say_how_to_get_them(package, command, tmp_path):
    done = run(["-c", COMMAND, command, "--list"], [package], tmp_path)
    assert done.returncode == 2
    assert done.stdout == ""
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"Error: symfric {command} is in the package symfric-evidence; install that")
    assert command not in run(["-c", COMMAND, "--help"], [package], tmp_path).stdout


def test_with_both_wheels_the_commands_are_there(package, evidence, tmp_path):
    assert sorted(p.name for p in evidence.iterdir() if p.suffix != ".dist-info") == ["symfric_evidence"]
    listed = run(["-c", COMMAND, "reproduce", "--list"], [package, evidence], tmp_path)
    assert listed.returncode == 0, listed.stderr
    assert "thomsen-9: " in listed.stdout
    for file in ("templates/gallery.html", "bench/half_ranges.txt"):
        assert (evidence / "symfric_evidence" / file).is_file()


def test_both_packages_are_of_one_version():
    own, other = (
        tomllib.loads((p / "pyproject.toml").read_text(encoding="utf-8"))["project"] for p in (ROOT, EVIDENCE)
    )
    assert other["version"] == own["version"]
    assert other["dependencies"] == [f"symfric=={own['version']}"]
