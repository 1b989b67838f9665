"""Figures and tables of the sources: computed, drawn without collisions, and judged as the ledger judges them."""

import ast
import xml.dom.minidom
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import symfric as sf
from symfric.cli import main
from symfric_evidence.sources import registry
from symfric_evidence.sources.gallery import gallery
from symfric_evidence.sources.guida import slides
from symfric_evidence.sources.registry import SOURCES, Inputs, title
from symfric_evidence.sources.reproduction import NOT_MADE, chosen, reproductions
from symfric_evidence.sources.rolling import printed_scheme, scaling_figures
from symfric_evidence.sources.rolling.printed_scheme import returned_by_steps, rounded_factors
from symfric_evidence.sources.thomsen import quench
from tests.fixed_step import fixed_step

NAMES = tuple(reproductions())
COSTLY = (
    "guida-4",
    "guida-5",
    "guida-1",
    "younes-",
    "rolling-",
    "guida-readings",
    "guida-stability",
    "thomsen-2",
    "thomsen-6",
    "thomsen-8",
    "thomsen-9",
    "thomsen-quench-speeds",
)
CHEAP = tuple(n for n in NAMES if not n.startswith(COSTLY) or n in ("guida-1", "guida-12", "guida-13", "younes-1"))
DRAWN = (  # one of each shape, and those with the longest words
    "thomsen-1",
    "thomsen-3",
    "thomsen-5",
    "thomsen-7",
    "thomsen-quench-energy",
    "handbook-19.15",
    "handbook-19.17",
    "handbook-chatter",
    "guida-2",
    "guida-3",
    "guida-8",
    "guida-9",
    "guida-12",
    "younes-1",
    "rolling-3",
    "rolling-5",
)
ROLLING = ("rolling-1", "rolling-2", "rolling-3", "rolling-4", "rolling-5", "rolling-6", "rolling-7", "rolling-8")


@pytest.fixture(scope="module")
def made():
    """Every figure that takes a second or two; the others have tests of their own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(quench, "FREQUENCIES", (20.0, 30.0, 33.0, 40.0))
        patch.setattr(quench, "bounds", quench.bounds.__wrapped__)
        return {name: reproductions()[name].make() for name in CHEAP}


@pytest.fixture(scope="module")
def rolled():
    """The study's figures from three bursts."""
    motions = [sf.motions.sine_burst(2.0, f, 6, dt=0.01) for f in (0.7, 1.1, 1.9)]
    shares = []
    found = {n: reproductions()[n].make(Inputs(motions, shares.append)) for n in (*ROLLING, "rolling-table-1")}
    assert shares[-1] == 1
    return found


def test_every_figure_and_table_of_the_sources_has_a_name():
    figures = {
        "thomsen": [str(k) for k in range(1, 10)],
        "handbook": [f"19.{k}" for k in range(14, 20)] + ["table-19.6"],
        "guida": [str(k) for k in range(1, 17)],
        "younes": [str(k) for k in range(1, 11)],
        "rolling": [str(k) for k in range(1, 9)] + ["table-1", "table-2", "table-3"],
    }
    wanted = {f"{source}-{number}" for source, numbers in figures.items() for number in numbers}
    assert wanted <= set(NAMES) | set(NOT_MADE)
    assert not set(NAMES) & set(NOT_MADE)
    assert title("rolling-table-2") == f"{SOURCES['rolling']}, table 2"
    assert NAMES.index("guida-9") < NAMES.index("guida-10") < NAMES.index("guida-readings")


def test_what_is_not_made_is_refused_with_the_reason():
    with pytest.raises(sf.SceneError, match="younes-2 is not made: layout"):
        chosen(["younes-2"])
    with pytest.raises(sf.SceneError, match="no figure 'thomsen-99'; did you mean thomsen-9"):
        chosen(["thomsen-99"])


def test_a_list_has_one_line_for_each():
    lines = CliRunner().invoke(main, ["reproduce", "--list"]).output.splitlines()
    assert [line.split(": ")[0] for line in lines] == list(NAMES)
    assert all(line.endswith(".") or "section" in line or "(58)" in line for line in lines)


