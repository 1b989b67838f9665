"""A section is one file: what it computes is limited in time, and stands on the page, in the data and beside them."""

import json

import numpy as np
import pytest

import symfric as sf
from symfric.report.html.elements import heading, paragraph
from symfric.report.html.words import measured
from symfric.report.study.data import data_files, to_dict
from symfric.report.study.page import page, summary
from symfric.report.study.section import Section, csv_text
from symfric.report.study.sections import DESIGNS, MOTION, SECTIONS
from symfric.report.study.sections.comparison import COMPARISON
from symfric.report.study.sections.motion import STEADY, pictures
from symfric.report.study.sections.onset import HOPF
from symfric.report.study.sections.stability import EQUILIBRIUM
from symfric.report.study.study import study
from symfric.scenefile import file_of, read_scene_text
from symfric.time_limit import OutOfTime, time_limit

SCENE = sf.scenes.coulomb_oscillator(0.1)


def fastest(found, _tell):
    """What a new section computes from the answer of one before."""
    return float(np.max(np.abs(found[MOTION].found.x[1])))


SPEED = Section(
    "fastest",
    fastest,
    topic="largest speed",
    place=55,
    page=lambda found: [heading("The largest speed", "fastest"), paragraph(measured(found[SPEED].found))],
    rank=9,
    summary=lambda _found, value: [f"No point is faster than {value:.3g}."],
    key="fastest",
    data=lambda _found, value: value,
    tables=lambda _found, value: {"fastest.csv": csv_text(["fastest"], [[value]])},
)


def test_a_section_of_this_file_stands_everywhere():
    found = study(file_of(SCENE), sections=(*SECTIONS, SPEED))
    value = found.fastest.value
    text = page(found)
    assert text.index('id="motion"') < text.index('id="fastest"') < text.index('id="friction"')
    assert f"<p>{measured(value)}</p>" in text
    assert 'href="fastest.csv"' in text
    assert summary(found)[-1] == f"No point is faster than {value:.3g}."
    files = data_files(found)
    assert json.loads(files["study.json"])["fastest"] == value
    assert files["fastest.csv"] == f"fastest\n{value!r}\n"
    assert "largest speed" not in found.skipped()
    assert "fastest" in dir(found)


def test_a_section_without_a_value_says_why():
    stopped = study(file_of(SCENE), limit=1e-9, sections=(MOTION, SPEED))
    assert stopped.fastest.out_of_time
    assert stopped.skipped()["largest speed"] == stopped.skipped()["motion"]
    assert to_dict(stopped)["fastest"] is None
    assert "fastest.csv" not in data_files(stopped)
    with pytest.raises(sf.NotFound, match="stopped after"):
        stopped.fastest.found  # noqa: B018
    with pytest.raises(AttributeError, match="no section 'slowest'; this one has motion, fastest"):
        stopped.slowest  # noqa: B018


def test_only_long_parts_have_the_longer_limit(monkeypatch):
    given = []
    monkeypatch.setattr("symfric.report.study.study.time_limit", lambda s: given.append(s) or time_limit(s))
    quick = [Section(name, lambda *_: 1, longer=name == "designs") for name in ("motion", "designs")]
    assert study(file_of(SCENE), limit=2.0, sections=quick).designs.value == 1
    assert given == [2.0, 20.0]
    given.clear()
    late = Section("motion", lambda *_: (_ for _ in ()).throw(OutOfTime("stopped after 2 s")))
    study(file_of(SCENE), limit=2.0, sections=(late, DESIGNS))
    assert given == [2.0, 2.0]


def test_the_list_says_each_name_once():
    names = [s.name for s in SECTIONS]
    assert len(set(names)) == len(names)


@pytest.fixture(scope="module")
def belt():
    """Averaging is made for motion without sticking, and this one sticks."""
    text = '[scene]\nmodel = "mass_on_belt"\nhorizon = 200\n[values]\nv_b = 0.2\n'
    return study(read_scene_text(text), sections=(MOTION, STEADY, EQUILIBRIUM, HOPF, COMPARISON, *others()))


def others():
    """What the comparison looks for besides, which this scene does not have."""
    return [s for s in SECTIONS if s.name in ("flutter", "designs")]


def test_a_formula_that_is_not_made_for_the_motion_is_named_first_and_stands_last(belt):
    rows = [r for r in belt.comparison.found if r.quantity == "half range of x"]
    assert [bool(r.caution) for r in rows] == [False, False, True]
    assert abs(rows[-1].difference) > 0.2 > 0.05 > min(abs(r.difference) for r in rows)
    text = page(belt)
    begin = text.index('id="comparison"')
    assert begin < text.index("Averaging, first order: made for motion without sticking", begin)
    assert text.index("it is no check", begin) < text.index("<table", begin)


def test_the_last_periods_of_a_long_motion_have_a_picture(belt):
    moved, file = belt.motion.found, belt.file
    assert "The last 5 periods." in [p.caption for p in pictures(moved, file, belt.steady.found.period)]
    assert "The last 5 periods." not in [p.caption for p in pictures(moved, file, moved.t[-1] / 20)]
    assert "The last 5 periods." not in [p.caption for p in pictures(moved, file)]
    late = moved.t > moved.t[-1] - 5 * belt.steady.found.period
    assert np.max(np.diff(moved.t[late])) < belt.steady.found.period / 100
