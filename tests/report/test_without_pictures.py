"""Where Matplotlib, pandas, xarray, control and numba are missing, a study holds its words, tables and data."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from symfric.scenefile.starters import starter

EXAMPLES = Path(__file__).parents[2] / "examples"
ABSENT = "matplotlib", "pandas", "xarray", "control", "numba"
STUDY = f"""
import sys
sys.modules.update(dict.fromkeys({ABSENT}))  # as if they were not installed
from symfric.cli import main
main(["study", sys.argv[1], "-o", sys.argv[2]])
"""


def check(path, folder):
    done = subprocess.run([sys.executable, "-c", STUDY, str(path), str(folder)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    page, data = (folder / "study.html").read_text(encoding="utf-8"), json.loads((folder / "study.json").read_text())
    assert page.count("pictures: python -m pip install matplotlib adds them") == 1
    assert "<figure" not in page
    assert "data:image" not in page
    assert "ModuleNotFoundError" not in page + json.dumps(data)
    assert page.count("<h2") >= 4
    assert "<table" in page


def test_a_study_without_optional_packages(tmp_path):
    path = tmp_path / "oscillator.toml"
    path.write_text(starter("coulomb_oscillator"), encoding="utf-8")
    check(path, tmp_path / "study")


@pytest.mark.long(beside="test_a_study_without_optional_packages")
@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda p: p.stem)
def test_studies_of_the_examples_without_optional_packages(path, tmp_path):
    check(path, tmp_path / "study")
