"""Whatever the package imports is declared: in the dependencies, or in the extra that its part needs."""

import ast
import re
import sys
import tomllib
from functools import cache
from pathlib import Path

import symfric

ROOT = Path(symfric.__file__).parent
PROJECT = Path(__file__).parents[1] / "pyproject.toml"
EVIDENCE = Path(__file__).parents[1] / "derivations" / "evidence"
IMPORTED_AS = {"pillow": "pil", "pyharm-os": "pyharm", "scikit-sundae": "sksundae", "salib": "salib"}
PARTS = {  # extras beside the dependencies of a part of the package
    "bench/peers": {"peers"},
    "report/explorer": {"explore"},
    "cli/explore.py": {"explore"},
    "ensemble": {"distributed", "sensitivity"},
}
PART_OF = {"mpl_toolkits": "matplotlib"}


@cache
def declared():
    """Return the modules of the dependencies and of each extra, those of the evidence too."""
    files = PROJECT, EVIDENCE / "pyproject.toml"
    own, other = (tomllib.loads(file.read_text(encoding="utf-8"))["project"] for file in files)

    def modules(requirements):
        names = {re.match(r"[\w.-]+", r)[0].lower() for r in requirements}
        return {IMPORTED_AS.get(n, n).replace("-", "_") for n in names}

    extras = own["optional-dependencies"] | other["optional-dependencies"]
    return modules(own["dependencies"]), {name: modules(r) for name, r in extras.items()}


def imported(path):
    """Yield the packages that a file imports, inside functions too."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (a.name.split(".")[0] for a in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node.module.split(".")[0]


def undeclared(path, place):
    needed, extras = declared()
    allowed = set(needed)
    for part, names in PARTS.items():
        if place == part or place.startswith(part + "/"):
            allowed |= set().union(*(extras[name] for name in names))
    others = {n for n in imported(path) if n not in sys.stdlib_module_names and not n.startswith("symfric")}
    return {n for n in others if PART_OF.get(n, n).lower() not in allowed}


def test_every_import_is_declared():
    found = {}
    for folder in (ROOT, EVIDENCE / "symfric_evidence"):
        for path in sorted(folder.rglob("*.py")):
            place = path.relative_to(folder).as_posix()
            if strange := undeclared(path, place):
                found[place] = strange
    assert found == {}


def test_the_test_would_see_an_import_that_is_not_declared(tmp_path):
    (tmp_path / "a.py").write_text("def f():\n    import pandas.core\n    from bokeh import models\n    import numpy\n")
    assert undeclared(tmp_path / "a.py", "solve/a.py") == {"pandas", "bokeh"}
    assert undeclared(tmp_path / "a.py", "report/explorer/a.py") == {"pandas"}


def loaded(path):
    """Yield the modules that a file loads when it is imported, with what is taken from them: not those in functions."""
    waiting = list(ast.parse(path.read_text(encoding="utf-8")).body)
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.Import):
            yield from ((a.name, ()) for a in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node.module, tuple(a.name for a in node.names)
        elif not isinstance(node, ast.FunctionDef):
            waiting += ast.iter_child_nodes(node)


def missing_for_tests(paths, folder):
    """Return what files, and the modules of `folder` that they load, need of the extras `docs` and `dev` alone."""
    needed, extras = declared()
    others = (extras["docs"] | extras["dev"]) - needed - extras["test"]
    found, seen, waiting = {}, set(), list(paths)
    while waiting:
        path = waiting.pop()
        if path in seen:
            continue
        seen.add(path)
        for module, names in loaded(path):
            parts = module.split(".")
            if parts[0] == folder.name:
                places = [folder.joinpath(*parts[1:k]) for k in range(1, len(parts) + 1)]
                places += [places[-1] / name for name in names]
                waiting += [
                    p for place in places for p in (place / "__init__.py", place.with_suffix(".py")) if p.is_file()
                ]
            elif parts[0].lower() in others:
                found.setdefault(path.name, set()).add(parts[0])
    return found


def test_tests_load_without_the_documentation_and_the_tools():
    """The README's command for tests installs neither."""
    tests = Path(__file__).parent
    assert missing_for_tests(sorted(tests.rglob("*.py")), tests.parent / "docs") == {}


def test_it_is_seen_where_a_page_needs_more(tmp_path):
    (tmp_path / "docs" / "pages").mkdir(parents=True)
    (tmp_path / "docs" / "pages" / "__init__.py").write_text("import sphinx\n")
    (tmp_path / "docs" / "pages" / "kept.py").write_text("def f():\n    import furo\n")
    (tmp_path / "docs" / "plain.py").write_text("import numpy\n")
    (tmp_path / "test_a.py").write_text("from docs.pages import kept\nfrom docs import plain\n")
    assert missing_for_tests([tmp_path / "test_a.py"], tmp_path / "docs") == {"__init__.py": {"sphinx"}}
