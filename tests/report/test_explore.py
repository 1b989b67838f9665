"""The explorer: right numbers, within a tenth of a second, and a page that follows its sliders."""

import re
import signal
import socket
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from click.testing import CliRunner

import symfric as sf
from symfric.cli import main
from symfric.report.explorer.views import explorer
from symfric.scenefile import read_scene_file, read_scene_text
from symfric.scenefile.starters import starter
from symfric.scenefile.writing import read_tables, with_friction_values, written
from tests.browser import chromium, complaints, overflow, serious_findings, show
from tests.longer import longer

EXAMPLES = Path(__file__).parents[2] / "examples"
PROGRAM = "from symfric.cli import main; main(prog_name='symfric')"


@pytest.fixture(scope="module")
def belt():
    return explorer(read_scene_file(EXAMPLES / "belt.toml"))


def values_of(found, **changed):
    return {r.name: r.value for r in found.ranges} | changed


def test_numbers_are_those_of_the_solver(belt):
    values = values_of(belt)
    view = belt.view(values)
    assert np.max(view.x) == pytest.approx(0.5664694667, abs=1e-4)
    assert view.status == ""
    assert belt.half_range(values, 0.2) == pytest.approx(0.286208719, rel=1e-4)
    law = sf.laws.cubic(0.4, 0.25, 0.5)
    assert view.friction == pytest.approx(law(view.speed), rel=1e-12)
    assert np.all(np.isnan(view.effective))
    shaken = belt.view(values_of(belt, a=0.01, Omega=50.0))
    assert np.ptp(shaken.x) == pytest.approx(0.02, rel=0.05)
    assert belt.half_range(values_of(belt, a=0.01, Omega=50.0), 0.2) == pytest.approx(0.01, rel=1e-3)
    assert shaken.effective == pytest.approx(law.averaged(0.5)(view.speed), abs=0.01)


def test_the_diagram_grows_from_coarse_to_fine(belt):
    lots = list(belt.amplitudes(values_of(belt), 0.0))
    points = [p for lot in lots for p in lot]
    assert len(lots) > 10
    assert len(points) == 33
    assert sorted(v for v, _ in points) == pytest.approx(np.linspace(0.02, 0.46, 33))
    assert [v for v, _ in points[:3]] == pytest.approx([0.02, 0.46, 0.24])
    assert points[1][1] < 1e-3 < points[2][1]


def test_every_change_is_answered_within_a_tenth_of_a_second(belt):
    for changed in belt.ranges:
        for value in (changed.low, changed.high):
            values = values_of(belt, **{changed.name: value})
            begin = time.process_time()
            belt.view(values)
            next(belt.amplitudes(values, 0.03))
            assert time.process_time() - begin < 0.1


@pytest.mark.one_in(2)
@pytest.mark.parametrize("model", ["absorber", "coulomb_oscillator", "drive_stop"])
def test_scenes_without_a_belt_speed_are_answered_too(model):
    found = explorer(read_scene_text(starter(model)))
    assert found.swept == ""
    view = found.view(values_of(found))
    assert view.status == ""
    assert view.x.size > 10


def test_numbers_of_the_friction_law_are_sliders(belt):
    values = values_of(belt)
    assert (values["mu_s"], values["mu_m"], values["v_m"]) == (0.4, 0.25, 0.5)
    even = belt.view(values_of(belt, mu_m=0.4))
    assert even.friction == pytest.approx(0.4)
    run = sf.simulate(sf.scenes.mass_on_belt(sf.laws.cubic(0.4, 0.25, 0.3), v_b=0.2), tolerance=1e-7)
    assert np.max(belt.view(values_of(belt, v_m=0.3)).x) == pytest.approx(np.max(run.x[0]), abs=1e-3)


def test_sticking_is_where_the_body_moves_with_the_belt(belt):
    view = belt.view(values_of(belt))
    assert 0.1 < np.mean(view.held) < 0.4
    assert view.u[view.held] == pytest.approx(0.2, abs=1e-6)


def test_a_start_changes_the_motion(belt):
    view = belt.view(values_of(belt), {"x": 0.3, "u": -0.1})
    assert (view.x[0], view.u[0]) == pytest.approx((0.3, -0.1))
    assert belt.half_range(values_of(belt), 0.2, {"x": 0.3, "u": -0.1}) == pytest.approx(0.286208719, rel=1e-4)


