"""Examples answer their question: short, run as they are, with the numbers they are known to give."""

import re
import runpy
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[1] / "examples"
SCRIPTS = {
    "absorber_on_brake": r"it decays at \d",
    "brake_groan_speed": r"below 193\.\d mm/s, at 159 Hz",
    "building_on_rollers": r"even floor: 0\.0\d+ g instead of 0\.32 g",
    "door_hinge_shaken": r"intensity 0\.3600",
    "gear_two_slopes": r"stable there: True",
    "machine_slide_damping": r"damping ratio 0\.0570",
    "positioning_table": r"stops (\d+\.\d+) um beyond \(type a\)(.|\n)* says \1 um",
    "violin_bow": r"0\.4 m/s: sticks and slips 35\d",
    "wiper_law": r"quiet above 0\.451 m/s",
}


def test_the_tour_of_the_readme_prints_what_it_says():
    text = (FOLDER.parent / "README.md").read_text()
    first, second = re.findall(r"```python\n(.*?)```", text, re.DOTALL)[:2]
    names = {}
    exec(first.replace("run.plot()", ""), names)
    assert repr(names["run"]) in first
    assert f"{names['run']['x_max']:.6f}"[:7] in first
    exec(second, names)
    for line in second.splitlines()[1:]:
        call, _, said = line.partition("  # ")
        if said:
            said = said.split(",")[0].split("...")[0].split("(")[-1]
            assert said[:12] in repr(eval(call, names)), line
    assert (FOLDER.parent / "examples" / "amplitude.png").read_bytes().startswith(b"\x89PNG")


def test_every_script_is_listed():
    assert sorted(SCRIPTS) == sorted(p.stem for p in FOLDER.glob("*.py"))
    assert len(SCRIPTS) >= 8


@pytest.mark.parametrize("name", SCRIPTS)
def test_a_script_answers_its_question(name, capsys):
    path = FOLDER / f"{name}.py"
    assert len(path.read_text().splitlines()) < 60
    assert "?" in path.read_text().split('"""')[1].split("\n\n")[0]
    runpy.run_path(str(path), run_name="__main__")
    printed = capsys.readouterr().out
    assert re.search(SCRIPTS[name], printed), printed
    assert "nan" not in printed
