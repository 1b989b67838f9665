"""Compiled event loops on disk: what they are made from is part of the key under which they are kept."""

import subprocess
import sys
from pathlib import Path

import pytest

from symfric.codegen.loop_loader import sources, sources_key

LOOPS = ["symfric.solve.loop.entry", "symfric.solve.exact.oscillator.entry", "symfric.solve.exact.record.entry"]
LOADED = "import sys, {}; print(*(m.__file__ for n, m in sys.modules.items() if n.startswith('symfric.')), sep=chr(10))"


@pytest.mark.parametrize("loop", LOOPS)
def test_every_compiled_function_that_a_loop_loads_is_among_its_sources(loop):
    code = LOADED.format(loop)
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    compiled = {f for f in loaded if "@compiled" in Path(f).read_text(encoding="utf-8")}
    assert len(compiled) >= 3
    assert compiled - {str(f) for f in sources(loop)} == set()


def test_the_key_changes_with_a_source(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(tmp_path))
    file = tmp_path / "loop_with_a_key.py"
    file.write_text("LEFT = 1")
    before = sources_key("loop_with_a_key")
    assert sources_key("loop_with_a_key") == before
    file.write_text("LEFT = 2")
    assert sources_key("loop_with_a_key") != before
