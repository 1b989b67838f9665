"""Examples answer their question: short, run as they are, with the numbers they are known to give."""

import ast
import itertools
import re
import runpy
import tomllib
from pathlib import Path

import pytest

from docs import founded, kept
from symfric.solve.lanes import model as lanes
from tests.longer import longer
from tests.test_layers import LINES

FOLDER = Path(__file__).parents[1] / "examples"
SCRIPTS = {
    "absorber_on_brake": r"grows at (114\.810) 1/s, closed form \1(.|\n)*it decays at \d",
    "blade_friction_damper": r"N = 0\.67\d is best \(optimal\)",
    "block_in_earthquake": r"0\.2 g: stands still(.|\n)*0\.4 g: tilts(.|\n)*0\.8 g: falls over",
    "block_on_incline": r"stops after (0\.3576519144) s, closed form \1 s\n11\.1766 cm across \(11\.1766\), 5\.9609 cm down \(5\.9609\)(.|\n)*at 0\.500000 m/s",
    "bouncing_ball": r"after 4\.0637128 s and \d\d impacts, closed form 4\.0637128 s(.|\n)*product (0\.368266205), closed form \2",
    "brake_fourteen_coordinates": r"mu = (0\.7144737): (.*)closed form \1 \(waves: 0\)(.|\n)*mu = (1\.2309695): (.*)closed form \4 \(waves: 3\)",
    "brake_groan_speed": r"below (193\.1325) mm/s, closed form \1 mm/s, at 159 Hz",
    "brake_shaken_by_its_speed": r"at 0\.20 m/s the brake keeps 21 %, or 78 %(.|\n)*\nshaken, at 0\.3 m/s: slow vibration of 0\.0",
    "brake_two_modes": r"mu = (0\.714689651) on, at omega = (1\.402378931)\nclosed form mu = \1, omega = \2(.|\n)*mu = 1: moves by \+-0\.1\d",
    "building_on_rollers": r"even floor: 0\.0\d+ g instead of 0\.32 g",
    "cam_lift_off": r"above 540 rpm without damping(.|\n)*above 539 rpm",
    "clutch_judder": r"below (10\.397208) rad/s, closed form \1(.|\n)*first at a slip of 0\.91 rad/s, 10 times",
    "decay_record": r"the oil takes most, 38 %",
    "disc_brake_squeal": r"squeals from mu = 0\.4193",
    "door_hinge_shaken": r"intensity 0\.3600",
    "drill_string": r"120 rpm: the bit reaches (248\.3040) rpm; closed form \1\n +sticks (0\.67296) of (5\.61670) s; closed form \2 of \3",
    "earthquake_fault": r"k = (505\.000000), published \1(.|\n)*k = (7000\.000000), published \3",
    "feeder_in_the_plane": r"tilt 1 deg: 1\.757 mm/s at 50 Hz, 1\.742 at 100 Hz, closed form 1\.737",
    "follower_force": r"P l/k = (2\.085786438), Ziegler \1(.|\n)*0\.1: (1\.469285714), Herrmann and Jong \3",
    "friction_compensated": r"1\.16 N: rests 5\.39 mm off(.|\n)*1\.18 N: shakes by \+-(5\.7342) mm, closed form \2(.|\n)*compensate 1\.1703 N",
    "gear_two_slopes": r"corner at 2\.0\d m/s \+- 0\.0\d(.|\n)*0\.5 m/s: chatters, growth rate (\+10\.4363) 1/s, closed form \2(.|\n)*stable there: True",
    "isolator_in_two_directions": r"along x (0\.11236) m, of the vector \1 m\n(.*)along x 0\.08917 m(.*)\n(.*)closed form \1 m",
    "lathe_chatter": r"turn of 5: chatters from K = 0\.1145\d, closed form 0\.11446(.|\n)*K = 0\.12: (.*) stays in the work\nK = 0\.3: (.*) leaves the work",
    "machine_slide_damping": r"damping ratio 0\.0570",
    "pad_lift_off": r"-3\.0: (.*) stays on(.*)\n(.*)-3\.4: (.*) lifts off",
    "part_on_conveyor": r"15\.45 Hz: 0 flights(.|\n)*leaves the track above 15\.76 Hz",
    "positioning_table": r"stops (\d+\.\d+) um beyond \(type a\)(.|\n)* says \1 um",
    "rig_in_real_time": r"under 300 N, and by \+-2 um under 77 N",
    "rig_law_from_record": r"Stribeck's, with v_s between 4\d and 6\d mm/s",
    "robot_joint": r"needs 0\.50 N m to break away and yields 1 mrad under 0\.40 N m",
    "rocking_block_free": r"keeps (0\.94080) of its speed, Housner \1(.|\n)*0\.6587 s, slender 0\.6585 s; keeps (0\.98505) of its speed, Housner \3",
    "rod_turning_points": r"friction 0\.190, damping ratio 0\.0090",
    "seat_rail_rattle": r"4\.99 m/s2: rests\n5\.01 m/s2: slides(.|\n)*22 m/s2: strikes with (0\.2153269) m/s, closed form \2",
    "sliding_puck": r"40 rad/s: (.*) = 0\.6530\nclosed form 0\.653002",
    "sorter_in_the_plane": r"after (0\.652714) s, (0\.391628) m(.|\n)*closed form: \1 s, \2 m",
    "stage_hunting": r"hunts (96\.251) mm about the target every (49\.356) s; computed \1 mm, \2 s",
    "stop_grazing": r"touches at F = 0\.368782(.|\n)*an impact every 2\.00 periods",
    "stopping_ramp": r"stopped over 20\.\d ms: 6\.6 um",
    "string_on_belt": r"10 modes: 109\.45 Hz, slips for 0\.2016(.|\n)*30 modes: 109\.8\d Hz, slips for 0\.15\d\d(.|\n)*Helmholtz: 110\.00 Hz, slips for 0\.1300",
    "table_on_three_feet": r"0\.6: moves at (5\.878377) m/s2, by the least work at \1\n(.*) turned by -?0\.000 degrees\n(.*) at (4\.840715) m/s2, by the least work at \4\n(.*)turned by -0\.314",
    "vibration_across": r"r = 1: (0\.83463) of the friction is left, closed form \1",
    "violin_bow": r"0\.4 m/s: sticks and slips 35\d",
    "which_parameter_matters": r"Most of the scatter comes from mu_s",
    "wiper_law": r"quiet above (0\.450548) m/s, closed form \1",
    "wire_rope_isolator": r"8\.0 Hz: (.*) feels 0\.628 of the deck; dissipates (0\.3469516) J a cycle, closed form \2",
}

