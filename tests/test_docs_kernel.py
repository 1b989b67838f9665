"""Kernels of executed pages are forked: alike, apart from each other, and none is left over."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PROGRAM = """
import os, sys
import matplotlib.pyplot
from docs import kernel
from nbclient import NotebookClient
from nbformat.v4 import new_code_cell, new_notebook

SPEC = {"name": "python3", "display_name": "python3"}

def printed(*cells):
    book = new_notebook(cells=[new_code_cell(c) for c in cells], metadata={"kernelspec": SPEC})
    NotebookClient(book, timeout=100).execute()
    outputs = [o for c in book.cells for o in c.outputs]
    return "".join("picture" if "image/png" in o.get("data", {}) else o.get("text") or o["data"]["text/plain"] for o in outputs)

os.makedirs("beside")
with open("beside/only_there.py", "w") as file:
    file.write("word = 'imported'")
own = "import os, sys; print(os.getppid(), 'symfric' in sys.modules, 'symfric.orbits' in sys.modules); sys.x = 1"
with kernel.offered():
    os.environ["PYTHONPATH"] += os.pathsep + os.path.abspath("beside")
    first, second = printed(own), printed(own, "print((hasattr(sys, 'x'), os.environ['WORD'], os.getcwd()))")
    drawn = printed("import matplotlib.pyplot as plt", "_ = plt.plot([1, 2])")
    beside = printed("import only_there; print(only_there.word)").strip()
    parent = int(first.split()[0])
print(first == second.splitlines()[0] + "\\n", "True True" in first, parent != os.getpid())
print(second.splitlines()[1], drawn, beside)
print(printed(own).split()[1:])
try:
    os.kill(parent, 0)
except ProcessLookupError:
    print("none is left")
"""


@pytest.mark.skipif(sys.platform != "linux", reason="kernels are forked on Linux only")
def test_kernels_are_forked_and_know_nothing_of_each_other(tmp_path, monkeypatch):
    pytest.importorskip("ipykernel", reason="no notebooks without the extra docs")
    pytest.importorskip("nbclient")
    monkeypatch.setenv("WORD", "said")
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, cwd=tmp_path)
    expected = [
        "True True True",
        f"(True, 'said', '{tmp_path}') picture imported",
        "['False', 'False']",
        "none is left",
    ]
    assert done.stdout.splitlines() == expected, done.stderr
