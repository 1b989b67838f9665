"""What editors and type checkers know: every public name, its arguments, and what a call returns."""

import ast
import inspect
import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

import symfric as sf
from docs.public_names import offered
from tests.longer import longer

SCRIPT = Path(__file__).parent / "typed" / "user_script.py"
CONFIG = "[mypy]\nstrict = true\n[mypy-sympy.*]\nignore_missing_imports = true\n"
SIGNATURES = ("Scene", "System", "Contact", "Max", "simulate", "hopf", "scenes.mass_on_belt", "laws.stribeck")
MODULES = ("", "theory.", "theory.belt.", "design.", "laws.", "scenes.", "structures.", "motions.", "export.")


def assigned():
    nodes = ast.walk(ast.parse(SCRIPT.read_text()))
    targets = [n.targets[0] for n in nodes if isinstance(n, ast.Assign) and isinstance(n.value, ast.Call)]
    return [t.id for t in targets if isinstance(t, ast.Name)]


def test_the_script_of_a_user_runs():
    left = runpy.run_path(str(SCRIPT))
    assert left["run"].status is sf.Status.OK
    assert left["page"].to_dict()["motion"]["status"] == "OK"


def test_the_script_of_a_user_is_clean_for_mypy_and_every_call_has_a_type(tmp_path):
    pytest.importorskip("mypy", reason="mypy is not installed")
    (tmp_path / "mypy.ini").write_text(CONFIG)
    names = assigned()
    script = tmp_path / "script.py"
    script.write_text(SCRIPT.read_text() + "".join(f"reveal_type({name})\n" for name in names))
    root = Path(sf.__file__).parents[1]
    done = subprocess.run(
        [
            *(sys.executable, "-m", "mypy", script, "--config-file", tmp_path / "mypy.ini"),
            *("--cache-dir", root / ".mypy_cache" / "script"),
        ],
        capture_output=True,
        text=True,
        cwd=root,
    )
    types = dict(zip(names, re.findall(r'Revealed type is "(.*)"', done.stdout), strict=True))
    assert "error:" not in done.stdout, done.stdout
    assert [name for name, kind in types.items() if kind == "Any"] == []
    assert types["own"] == "symfric.model.scene.Scene"
    assert types["again"] == "symfric.solve.run.Run"
    assert len(types) > 30


@pytest.mark.parametrize("most", longer([1, 100], [100]))
def test_jedi_completes_names_arguments_and_results(most):
    """Of the first module and function, or of all of them."""
    jedi = pytest.importorskip("jedi", reason="jedi is not installed")
    project = jedi.Project(Path(sf.__file__).parents[1])

    def completed(text):
        script = jedi.Script(f"import symfric as sf\n{text}", project=project)
        return {c.name for c in script.complete(2, len(text))}

    for module in MODULES[:most]:
        home = sf
        for part in module.split(".")[:-1]:
            home = getattr(home, part)
        assert set(offered(home)) <= completed(f"sf.{module}"), module
    for name in SIGNATURES[:most]:
        thing = sf
        for part in name.split("."):
            thing = getattr(thing, part)
        text = f"sf.{name}("
        (signature,) = jedi.Script(f"import symfric as sf\n{text}", project=project).get_signatures(2, len(text))
        assert [p.name for p in signature.params] == list(inspect.signature(thing).parameters), name
    assert {"energy_residual", "final"} <= completed("sf.prepare(sf.scenes.mass_on_belt(v_b=0.2)).run().")