NEEDS = {"which_parameter_matters": "SALib"}


PAGES = [FOLDER.parent / "README.md", FOLDER.parent / "docs" / "start" / "tour.md"]
BLOCKS = [b for p in PAGES for b in re.findall(r"```python\n(.*?)```", p.read_text(encoding="utf-8"), re.DOTALL)]
MISSING = "RSN753_LOMAP_CLS000.AT2"  # a record that is not ours to give


NUMBER = r"-?\d+(?:\.\d+(?:e-?\d+)?|e-?\d+)"  # with a point or an exponent


def unlike(value, comment):
    """Return the numbers of a comment that do not occur in what a value prints: to the last digit, or to ``...``."""
    shown = repr(value) + (repr(value.to_dict()) if hasattr(value, "to_dict") else "")
    printed = re.findall(NUMBER, shown)

    def occurs(said, dots):
        if dots:
            return any(p.startswith(said) for p in printed)
        digits = len(said.split("e")[0].partition(".")[2])
        form = f".{digits}{'e' if 'e' in said else 'f'}"
        return any(float(f"{float(p):{form}}") == float(said) for p in printed)

    wrong = [said + dots for said, dots in re.findall(rf"({NUMBER})(\.\.\.)?", comment) if not occurs(said, dots)]
    counts = {float(n) for n in re.findall(r"\d+(?:\.\d+)?", shown)}
    whole = re.findall(r"(?<![\w.(^-])\d\d+(?![\w.]*\d|\w| ?nano)", re.sub(NUMBER, "", comment))
    shares = {n for n in whole if re.search(rf"{n} %", comment)}
    wrong += [n for n in whole if n not in shares and float(n) not in counts]
    return wrong + [f"{n} %" for n in shares if not any(round(100 * c) == int(n) or round(c) == int(n) for c in counts)]