def _texts(figure):
    """The boxes of titles, labels and legends."""
    flat = [ax for ax in figure.axes if ax.name == "rectilinear"]
    words = [t for ax in flat for t in (ax.xaxis.label, ax.yaxis.label, ax.title) if t.get_text()]
    heads = [t for t in (figure._suptitle,) if t is not None and t.get_text()]
    return [t.get_window_extent() for t in (*words, *heads)]


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", DRAWN)
def test_pictures_have_labels_that_do_not_collide(name, made, rolled):
    figure = {**made, **rolled}[name].figure
    figure.draw_without_rendering()
    boxes = _texts(figure)
    assert boxes
    for k, box in enumerate(boxes):
        assert figure.bbox.x0 - 1 <= box.x0
        assert box.x1 <= figure.bbox.x1 + 1
        assert box.y1 <= figure.bbox.y1 + 1
        assert not any(box.overlaps(other) for other in boxes[:k])
    for legend in figure.legends:
        box = legend.get_window_extent()
        assert figure.bbox.x0 <= box.x0
        assert box.x1 <= figure.bbox.x1
        assert not any(box.padded(-1).overlaps(other) for other in boxes)
    for ax in figure.axes:
        if ax.get_legend() is not None:  # beside the data
            assert not ax.get_legend().get_window_extent().padded(-2).overlaps(ax.get_window_extent())
        if ax.axison:
            assert ax.get_xlabel()
            assert ax.get_ylabel()


def verdicts(found) -> list:
    return [f.holds for f in found.findings]