@pytest.fixture(scope="module")
def two():
    """The page of a scene with two coordinates and two contacts, without a browser."""
    pytest.importorskip("bokeh", reason="bokeh is not installed: pip install '.[explore]'")
    from bokeh.document import Document

    from symfric.report.explorer.page import page

    doc = Document()
    page(explorer(read_scene_file(EXAMPLES / "two_masses.toml")))(doc)
    return doc.get_model_by_name


def test_a_coordinate_and_a_contact_are_chosen(two):
    first, law = two("history").data["y"], two("law").data["y"]
    two("coordinate").value, two("contact").value = "x2", "second"
    assert two("phase portrait").xaxis[0].axis_label.text == "x2"
    assert np.max(np.abs(two("history").data["y"] - first)) > 0.1
    assert np.max(np.abs(two("law").data["y"] - law)) > 0.01
    held = two("stuck").data["y"]
    assert 0 < np.isfinite(held).sum() < held.size
    two("coordinate").value, two("contact").value = "x1", "first"


@pytest.mark.one_in(4)
@pytest.mark.parametrize(("changed", "words"), [({"m": -1.0}, "mass"), ({"m": 0.0}, "mass"), ({"N": -1.0}, "negative")])
def test_an_impossible_number_is_refused_in_words(tmp_path, changed, words):
    file = tmp_path / "own.toml"
    file.write_text(starter("own"))
    found = explorer(read_scene_file(file))
    view = found.view(values_of(found, **changed))
    assert words in view.status
    assert view.x.size == 0
    assert view.speed.size  # the law is drawn all the same
    assert np.isnan(found.half_range(values_of(found, **changed), 0.1))


def test_a_number_beyond_its_slider_is_taken_and_reset(two):
    slider, entry, before = two("m1"), two("number of m1"), two("history").data["y"]
    end = slider.end
    entry.value = 7.5
    assert (slider.value, slider.end) == (7.5, 7.5)
    assert two("history").data["y"].size != before.size or np.max(np.abs(two("history").data["y"] - before)) > 0.01
    slider.value = 2.0
    assert entry.value == 2.0
    two("start of x1").value = 0.25
    assert two("history").data["y"][0] == 0.25
    press(two("reset"))
    assert (slider.value, slider.end, entry.value, two("number of start of x1").value) == (1.0, end, 1.0, 0.0)
    assert two("history").data["y"] == pytest.approx(before)


def test_curves_are_kept_for_comparison(two):
    """Two settings beside each other; the legend names what is there and nothing else."""

    def named(figure):
        return {str(entry.label.value) for entry in two(figure).legend[0].items if entry.visible}

    assert named("phase portrait") == {"sticking"}
    assert named("friction") == {"law"}  # no fast excitation
    first = two("history").data["y"]
    two("compare").active = True
    two("m1").value = 2.0
    assert two("before history").data["y"] == pytest.approx(first)
    assert two("before amplitude").data["x"].size > 0
    assert np.max(np.abs(two("history").data["y"][:100] - first[:100])) > 1e-3
    assert named("phase portrait") == {"sticking", "before", "sticking, before"}
    two("compare").active = False
    assert two("before history").data["y"].size == 0
    assert named("phase portrait") == {"sticking"}
    press(two("reset"))


def test_sliders_move_in_round_numbers(belt, two):
    for r in (*belt.ranges, *belt.starts):
        assert f"{r.step:.6e}"[:8] in ("1.000000", "2.000000", "5.000000"), r
        assert r.low <= r.value <= r.high
        for end in {r.low, r.high} - {r.value}:
            assert end / r.step == pytest.approx(round(end / r.step), abs=1e-9)
            assert len(f"{end:.12g}") < 8
        assert 80 <= (r.high - r.low) / r.step <= 201
    assert two("m1").step == 0.02


def test_errors_of_the_motion_do_not_fill_a_figure(two):
    """The least height of a figure is far above what settling leaves, and far below the motion."""
    for shown in (two("motion"), two("phase portrait")):
        assert 1e-5 < shown.y_range.min_interval < 0.01