def test_numbers_are_compared_to_their_last_digit():
    assert unlike(1.8594, "1.859..., 1.86, a speed") == []
    assert unlike(1.8594, "1.8584... and 1.87") == ["1.8584...", "1.87"]
    assert unlike({"a": -3.9e-11}, "-4e-11: an error, of 2 kinds") == []
    assert unlike("-0.13912", "margin -0.139; 0.14") == ["0.14"]
    assert unlike("28 events, 0.853", "28 events, 85 %") == []
    assert unlike("28 events, 0.853", "27 events, 86 %") == ["27", "86 %"]


SENTENCES = {  # what pages say of numbers of the program itself
    "README.md": [(r"Python (3\.\d+) or newer", lambda: _project()["requires-python"].removeprefix(">="))],
    "docs/start/install.md": [(r"Python (3\.\d+) or newer", lambda: _project()["requires-python"].removeprefix(">="))],
    "docs/start/tour.md": [(r"Series of more than (\d+) operations", lambda: str(lanes._LONGEST))],
    "docs/contributing.md": [(r"at most (\d+) lines", lambda: str(LINES))],
}


def _project():
    return tomllib.loads((FOLDER.parent / "pyproject.toml").read_text(encoding="utf-8"))["project"]


@pytest.mark.parametrize("page", SENTENCES)
def test_sentences_agree_with_the_program(page):
    text = (FOLDER.parent / page).read_text(encoding="utf-8")
    for said, is_so in SENTENCES[page]:
        assert re.findall(said, text) == [is_so()], said


def test_times_of_the_landing_page_are_those_of_the_benchmarks():
    index, benchmarks = (
        (FOLDER.parent / "docs" / f"{n}.md").read_text(encoding="utf-8") for n in ("index", "benchmarks")
    )
    rows = re.findall(r"\| (.*?)(?: on a belt|), (\d+) events, to 1e-10 \| ([\d.]+) ms \| ([\d.]+) ms", index)
    assert len(rows) == 2
    for name, events, own, scipy in rows:
        (row,) = re.findall(rf"\| {name}.*, {events} events \|(.*)\|", benchmarks)
        cells = [cell.strip() for cell in row.split("|")]
        assert (cells[0], cells[4]) == (own, scipy)


def test_a_number_of_a_page_that_no_cell_prints_is_found():
    known = founded.values("0.35991 1.2e-03 159.155 68300 0.117 0.05")
    assert founded.unfounded(["0.36, 1.2e-3, at 159 Hz in 68 300 cases, 12 % of 50 mm; 3 ways"], known) == []
    assert founded.unfounded(["0.37, 1.3e-3, 158 Hz, 13 %"], known) == ["0.37", "1.3e-3", "158", "13"]


