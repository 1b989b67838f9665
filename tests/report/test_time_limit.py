"""A study that would take too long: what is left out is said, and the rest is there."""

import re
import time

import numpy as np
import pytest
from click.testing import CliRunner

import symfric as sf
from symfric.cli import main
from symfric.report.study.study import study
from symfric.scenefile import read_scene_text
from symfric.scenefile.starters import starter
from symfric.time_limit import OutOfTime, check_time, time_limit, untimed


def changed(model, **values):
    text = starter(model)
    for name, value in values.items():
        text = re.sub(rf"(?m)^{name} = \S+", f"{name} = {value}", text)
    return text


def test_a_long_horizon_is_left_out_with_its_reason():
    found = study(read_scene_text(changed("wavy_belt", horizon="1e6")), limit=0.3)
    assert found.motion.value is None
    for part in ("motion", "steady vibration"):
        assert re.match(r"stopped after 0\.3 s; shorten the horizon, .* --limit$", found.skipped()[part])
    assert found.explanation.value is not None


def test_a_value_whose_rates_overflow(tmp_path):
    file = tmp_path / "huge.toml"
    file.write_text(changed("drive_stop", mu1="1e300"))
    result = CliRunner().invoke(main, ["study", str(file), "-q", "--limit", "2", "-o", str(tmp_path / "out")])
    assert result.exit_code == 0
    assert "NOT_FINITE" in (tmp_path / "out" / "study.html").read_text()


@pytest.mark.parametrize("seconds", ["0", "-1", "nan", "soon"])
def test_a_limit_is_a_positive_number(tmp_path, seconds):
    file = tmp_path / "belt.toml"
    file.write_text(starter("mass_on_belt"))
    result = CliRunner().invoke(main, ["study", str(file), "--limit", seconds])
    assert result.exit_code == 2
    assert not (tmp_path / "belt-study").exists()


def test_limits_are_nested_and_end_with_their_block():
    program = sf.prepare(sf.scenes.mass_on_belt(v_b=0.2).wanting({"end": sf.End()}))
    with pytest.raises(OutOfTime, match="stopped after 0 s"), time_limit(1e9), time_limit(0.0), time_limit(1e9):
        program.run()
    with pytest.raises(OutOfTime), time_limit(0.0):
        program.map({"v_b": np.linspace(0.1, 0.3, 5)})
    with time_limit(1e9):
        assert program.run().status == sf.Status.OK
    with time_limit(0.2):
        with untimed():
            begin = time.thread_time()
            while time.thread_time() - begin < 0.3:
                pass
        check_time()
    assert program.run().status == sf.Status.OK
