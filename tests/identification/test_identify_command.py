"""The command ``identify``: a page, plain data, and one line on bad input."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from symfric.cli import main
from symfric.scenefile import read_scene_file
from tests.test_cli import Page

EXAMPLE = Path(__file__).parents[2] / "examples" / "rig_record.toml"


def call(*arguments):
    return CliRunner().invoke(main, [str(a) for a in arguments])


@pytest.fixture(scope="module")
def fitted(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fit")
    result = call("identify", EXAMPLE, "-o", folder, "--json")
    assert result.exit_code == 0, result.output
    return folder, json.loads(result.stdout)


@pytest.mark.long(beside="test_the_page_stands_alone_and_says_the_numbers")
def test_the_law_behind_the_example(fitted):
    _, data = fitted
    found = data["fit"]
    for name, true in (("mu_s", 0.42), ("mu_k", 0.27), ("v_s", 0.06)):  # the values that made the record
        assert abs(found["values"][name] - true) < 3 * found["standard_errors"][name]
        low, high = data["profiles"][name]["interval"]
        assert low < true < high
    assert found["sigma"]["gauge"] == pytest.approx(0.2, rel=0.15)
    assert len(data["predictions"]["gauge"]["t"]) == 400


def test_the_page_stands_alone_and_says_the_numbers(fitted):
    folder, data = fitted
    page = Page((folder / "identify.html").read_text(encoding="utf-8"))
    assert json.loads((folder / "identify.json").read_text()) == data
    sources = page.values("img", "src")
    assert len(sources) == 4 + 4
    assert all(s.startswith("data:image/svg+xml;base64,") for s in sources)
    assert all(page.values("img", "alt"))
    words = " ".join(page.words)
    assert f"mu_s = {data['fit']['values']['mu_s']:.6g}" in words
    assert not re.search(r"\bnan\b|\binf\b|None", words)


def copied(tmp_path, change=(), rows=None):
    text = EXAMPLE.read_text()
    for a, b in [change] if change else []:
        assert a in text
        text = text.replace(a, b)
    (tmp_path / "rig.toml").write_text(text)
    lines = (EXAMPLE.parent / "rig_record.csv").read_text().splitlines()
    (tmp_path / "rig_record.csv").write_text("\n".join(lines if rows is None else rows(lines)) + "\n")
    return tmp_path / "rig.toml"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("rig_record.csv", "gone.csv"), "gone.csv: cannot be read"),
        (("mu_s = [0.1, 1.0]", "mu_q = [0.1, 1.0]"), "mu_q is no value, state"),
        (("mu_s = [0.1, 1.0]", "mu_s = [1.0, 0.1]"), "write [smallest, largest]"),
        (('gauge = "1000*x"', 'gauge = "1000*y"'), "identify.observed.gauge"),
        (('gauge = "1000*x"', 'meter = "1000*x"'), "which is no column"),
        (('gauge = "1000*x"', ""), "no column of rig_record.csv is a state"),
        (('record = "rig_record.csv"', ""), "identify.record is missing"),
        (('record = "rig_record.csv"', 'record = "rig_record.csv"\nsigma = -1'), "identify.sigma"),
        (('record = "rig_record.csv"', 'record = "rig_record.csv"\nstart = 3'), "has no key 'start'"),
        (('record = "rig_record.csv"', 'record = "rig_record.csv"\nloss = "caucy"'), "did you mean cauchy"),
        (('gauge = "1000*x"', 'gauge = "x"'), "fit gauge.scale"),
        (("[identify.unknowns]", "[identify.unknown]"), "identify"),
    ],
)
def test_bad_files_are_one_line(tmp_path, change, message):
    result = call("identify", copied(tmp_path, change), "-o", tmp_path / "out", "--quiet")
    assert result.exit_code == 2
    assert message in result.output
    assert result.output.strip().count("\n") == 0
    assert "Traceback" not in result.output


@pytest.mark.one_in(4)
@pytest.mark.parametrize(
    ("rows", "message"),
    [
        (lambda lines: lines[:1], "no samples"),
        (lambda lines: [lines[0], *lines[:0:-1]], "not in the order of t"),
        (lambda lines: [lines[0], *(re.sub(",.*", ",1", row) for row in lines[1:])], "constant"),
        (lambda lines: [*lines[:5], "0.1;3", *lines[5:]], "line 6 has 1 fields"),
        (lambda lines: [*lines[:5], "0.1,nan", *lines[9:]], None),
        (lambda lines: lines[1:], "first line must hold names"),
    ],
)
def test_bad_records_are_one_line(tmp_path, rows, message):
    result = call("identify", copied(tmp_path, rows=rows), "-o", tmp_path / "out", "--quiet")
    assert result.exit_code == (0 if message is None else 2)
    assert message is None or message in result.output
    assert result.output.strip().count("\n") == 0


def test_a_file_without_the_section_leaves_no_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = call("identify", EXAMPLE.with_name("belt.toml"), "--quiet")
    assert result.exit_code == 2
    assert list(tmp_path.iterdir()) == []
    assert "there is no [identify] section" in result.output


def test_columns_that_measure_nothing_are_left_out(tmp_path):
    path = copied(tmp_path, rows=lambda lines: [f"{row},{'remark' if k == 0 else k}" for k, row in enumerate(lines)])
    plan = read_scene_file(path).identification
    found = plan.records(read_scene_file(path).scene)
    assert list(found) == ["gauge"]
    assert np.all(np.diff(found["gauge"][0]) > 0)


@pytest.mark.long(beside="test_the_page_stands_alone_and_says_the_numbers")
def test_a_robust_loss_and_an_unknown_at_its_bound(tmp_path):
    """Three spoilt samples, and the static coefficient bounded below its value."""

    def spoilt(lines):
        return [f"{row.split(',')[0]},{9.0}" if k in (50, 200, 300) else row for k, row in enumerate(lines)]

    path = copied(tmp_path, ("mu_s = [0.1, 1.0]", "mu_s = [0.1, 0.4]"), spoilt)
    text = path.read_text()
    path.write_text(text.replace('record = "rig_record.csv"', 'record = "rig_record.csv"\nloss = "cauchy"'))
    result = call("identify", path, "-o", tmp_path / "out", "--json")
    assert result.exit_code == 0, result.output
    data = json.loads(result.stdout)
    assert data["fit"]["loss"] == "cauchy"
    assert "mu_s" in data["fit"]["active"]
    assert data["intervals"]["mu_s"][1] == data["fit"]["values"]["mu_s"] == 0.4
    assert data["profiles"]["mu_s"]["interval"][1] is None
    words = " ".join(Page((tmp_path / "out" / "identify.html").read_text(encoding="utf-8")).words)
    assert "at least" in words
    assert not re.search(r"\bnan\b|\binf\b", words)