def test_pages_are_made_anew_where_what_they_are_made_with_has_changed(tmp_path, monkeypatch):
    """A script of the examples is of its own page; their data and the program may be of any."""
    monkeypatch.setattr(kept, "ROOT", tmp_path)

    def keys():
        kept.sources_key.cache_clear()
        return kept.sources_key(), kept.sources_key("examples", scripts=False), kept.sources_key("examples")

    seen = [keys()]
    for name in ("examples/new.py", "examples/record.csv", "symfric/new.py"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("1\n", encoding="utf-8")
        seen.append(keys())
    kept.sources_key.cache_clear()
    changed = [tuple(a != b for a, b in zip(one, other, strict=True)) for one, other in itertools.pairwise(seen)]
    assert changed == [(False, False, True), (False, True, True), (True, True, True)]


@pytest.fixture(scope="module")
def shell():
    """Return the names that the blocks of the README and of the tour share, as in one session."""
    return {}


def results(block):
    """Return the code before each expression on a line of its own, the expression, and the comment behind it."""
    tree = ast.parse(block)
    lines, begin = block.splitlines(), 0
    for node in tree.body:
        code = "\n".join(lines[begin : node.end_lineno])
        comment = lines[node.end_lineno - 1].partition("  # ")[2]
        if node.end_lineno < len(lines) and lines[node.end_lineno].startswith("# "):
            comment += lines[node.end_lineno]
        yield code, isinstance(node, ast.Expr), comment
        begin = node.end_lineno


# statements of half a second and more whose names no other block takes; other tests of what they call run by default
COSTLY_CALLS = (
    "sf.design.quench(belt, speeds=(0.1, 0.4)",
    "sf.design.quench(belt, (0.1, 0.4), Omega=(20, 60), a=(0, 0.05), limits=brake)",
    "sf.design.quench(belt, (0.05, 0.4), Omega=(50, 60), a=(0, 0.02), follow=True",
    'sf.design.positioning(slide, "sigma"',
    'drive.two_slides_threshold(**pair, damping="omega2")',
    "drive.two_slides_cycle(**pair, fs1=7.8)",
    'sf.continue_cycle(belt, "v_b", (0.05, 6), start=',
    "sf.design.sprung_foundation(0.1)",
    'sf.design.positioning(table, "ramp"',
    'sf.design.controller(pid, "k_i"',
    "move = sf.design.collocation(block",
    "move.time",
    'sf.design.damper(belt, "beta", bounds=(0, 1), speeds=(0.1, 0.45))',
    'sf.design.damper(belt, "beta", (0.01, 1), (0.05, 0.45), half_range=0.2)',
    'sf.design.contact_damper(rod, {"f_n": (4, 9), "mu_m": (0.05, 0.2)}, margin=0.05)',
    "motions = [sf.motions.synthetic(",
    "building = sf.scenes.rolling_isolator(C=1e5, m=3e5, motion=motions[0]",
    "sf.design.isolator(building, motions",
    "found = sf.basins(bistable",
    "found.attractors",
    "found.shares",
    "sf.lyapunov(shaken)",
)


def check_block(block, shell, left_out=()):
    """Run the statements of a block but those that begin with one of `left_out`; compare what they print."""
    for code, is_expression, comment in results(block):
        if code.strip().startswith(left_out):
            continue
        if is_expression:
            value = eval(code.strip(), shell)
            assert unlike(value, comment) == [], f"{code} is {value!r}"
        else:
            exec(code, shell)


@pytest.mark.parametrize("number", range(len(BLOCKS)))
def test_blocks_of_the_readme_and_the_tour_run_and_print_what_they_say(number, shell, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # some write files
    if MISSING in BLOCKS[number]:
        pytest.skip("needs a record of others")
    check_block(BLOCKS[number], shell, COSTLY_CALLS)


@pytest.mark.long(beside="test_blocks_of_the_readme_and_the_tour_run_and_print_what_they_say")
def test_costly_calls_of_the_readme_and_the_tour_print_what_they_say(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shell = {}
    for block in BLOCKS:
        if MISSING not in block:
            check_block(block, shell)


def test_calls_that_are_left_out_are_there():
    statements = [code.strip() for block in BLOCKS for code, _, _ in results(block)]
    assert [call for call in COSTLY_CALLS if sum(s.startswith(call) for s in statements) != 1] == []


def test_every_script_is_listed():
    assert sorted(SCRIPTS) == sorted(p.stem for p in FOLDER.glob("*.py"))
    assert len(SCRIPTS) >= 8


# half a second and more; the documentation's gallery runs every script, too
COSTLY = [
    "blade_friction_damper",
    "block_in_earthquake",
    "block_on_incline",
    "brake_fourteen_coordinates",
    "brake_shaken_by_its_speed",
    "building_on_rollers",
    "cam_lift_off",
    "clutch_judder",
    "disc_brake_squeal",
    "earthquake_fault",
    "feeder_in_the_plane",
    "isolator_in_two_directions",
    "lathe_chatter",
    "rig_in_real_time",
    "rig_law_from_record",
    "robot_joint",
    "rocking_block_free",
    "seat_rail_rattle",
    "sliding_puck",
    "sorter_in_the_plane",
    "stage_hunting",
    "stop_grazing",
    "stopping_ramp",
    "string_on_belt",
    "table_on_three_feet",
    "wire_rope_isolator",
]


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", longer(SCRIPTS, COSTLY))
def test_a_script_answers_its_question(name, capsys):
    pytest.importorskip(NEEDS.get(name, "symfric"), reason="an extra that the example needs is not installed")
    path = FOLDER / f"{name}.py"
    assert len(path.read_text().splitlines()) < 60
    assert "?" in path.read_text().split('"""')[1].split("\n\n")[0]
    runpy.run_path(str(path), run_name="__main__")
    printed = capsys.readouterr().out
    assert re.search(SCRIPTS[name], printed), printed
    assert "nan" not in printed
