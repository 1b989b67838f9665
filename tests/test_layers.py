"""Imports point down only, and importing the package stays light."""

import ast
import importlib
import re
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest

import symfric

ROOT = Path(symfric.__file__).parent
BELOW = {
    "axes": {"errors"},
    "errors": set(),
    "array_files": {"errors"},
    "fields": {"model"},
    "files": set(),
    "interrupts": set(),
    "locks": {"spelling"},
    "long_calls": {"shown_progress", "spelling"},
    "shown_progress": set(),
    "spelling": set(),
    "time_limit": set(),
    "scalars": set(),
    "search": set(),
    "templates": set(),
    "model": {"axes", "errors", "locks", "spelling", "templates"},
    "lower": {"errors", "locks", "model", "scalars"},
    "theory": {"axes", "errors", "locks", "long_calls", "lower", "model", "search", "spelling"},
    "motions": {"axes", "errors", "fields", "files", "locks", "model", "spelling", "templates"},
    "codegen": {"errors", "files", "locks", "time_limit"},
    "solve": {
        "axes",
        "codegen",
        "errors",
        "files",
        "locks",
        "long_calls",
        "scalars",
        "search",
        "spelling",
        "time_limit",
        "templates",
        "model",
        "lower",
    },
}
BELOW["export"] = BELOW["solve"] | {"solve"}
BELOW["orbits"] = BELOW["solve"] | {"solve", "theory"}
BELOW["ensemble"] = BELOW["orbits"] | {"orbits", "motions"}
BELOW["structures"] = BELOW["orbits"] | {"array_files", "orbits"}
BELOW["design"] = BELOW["ensemble"] | {"ensemble", "fields", "structures"}
BELOW["identification"] = BELOW["ensemble"] | {"array_files", "ensemble"}
BELOW["scenefile"] = BELOW["design"] | {"design", "identification"}
BELOW["report"] = BELOW["scenefile"] | {"scenefile"}
BELOW["cli"] = BELOW["report"] | {"report", "export", "interrupts"}
BELOW["__main__"] = {"cli"}
# Scene.study, the only method that an upper layer carries out: it imports that when it is called
UPWARD = {("model/scene.py", "symfric.report.study.study")}
HEAVY = ("matplotlib", "control", "xarray", "heyoka", "IPython", "distributed")
LINES = 400  # most lines of a file, docstrings apart


def files():
    return sorted(ROOT.rglob("*.py"))


def layer_of(path):
    parts = path.relative_to(ROOT).with_suffix("").parts
    return "symfric" if parts == ("__init__",) else parts[0]


class Parsed(NamedTuple):
    """What the tests look at in a file: its imports, those of them for types alone, and the lines of docstrings."""

    imports: list[ast.Import | ast.ImportFrom]
    typing: set[ast.AST]
    told: int