def test_no_judgement_is_written_down():
    """A verdict is computed: none of the findings is given as True or False in the source."""
    for file in Path(registry.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "Finding":
                given = [*node.args[2:], *(k.value for k in node.keywords if k.arg == "holds")]
                assert not any(isinstance(e, ast.Constant) and isinstance(e.value, bool) for e in given), (
                    file,
                    node.lineno,
                )
                written = [*node.args[1:2], *(k.value for k in node.keywords if k.arg == "found")]
                if given and not (isinstance(given[0], ast.Constant) and given[0].value is None):
                    assert not any(isinstance(e, ast.Constant) for e in written), f"no number at {file}:{node.lineno}"


def test_thomsen_is_judged_as_the_derivations_judge_it(made):
    assert verdicts(made["thomsen-3"]) == [False, False, False]
    assert [f.found for f in made["thomsen-3"].findings] == ["0.9241", "0.8479", "32 % of it"]
    assert verdicts(made["thomsen-4"]) == [True]
    assert verdicts(made["thomsen-5"]) == [True, False, True, True, False]
    assert "0.395790" in made["thomsen-5"].findings[0].found
    assert verdicts(made["thomsen-7"]) == [True, False, True, None]
    assert verdicts(made["thomsen-quench-energy"]) == [False, True, False]


@pytest.mark.long(beside="test_thomsen_is_judged_as_the_derivations_judge_it")
def test_power_of_the_vibration_is_judged_as_the_derivations_judge_it():
    assert "0.010002" in reproductions()["thomsen-8"].make().findings[1].found


@pytest.mark.long(beside="test_thomsen_is_judged_as_the_derivations_judge_it")
def test_bounds_of_quenching_are_judged_as_the_derivations_judge_them():
    found = reproductions()["thomsen-9"].make()
    assert "0.20048 to 0.41755, Omega = 30: 0.30033 to 0.38645" in found.findings[0].found
    assert verdicts(found) == [True] * 4


@pytest.mark.long(beside="test_the_index_shows_every_picture_once")
def test_drawn_curves_are_the_closed_forms():
    below, at = (
        np.array(reproductions()["thomsen-quench-speeds"].make().figure.axes[0].lines[k].get_data()) for k in (1, 0)
    )
    belt = sf.scenes.mass_on_belt(v_b=0.3)
    for (v, low), (_, exact) in list(zip(below.T, at.T, strict=True))[::40]:
        assert low == pytest.approx(sf.theory.belt.quench_intensity_below(belt, v))
        assert exact == pytest.approx(sf.theory.belt.quench_intensity_at(belt, v))


def test_the_stop_of_a_drive_agrees_with_the_solver(made):
    for name in ("guida-8", "guida-9"):
        for finding in made[name].findings:
            formula, solver = (float(part.split()[-1 if "=" in part else 0]) for part in finding.found.split(", ")[-2:])
            assert solver == pytest.approx(formula, abs=2e-6)
            assert finding.holds


def test_models_return_one_where_similarity_says_so(rolled):
    assert verdicts(rolled["rolling-4"]) == verdicts(rolled["rolling-6"]) == [True]
    assert (
        "with the factors as they are rounded in table 1 they are off by up to" in rolled["rolling-4"].findings[0].found
    )
    assert verdicts(rolled["rolling-2"])[:2] == [True, True]
    ratio = next(f for f in rolled["rolling-7"].findings if "just the model scale" in f.claim)
    assert ratio.holds
    assert "1:19: 0.0526" in ratio.found


def test_the_printed_scheme_returns_one_with_exact_factors_at_every_scale():
    motions = [sf.motions.sine_burst(2.0, f, 6, dt=0.01) for f in (0.7, 1.9)]
    profiles = {False: 0.005, True: sf.patched_floor(4.0, 81, 0.005, 0.002355, 0.004, seed=4)}
    peaks = ("peak_acceleration", "peak_velocity", "peak_displacement")
    for moved, profile in profiles.items():
        exact = [sf.theory.scaling.factors(L, D) for L, D in ((4.0, 1.0), (19.0, 1.0), (7.3, 2.8), (2.0, 0.3))]
        found = returned_by_steps(motions, profile, exact, moved=moved)
        assert all(np.max(np.abs(found[k] - 1)) < 5e-14 for k in peaks)
        rounded = returned_by_steps(motions, profile, rounded_factors(), moved=moved)
        off = np.max(np.abs(rounded["peak_acceleration"] - 1), axis=(1, 2))
        assert np.all(off[[0, 1, 3, 4, 5]] > 1e-4)
        assert off[2] < 1e-12  # 1:10 is printed exactly


def test_the_vectorised_scheme_is_the_scheme_of_one_motion():
    motion = sf.motions.sine_burst(2.0, 1.1, 6, dt=0.01)
    found = printed_scheme._march(
        motion.samples[:, None, None],
        np.array([[motion.dt]]),
        np.array([[motion.samples.size]]),
        (sf.theory.scaling.factors(1.0),),
        2e5,
        printed_scheme._floor(0.005),
        False,
    )
    single = fixed_step(motion.samples, motion.dt, 2e5 / 3e5, 0.005 * 9.81)
    np.testing.assert_allclose([v.item() for v in found.values()], single, rtol=1e-13)


def test_the_falling_section_of_the_handbook_is_judged_where_it_is(made):
    assert verdicts(made["handbook-19.15"]) == [False, True, True, None]
    assert "up to v = 0.01986" in made["handbook-19.15"].findings[0].found


def test_a_statement_with_two_readings_is_judged_in_both():
    findings = reproductions()["guida-5"].findings(slides.stability_maps(3))
    assert [f.holds for f in findings] == [True, False, False]
    assert "eps_crit = 8.388 at 2 mu2 = 1.1" in findings[1].found


def test_scale_tables_are_those_printed(rolled):
    assert rolled["rolling-table-1"].findings[0].holds
    assert scaling_figures.scale_table(2)[2] < 0.51
    assert rolled["rolling-table-1"].data[0] == {
        "quantity": "length",
        "values": [1 / 4, 1 / 7, 1 / 10, 1 / 13, 1 / 16, 1 / 19],
    }


def test_the_index_shows_every_picture_once(made):
    text = gallery({n: (reproductions()[n], m, 0.5) for n, m in made.items()}, {"symfric": "0.1.0"})
    page = xml.dom.minidom.parseString(
        text.replace("<!DOCTYPE html>", "")
        .replace('<meta charset="utf-8">', "")
        .replace('<meta name="viewport" content="width=device-width, initial-scale=1">', "")
        .replace('loading="lazy">', 'loading="lazy"/>')
        .replace("class=n", 'class="n"')
    )
    counts = [
        r.getElementsByTagName("td") for r in page.getElementsByTagName("table")[0].getElementsByTagName("tr")[1:]
    ]
    numbers = [[int(c.getElementsByTagName("span")[0].firstChild.data) for c in row[1:]] for row in counts]
    assert numbers[-1] == [sum(column) for column in zip(*numbers[:-1], strict=True)]
    assert numbers[-1][:3] == [[v for m in made.values() for v in verdicts(m)].count(v) for v in (True, False, None)]
    shown = [i.getAttribute("src") for i in page.getElementsByTagName("img")]
    assert shown == [f"{n}.png" for n in made]
    assert all(reason in text for n, reason in NOT_MADE.items() if n.startswith(("thomsen", "handbook")))


def test_one_figure_by_the_command(tmp_path):
    done = CliRunner().invoke(main, ["reproduce", "thomsen-1", "rolling-table-1", "-o", str(tmp_path)])
    assert done.exit_code == 0, done.output
    assert {p.name for p in Path(tmp_path).iterdir()} == {
        "thomsen-1.png",
        "rolling-table-1.txt",
        "rolling-table-1.json",
        "index.html",
    }
    assert "0.25" in done.stdout