def test_a_page_from_python_is_served_until_it_is_stopped():
    pytest.importorskip("bokeh", reason="bokeh is not installed: pip install '.[explore]'")
    page = sf.explore(sf.read(EXAMPLES / "belt.toml"), height=500)
    port = int(page.address.rstrip("/").rpartition(":")[2])
    assert answer_to(port, "/", f"Host: localhost:{port}")[0] == 200
    assert answer_to(port, "/", "Host: evil.example")[0] == 403
    assert page.address in page._repr_html_()
    with pytest.raises(sf.SceneError, match=f"port {port} cannot be used: .* with port="):
        sf.explore(sf.scenes.mass_on_belt(v_b=0.2), port=port)
    page.stop()
    wait(lambda: not taken(port))
    x, u = sp.symbols("x u", real=True)
    unchangeable = sf.Scene(sf.System([x], [u], [[1]], [-x]), [], {}, {x: 1.0, u: 0.0}, 1.0)
    with pytest.raises(sf.SceneError, match="no values to change"):
        sf.explore(unchangeable)


def taken(port: int) -> bool:
    """Return whether something listens on a port of this machine."""
    with socket.socket() as tried:
        return tried.connect_ex(("127.0.0.1", port)) == 0


def press(button) -> None:
    """Do what a click does."""
    from bokeh.events import ButtonClick

    button._trigger_event(ButtonClick(button))


def test_what_is_explored_is_saved_as_a_scene_file(belt):
    text = belt.toml(values_of(belt, v_b=0.3, mu_m=0.2), {"x": 0.1, "u": 0.0})
    file = read_scene_text(text)
    assert {s.name: v for s, v in file.scene.values.items()} | {"v_b": 0.3, "mu_m": 0.2, "mu_s": 0.4} == {
        s.name: v for s, v in file.scene.values.items()
    }
    assert [float(v) for v in file.scene.initial.values()] == [0.1, 0.0]
    assert file.sweep.parameter == "v_b"
    shown = sf.simulate(file.scene.wanting({"path": sf.Trajectory()}))
    view = belt.view(values_of(belt, v_b=0.3, mu_m=0.2), {"x": 0.1, "u": 0.0})
    assert np.max(view.x) == pytest.approx(np.max(shown(view.t)[0]), abs=1e-4)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda p: p.stem)
def test_a_file_is_written_as_it_was_read(path):
    tables = tomllib.loads(path.read_text(encoding="utf-8"))
    assert tomllib.loads(written(tables)) == tables
    opened = with_friction_values(tables, str(path))
    names = {k for c in opened.get("friction", {}) for k in ([c] if isinstance(c, str) else c)}
    before, after = read_scene_file(path).scene, read_tables(opened, str(path)).scene
    assert len(after.values) >= len(before.values)
    for one, other in zip(before.contacts, after.contacts, strict=True):
        numbers = [law.kinetic.subs(s.values) for law, s in ((one.law, before), (other.law, after))]
        assert all(
            numbers[0].subs(sf.SPEED, v) == pytest.approx(numbers[1].subs(sf.SPEED, v)) for v in (0.01, 0.3, 2.0)
        )
    assert names or before.values == after.values


def test_a_number_that_must_be_one_stays_one():
    """The count of an Iwan model's elements is no value; what the law takes as a symbol is, under a free name."""
    text = (
        '[scene]\ncoordinates = "x"\nvelocities = "u"\nmass = 1\nforce = "-R*x"\nhorizon = 9\n'
        "initial = {x = 1, u = 0}\n[values]\nR = 3\n"
        '[friction]\nlaw = "iwan"\nslip = "u"\nnormal = 1\nR = 0.2\nchi = 0.5\nphi_max = 0.1\nelements = 4\n'
    )
    opened = with_friction_values(tomllib.loads(text), "scene.toml")
    assert opened["values"] == {"R": 3, "R_2": 0.2, "chi": 0.5, "phi_max": 0.1}
    assert opened["friction"]["elements"] == 4


def test_a_scene_without_values_is_refused():
    text = (
        '[scene]\ncoordinates = "x"\nvelocities = "u"\nmass = 1\nforce = "-x"\nhorizon = 9\ninitial = {x = 1, u = 0}\n'
    )
    with pytest.raises(sf.SceneError, match="no values to change"):
        explorer(read_scene_text(text))