@cache
def parsed(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    nodes = list(ast.walk(tree))
    found = [n for n in nodes if isinstance(n, ast.Import | ast.ImportFrom)]
    typing = [n for n in nodes if isinstance(n, ast.If) and getattr(n.test, "id", "") == "TYPE_CHECKING"]
    documented = (n for n in nodes if isinstance(n, ast.FunctionDef | ast.ClassDef | ast.Module))
    told = (n.body[0] for n in documented if ast.get_docstring(n) is not None)
    within = {n for block in typing for e in block.body for n in ast.walk(e)} & set(found)
    return Parsed(found, within, sum(d.end_lineno - d.lineno for d in told))


def imports(path):
    """Yield line and dotted name of every import of the package, those inside functions too."""
    package = ("symfric", *path.relative_to(ROOT).parent.parts)
    for node in parsed(path).imports:
        if isinstance(node, ast.Import):
            yield from ((node.lineno, a.name) for a in node.names if a.name.split(".")[0] == "symfric")
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(package[: len(package) - node.level + 1]) if node.level else ""
            module = ".".join(filter(None, [base, node.module]))
            if module == "symfric":
                yield from ((node.lineno, f"symfric.{a.name}") for a in node.names)
            elif module.startswith("symfric."):
                yield node.lineno, module


def violations():
    found = []
    for path in files():
        layer = layer_of(path)
        if layer == "symfric":
            continue
        for line, name in imports(path):
            if (path.relative_to(ROOT).as_posix(), name) in UPWARD:
                continue
            parts = name.split(".")
            target = parts[1] if len(parts) > 1 else "symfric"
            if target not in BELOW[layer] | {layer}:
                found.append(f"{path.relative_to(ROOT)}:{line} imports {name}")
    return found


def test_every_module_belongs_to_a_layer():
    assert {layer_of(path) for path in files()} - set(BELOW) - {"symfric"} == set()


def test_no_import_points_up():
    assert violations() == []


def test_the_test_would_see_an_upward_import(tmp_path, monkeypatch):
    fake = tmp_path / "symfric"
    (fake / "model").mkdir(parents=True)
    source = (
        "def f():\n    from symfric.solve.run import Run\n    from ..lower import printer\n    import symfric.theory\n"
    )
    (fake / "model" / "laws.py").write_text(source)
    monkeypatch.setattr(sys.modules[__name__], "ROOT", fake)
    assert [v.split(" imports ")[1] for v in violations()] == ["symfric.solve.run", "symfric.lower", "symfric.theory"]


def dependencies():
    """Return for each module the modules of the package that it imports, inside functions too; types do not count."""
    names = {}
    for path in files():
        parts = (ROOT.name, *path.relative_to(ROOT).with_suffix("").parts)
        names[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    found = {}
    for module, path in names.items():
        found[module] = set()
        for node in parsed(path).imports:
            if isinstance(node, ast.ImportFrom) and node.module in names and node not in parsed(path).typing:
                if (path.relative_to(ROOT).as_posix(), node.module) in UPWARD:
                    continue
                inside = [f"{node.module}.{a.name}" for a in node.names if f"{node.module}.{a.name}" in names]
                found[module] |= {*inside, *([node.module] if len(inside) < len(node.names) else [])}
    return found


def circle(graph):
    """Return some modules that import each other in a circle, none if there is no such circle."""
    done, path = set(), []

    def visit(module):
        if module in path:
            return path[path.index(module) :]
        if module in done:
            return []
        path.append(module)
        found = next((c for c in map(visit, sorted(graph[module])) if c), [])
        path.pop()
        done.add(module)
        return found

    return next((c for c in map(visit, sorted(graph)) if c), [])


def test_no_modules_import_each_other_in_a_circle():
    graph = dependencies()
    assert len(graph) > 300
    assert circle(graph) == []


def test_the_test_would_see_a_circle(tmp_path, monkeypatch):
    fake = tmp_path / "symfric"
    fake.mkdir()
    (fake / "a.py").write_text("def f():\n    from symfric.b import g\n")
    (fake / "b.py").write_text("from symfric.c import h\n")
    (fake / "c.py").write_text("from symfric.a import f\n")
    monkeypatch.setattr(sys.modules[__name__], "ROOT", fake)
    assert sorted(circle(dependencies())) == ["symfric.a", "symfric.b", "symfric.c"]


@pytest.mark.parametrize("module", ["symfric", "symfric.cli"])
def test_import_is_light(module):
    code = f"import sys, {module}; print([m for m in {HEAVY} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def length(path):
    """Return the number of lines without those of docstrings beyond the first, which tell all that a user may ask."""
    return len(path.read_text(encoding="utf-8").splitlines()) - parsed(path).told


@pytest.mark.one_in(2)
@pytest.mark.parametrize("folder", ["symfric", "derivations"])
def test_files_are_short(folder):
    lengths = {p: length(p) for p in (ROOT.parent / folder).rglob("*.py")}
    assert [p for p, n in lengths.items() if n > LINES] == []
    assert lengths


def test_files_that_the_contributing_page_names_exist():
    root = ROOT.parent
    text = (root / "docs" / "contributing.md").read_text(encoding="utf-8")
    new = set(re.findall(r"new file `([^`]+)`", text))  # of a recipe
    names = [n for n in re.findall(r"`([\w./-]+)`", text) if n not in new and ("/" in n or n.endswith(".py"))]
    assert [n for n in names if not ((root / n).exists() or (ROOT / n).exists())] == []
    assert len(names) > 30


def test_a_result_loads_neither_compiler_nor_scipy_once_its_loop_is_on_disk():
    scenes = "sf.scenes.mass_on_belt(v_b=0.2)", "sf.scenes.coulomb_oscillator(0.03)"
    for scene in scenes:
        symfric.simulate(eval(scene, {"sf": symfric}))  # may have to compile
    run = (
        f"import sys, symfric as sf; print(*(sf.simulate(s).status.name for s in ({', '.join(scenes)})), "
        "*(m for m in ('numba', 'scipy') if m in sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", run], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["OK", "OK"]


def test_every_public_name_is_there_and_is_that_of_its_module():
    tree = ast.parse((ROOT / "__init__.pyi").read_text())
    told = {}
    for node in tree.body:
        if isinstance(node, ast.ImportFrom):
            told |= {a.name: ".".join(filter(None, ["symfric", node.module])) for a in node.names}
            assert all(a.name == a.asname for a in node.names), "a stub hides what is not imported as itself"
    assert sorted(told) == sorted(symfric.__all__)
    for name, module in told.items():
        home = importlib.import_module(module)
        same = getattr(home, name, None) or importlib.import_module(f"{module}.{name}")
        assert getattr(symfric, name) is same, name
    with pytest.raises(AttributeError, match="simulat"):
        symfric.simulat  # noqa: B018
