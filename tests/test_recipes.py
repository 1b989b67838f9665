"""The recipes of the contributing page, carried out on a copy of the package: each works, and touches so many files."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

import symfric
from tests.longer import longer

PACKAGE = Path(symfric.__file__).parent
PAGE = Path(__file__).parents[1] / "docs" / "contributing.md"
FILES = {  # of the package that a recipe touches
    "a law": 2,
    "a law with memory": 2,
    "an output": 2,
    "a design": 5,
    "a section of the study page": 2,
    "a route": 2,
}
HERE = "import symfric\nassert symfric.__file__.startswith({!r}), symfric.__file__\n"
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.DOTALL | re.MULTILINE)
WAYS = {
    r"[Aa] new file `(?P<file>[^`]+)`": "new",
    r"In `(?P<file>[^`]+)`, after the line\s+`(?P<line>[^`]+)`": "after",
    r"In `(?P<file>[^`]+)`, in place of the line\s+`(?P<line>[^`]+)`": "instead",
    r"Then ": "check",
}


class Step(NamedTuple):
    """A block of code: what to do with it, in which file and at which line of it."""

    way: str
    file: str
    line: str
    code: str


def step(words, code):
    """Return the step of a block of code from the words before it."""
    told = [(way, found) for pattern, way in WAYS.items() for found in re.finditer(pattern, words)]
    assert len(told) == 1, f"these words must say once where the code below belongs: {words}"
    ((way, found),) = told
    where = found.groupdict()
    return Step(way, where.get("file", ""), where.get("line", ""), code)


def recipes():
    """Return the steps of each recipe of the page, and how many files it says they touch."""
    _, *parts = re.split(r"^#+ Recipe: (.*)$", PAGE.read_text(encoding="utf-8"), flags=re.MULTILINE)
    found = {}
    for name, text in zip(parts[::2], parts[1::2], strict=True):
        words = BLOCK.split(text)
        steps = [step(*pair) for pair in zip(words[:-1:2], words[1::2], strict=True)]
        found[name] = steps, int(re.search(r"Files of the package: (\d+)", text)[1])
    return found


RECIPES = recipes()


def carried_out(steps, root):
    """Carry out the steps in a copy of the package."""
    for way, name, line, code in steps:
        file = root / name
        if way == "new":
            assert not file.exists()
            file.parent.mkdir(exist_ok=True)
            file.write_text(code, encoding="utf-8")
        elif way != "check":
            lines = file.read_text(encoding="utf-8").splitlines(keepends=True)
            places = [k for k, text in enumerate(lines) if text.strip() == line]
            assert len(places) == 1, f"{name} has the line {line} {len(places)} times"
            (k,) = places
            lines[k : k + 1] = [code] if way == "instead" else [lines[k], code]
            file.write_text("".join(lines), encoding="utf-8")


def checked(steps, root):
    """Run the check of a recipe with the package of a folder; return what it reports."""
    (check,) = (s.code for s in steps if s.way == "check")
    script = root / "check.py"
    script.write_text(HERE.format(str(root)) + check, encoding="utf-8")
    quiet = {**os.environ, "SYMFRIC_PROGRESS": "0"}  # what takes long on a busy machine is no error
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, cwd=root, env=quiet)
    assert (done.returncode == 0) == (not done.stderr), done.stderr
    return done.stderr


def changed(root):
    """Return the files of a copy of the package that are new or differ."""
    own = {p.relative_to(PACKAGE.parent) for p in PACKAGE.rglob("*") if p.is_file() and p.suffix != ".pyc"}
    copied = {p.relative_to(root) for p in (root / "symfric").rglob("*") if p.is_file() and p.suffix != ".pyc"}
    assert own <= copied
    return [p for p in copied if p not in own or (root / p).read_bytes() != (PACKAGE.parent / p).read_bytes()]


@pytest.fixture
def root(tmp_path):
    """Return a folder with a copy of the package; with its bytecode, which holds as the times of the files are kept."""
    shutil.copytree(PACKAGE, tmp_path / "symfric", ignore=shutil.ignore_patterns("*.pyc.*"))
    return tmp_path


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", FILES)
def test_a_recipe_works_and_touches_few_files(name, root):
    steps, said = RECIPES[name]
    carried_out(steps, root)
    assert len(changed(root)) == said == FILES[name]
    assert checked(steps, root) == ""


LEFT_OUT = [
    (name, k)
    for name in FILES
    for k, done in enumerate(RECIPES[name][0])
    if done.way != "check" and not (done.way == "new" and done.file.endswith("__init__.py"))  # Python does without one
]


@pytest.mark.parametrize("without", longer(LEFT_OUT, LEFT_OUT[1:]), ids=str)
def test_a_recipe_fails_without_one_of_its_steps(without, root):
    name, left_out = without
    steps, _ = RECIPES[name]
    carried_out([s for k, s in enumerate(steps) if k != left_out], root)
    assert "Error" in checked(steps, root)


def test_the_page_has_these_recipes():
    assert list(RECIPES) == list(FILES)