@pytest.fixture(scope="module")
def served():
    """The command itself, on any free port; ended by Ctrl-C."""
    pytest.importorskip("bokeh", reason="bokeh is not installed: pip install '.[explore]'")
    command = [sys.executable, "-c", PROGRAM, "explore", str(EXAMPLES / "belt.toml")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            yield process.stdout.readline().split()[0]
            process.send_signal(signal.SIGINT)
            assert process.wait(30) == 0
            assert "Traceback" not in process.stderr.read()
        finally:
            process.kill()


def test_an_interrupt_that_falls_into_a_callback_is_not_lost():
    serving = """if True:
        import contextlib, os, signal, time
        from tornado.ioloop import IOLoop
        from symfric.report.explorer.server import serve
        def interrupted():
            with contextlib.suppress(KeyboardInterrupt):  # as compiled code does that calls back
                os.kill(os.getpid(), signal.SIGINT)
                time.sleep(0.01)
        serve(lambda doc: None, 0, lambda address: IOLoop.current().add_callback(interrupted))
        print("ended")
    """
    pytest.importorskip("bokeh", reason="bokeh is not installed: pip install '.[explore]'")
    done = subprocess.run([sys.executable, "-c", serving], capture_output=True, text=True, timeout=60)
    assert (done.stdout.strip(), done.stderr) == ("ended", "")


PATHS = ("/", "/static/js/bokeh.min.js", "/static/extensions/none.js", "/ws", "/autoload.js", "/metadata", "/none")


def answer_to(port: int, path: str, *headers: str, method: str = "GET", http: str = "1.1") -> tuple[int, str]:
    """Return the status of a request with these headers, and its answer."""
    lines = [f"{method} {path} HTTP/{http}", *headers, "Connection: close", "Content-Length: 0", "", ""]
    with socket.create_connection(("127.0.0.1", port), timeout=30) as connection:
        connection.sendall("\r\n".join(lines).encode())
        text = b"".join(iter(lambda: connection.recv(65536), b"")).decode("latin-1")
    return int(text.split()[1]), text


@pytest.mark.parametrize("path", PATHS)
def test_other_hosts_and_origins_are_refused_whatever_the_path(served, path):
    port = int(served.rstrip("/").rpartition(":")[2])
    own = f"Host: localhost:{port}"
    foreign = [
        f"Host: evil.example:{port}",
        "Host: evil.example",
        f"Host: localhost.evil.example:{port}",
        f"Host: evil.example@localhost:{port}",
        f"Host: localhost:{port}.evil.example",
        f"Host: localhost:{port + 1}",
        "Host: localhost",
        "Host:",
        f"Host: 0.0.0.0:{port}",
        f"Host: [::ffff:127.0.0.1]:{port}",
    ]
    for host in foreign:
        for method in ("GET", "POST", "OPTIONS", "HEAD"):
            status, text = answer_to(port, path, host, method=method)
            assert status in (400, 403), host  # 400: not even a host
            assert "evil" not in text
    assert answer_to(port, path, f"Host: evil.example:{port}", own)[0] in (400, 403)
    assert answer_to(port, path, http="1.0")[0] in (400, 403)
    assert answer_to(port, f"http://localhost:{port}{path}", f"Host: evil.example:{port}")[0] == 403
    for origin in (
        f"http://evil.example:{port}",
        "http://evil.example",
        "null",
        f"https://localhost:{port}",
        f"http://localhost:{port + 1}",
        f"http://localhost:{port}@evil.example",
        f"file://localhost:{port}",
        "",
    ):
        assert answer_to(port, path, own, f"Origin: {origin}")[0] == 403, origin
    origins = (), (f"Origin: http://localhost:{port}",), (f"Origin: http://127.0.0.1:{port}",)
    for host, origin in zip((own, f"Host: 127.0.0.1:{port}", f"HOST: LOCALHOST:{port}"), origins, strict=True):
        assert answer_to(port, path, host, *origin)[0] != 403 or path == "/ws"


def test_the_socket_opens_for_its_own_page_only(served):
    """A hand shake as a browser makes it; what follows needs the token that is on the page."""
    port = int(served.rstrip("/").rpartition(":")[2])
    page = answer_to(port, "/", f"Host: localhost:{port}")[1]
    token = re.search(r'"token":"([^"]+)"', page)[1]
    shake = ("Upgrade: websocket", "Connection: Upgrade", "Sec-WebSocket-Key: c3ltZnJpYyBzeW1mcmljIQ==")
    shake += ("Sec-WebSocket-Version: 13", f"Sec-WebSocket-Protocol: bokeh, {token}")
    for host, origin, status in (
        ("localhost", f"http://localhost:{port}", 101),
        ("127.0.0.1", f"http://127.0.0.1:{port}", 101),
        ("localhost", f"http://evil.example:{port}", 403),
        ("evil.example", f"http://evil.example:{port}", 403),
        ("evil.example", f"http://localhost:{port}", 403),
    ):
        lines = ["GET /ws HTTP/1.1", f"Host: {host}:{port}", f"Origin: {origin}", *shake, "", ""]
        with socket.create_connection(("127.0.0.1", port), timeout=30) as connection:
            connection.sendall("\r\n".join(lines).encode())
            assert int(connection.recv(4096).split()[1]) == status, (host, origin)


def model(name: str) -> str:
    return f"Bokeh.documents[0].get_model_by_name('{name}')"


def test_a_moved_slider_changes_the_pictures(served):
    assert served.startswith("http://localhost:")
    browser = chromium()
    try:
        show(browser, served, 1400)
        wait(lambda: "answered" in said(browser))
        before = browser.get_screenshot_as_base64(), shown(browser)
        browser.execute_script(f"{model('v_b')}.value = 0.35;")
        wait(lambda: shown(browser) != before[1])
        time.sleep(1.0)
        assert browser.get_screenshot_as_base64() != before[0]
        assert float(said(browser).split()[2]) > 0  # its time in milliseconds
        assert overflow(browser) <= 0
        assert width(browser) > 700
        assert [line for line in complaints(browser) if "favicon" not in line] == []
    finally:
        browser.quit()


@pytest.mark.long(beside="test_a_moved_slider_changes_the_pictures")
def test_the_page_fits_a_narrow_window(served):
    browser = chromium()
    try:
        show(browser, served, 400)
        wait(lambda: "answered" in said(browser))
        assert overflow(browser) <= 0
        assert 300 < width(browser) < 400
        assert [line for line in complaints(browser) if "favicon" not in line] == []
    finally:
        browser.quit()


@pytest.mark.parametrize("theme", longer(["light", "dark"], ["dark"]))
def test_the_page_speaks_to_those_who_do_not_see_it(served, theme):
    """Every slider, number and menu has a name, also after its range has changed; axe-core finds nothing serious."""
    browser = chromium()
    try:
        show(browser, served, 1400, theme=theme)
        wait(lambda: "answered" in said(browser) and spoken(browser))
        browser.execute_script(f"{model('number of v_b')}.value = 17.0;")
        wait(lambda: browser.execute_script(f"return {model('v_b')}.end") == 17.0)
        names = spoken(browser)
        assert None not in names
        assert {"v_b", "number of v_b"} <= set(names)
        assert serious_findings(browser) == []
    finally:
        browser.quit()


def spoken(browser) -> list[str | None]:
    """Return the names of all fields of the page."""
    return browser.execute_script("""
        const found = [];
        const visit = (view) => {
          for (const field of view.shadow_el ? view.shadow_el.querySelectorAll("[role=slider], input, select") : [])
            found.push(field.getAttribute("aria-label"));
          for (const child of view.children()) visit(child);
        };
        [...Bokeh.index.roots].forEach(visit);
        return found.some((name) => name) ? found : [];
    """)


def said(browser) -> str:
    return browser.execute_script(f"return window.Bokeh && Bokeh.documents[0] ? {model('note')}.text : ''")


def shown(browser) -> list[float]:
    """Return the first speeds of the motion that the page holds."""
    return browser.execute_script(f"return Array.from({model('phase')}.data.y.slice(0, 900))")


def width(browser) -> int:
    return browser.execute_script(f"return {model('phase portrait')}.outer_width")


def wait(ready, seconds: float = 30.0) -> None:
    end = time.monotonic() + seconds
    while not ready():
        assert time.monotonic() < end, "the page does not answer"
        time.sleep(0.1)


def test_a_taken_port_is_one_line():
    pytest.importorskip("bokeh", reason="bokeh is not installed: pip install '.[explore]'")
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        done = CliRunner().invoke(main, ["explore", str(EXAMPLES / "belt.toml"), "-q", "--port", str(port)])
    assert done.exit_code == 2
    assert done.stderr == f"Error: port {port} cannot be used: it is taken or not allowed; name another with --port\n"


def test_without_bokeh_the_cure_is_named(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda _name: None)
    done = CliRunner().invoke(main, ["explore", str(EXAMPLES / "belt.toml")])
    assert done.exit_code == 2
    assert done.stderr.endswith("install it with: python -m pip install 'symfric[explore]'\n")
