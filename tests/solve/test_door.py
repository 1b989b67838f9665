"""Compiled event loops on disk: what they are made from is part of the key under which they are kept."""

import ast
from pathlib import Path

import pytest

import symfric
from symfric.codegen.loop_loader import sources, sources_key
from symfric.solve.exact.oscillator.workspace import FOLDERS

PACKAGE = Path(symfric.__file__).parent


@pytest.mark.parametrize("folders", [FOLDERS[1:], FOLDERS], ids=["series", "closed forms"])
def test_everything_that_compiled_functions_import_is_among_the_sources(folders):
    known = set(sources(*folders))
    compiled = [f for folder in folders for f in folder.glob("*.py") if "@compiled" in f.read_text(encoding="utf-8")]
    assert len(compiled) >= 8
    for file in compiled:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module.startswith("symfric."):
                path = PACKAGE.joinpath(*node.module.split(".")[1:]).with_suffix(".py")
                assert path.resolve() in known, f"{file.name} imports {node.module}"


def test_the_key_changes_with_a_source(tmp_path):
    file = tmp_path / "loop.py"
    file.write_text("LEFT = 1")
    before = sources_key(tmp_path)
    assert sources_key(tmp_path) == before
    file.write_text("LEFT = 2")
    assert sources_key(tmp_path) != before
