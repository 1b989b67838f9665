"""Pages of scenes whose texts are markup, TeX, templates, foreign letters or very long: they are shown as they are."""

import html
import re
import signal
import subprocess
import sys
import time
from html.parser import HTMLParser

import pytest
import sympy as sp
from matplotlib.figure import Figure

import symfric as sf
from symfric.model.notebook import html_table
from symfric.report.html.mathml import inline, to_mathml
from symfric.report.study.page import page
from symfric.report.study.study import study
from symfric.scenefile import read_scene_text
from symfric.templates import render
from symfric_evidence.sources import reproduction
from symfric_evidence.sources.gallery import gallery
from symfric_evidence.sources.registry import Entry, Finding, Made
from tests.browser import chromium, complaints, overflow, show
from tests.longer import longer

MARKS = (
    "<script>window.struck = 1</script>",
    "</title></style></script><script>window.struck = 2</script>",
    '<img src=x onerror="window.struck = 3">',
    '"onmouseover="window.struck = 4" a=\'',
    "'><svg onload=window.struck=5>",
    "&amp;<b>&lt;</b>&#60;",
    "$$x$$ \\(y\\) \\[z\\] <img src=x onerror=window.struck=6>",
    "{{ 7 * 7 }} {% raw %} {# #}",
    "中文 Ω é 🦀 detrever",
    "W" * 1000,
)
EVIL = " ".join(MARKS)
UNITS = ("m", "µm", "N·m/N", "m^3/m^2", "inch", "furlong")
NO_UNITS = (
    "<b>m</b>",
    '"onclick="s()',
    "<img onerror=s() src=x>",
    "$$x$$<img src=x onerror=s()>",
    "$\\evil{",
    "中 & 🦀",
)
NO_UNITS += ("m**9**9**9", "m^99999", "__import__('os')", "meter.__class__", "N/(m", "kgg", "m;s", "2", "0 m", "degC")


def quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def scene(evil: str, unit: str, design: str = "") -> str:
    return f"""
title = {quoted(evil)}
description = {quoted(evil)}
[scene]
coordinates = "x"
velocities = "u"
mass = 1
force = "-k*x - c*u"
horizon = 20
initial = {{x = 0, u = 0}}
[values]
k = 1
c = 0.05
v_b = 0.2
[friction]
name = {quoted(evil)}
law = "cubic"
mu_s = 0.4
mu_m = 0.25
v_m = 0.5
slip = "u - v_b"
normal = 1
[outputs]
{quoted(evil)} = "max(x)"
[units]
x = {quoted(unit)}
v_b = {quoted(unit + "/s")}
t = "s"
[sweep]
from = 0.1
to = 0.2
number = 2
settle = 20
window = 20
{design}"""


class Seen(HTMLParser):
    """Collects what a browser would: tags, attributes and words."""

    def __init__(self, text: str):
        super().__init__()
        self.tags, self.names, self.values, self.words = [], [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.names += [n for n, _ in attrs]
        self.values += [v for _, v in attrs if v]

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)

    def handle_data(self, data):
        self.words.append(data)


def is_harmless(text: str, times: int, mark: str = EVIL) -> Seen:
    """Check that a page shows a text so many times at least, and that it is nothing but text there."""
    seen = Seen(text)
    assert "script" not in seen.tags
    assert not [n for n in seen.names if n.startswith("on")]
    assert set(seen.tags) <= set(TAGS.split())
    assert sum(mark in w for w in seen.words) >= times
    return seen


TAGS = """
html head meta title style body h1 h2 h3 p div ul li table thead tbody tr th td figure img
figcaption footer code strong i sup a pre caption details summary span
math mi mo mn mrow msub msup msubsup mfrac mtext mspace mtable mtr mtd mover mfenced
"""


def made(name):
    """Return a study in one of the units, a reproduction, or the table of a notebook."""
    if name == "notebook":
        return html_table(EVIL, {EVIL: EVIL, "nested": {EVIL: [EVIL, 1.0]}})
    if name == "gallery":
        figure = Figure()
        figure.add_subplot().plot([0, 1])
        one = Made(figure, EVIL, None, (Finding(EVIL, EVIL, True),))
        names = list(reproduction.reproductions())[:1]
        return gallery({n: (Entry(EVIL, None), one, 0.1) for n in names}, {EVIL: EVIL, "symfric": EVIL})
    return page(study(read_scene_text(scene(EVIL, UNITS[int(name[-1])]), EVIL)))


STUDIES = [f"study-{k}" for k in range(len(UNITS))]


@pytest.fixture(scope="module", params=longer([*STUDIES, "gallery", "notebook"], STUDIES[1:]))
def written(request, tmp_path_factory):
    """Return the name of a page, and its file."""
    place = tmp_path_factory.mktemp("pages") / f"{request.param}.html"
    place.write_text(made(request.param), encoding="utf-8")
    return request.param, place


@pytest.mark.long(beside="test_mathematics_of_strange_names_is_text")
def test_texts_are_nothing_but_text(written):
    name, place = written
    text = place.read_text(encoding="utf-8")
    # a study: title twice, description, contact, output, file; and more in sentences
    seen = is_harmless(text, {"gallery": 5, "notebook": 4}.get(name, 6))
    if name.startswith("study"):
        unit = UNITS[int(name[-1])]
        assert unit in seen.words
        assert any(EVIL in v for v in seen.values)  # what is said of a picture


@pytest.mark.long(beside="test_mathematics_of_strange_names_is_text")
def test_errors_on_a_page_are_text():
    """What could not be answered is said with the reason, which quotes names."""
    text = scene(EVIL, "m").replace('force = "-k*x - c*u"', 'force = "k*x - c*u"')
    is_harmless(page(study(read_scene_text(text, EVIL))), 5)


@pytest.fixture(scope="module")
def browser():
    driver = chromium()
    yield driver
    driver.quit()


def test_nothing_runs_in_a_browser(browser, written):
    name, place = written
    show(browser, place.as_uri(), 1000)
    for element in browser.find_elements("css selector", "h1, h2, h3, td, th, li, img, figcaption")[:40]:
        browser.execute_script("arguments[0].dispatchEvent(new MouseEvent('mouseover', {bubbles: true}))", element)
    assert browser.execute_script("return window.struck") is None
    assert browser.execute_script("return document.querySelectorAll('script, svg, b, img[src=x]').length") == 0
    if name != "notebook":  # a fragment: the notebook around it has the styles
        assert overflow(browser) <= 0
    if name.startswith("study"):
        assert browser.title.split() == EVIL.split()
        assert complaints(browser) == []


PROGRAM = "from symfric.cli import main; main(prog_name='symfric')"


@pytest.mark.long(beside="test_nothing_runs_in_a_browser")
@pytest.mark.parametrize("unit", longer(UNITS, UNITS[1:]))
def test_nothing_runs_in_the_explorer(browser, unit, tmp_path):
    pytest.importorskip("bokeh", reason="bokeh is not installed: pip install '.[explore]'")
    file = tmp_path / "scene.toml"
    file.write_text(scene(EVIL, unit), encoding="utf-8")
    command = [sys.executable, "-c", PROGRAM, "explore", str(file), "-q", "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        process.stdout.readline()
        address = re.search(r'"(http[^"]*)"', process.stdout.readline())[1]
        try:
            show(browser, address, 1000)
            end = time.monotonic() + 60
            while "answered" not in browser.execute_script(
                "return window.Bokeh && Bokeh.documents[0] ? Bokeh.documents[0].get_model_by_name('note').text : ''"
            ):
                assert time.monotonic() < end
                time.sleep(0.1)
            time.sleep(1.0)  # MathJax would be loaded by now
            assert browser.execute_script("return window.struck") is None
            assert browser.execute_script("return document.querySelectorAll('img, b').length") == 0
            assert browser.find_element("css selector", "h1").text.split() == EVIL.split()
            assert browser.title.split() == EVIL.split()
            assert unit in shown(browser)
            assert overflow(browser) <= 0
        finally:
            process.send_signal(signal.SIGINT)
            process.wait(30)


def shown(browser) -> str:
    """Return the words of the page, those inside the roots of its widgets too."""
    return browser.execute_script(
        "const walk = n => [...n.childNodes].map(c => c.nodeType == 3 ? c.data : walk(c)).join(' ')"
        " + (n.shadowRoot ? walk(n.shadowRoot) : ''); return walk(document.body);"
    )


def test_mathematics_of_strange_names_is_text():
    for mark in MARKS:
        name = re.sub(r"[_^]|\d+$", "", mark)
        for made in (inline(sp.Symbol(name)), to_mathml(sp.Symbol(name) ** 2 + 1)):
            seen = Seen(made)
            assert not {"script", "img", "svg", "b"} & set(seen.tags)
    x = sp.Symbol("x")
    assert "<mo>≤</mo>" in html.unescape(to_mathml(sp.Piecewise((x, x <= 1), (1, True))))
    assert "<mo>&lt;</mo>" in to_mathml(sp.Piecewise((x, x < 1), (1, True)))


def test_every_value_of_a_template_must_be_given():
    with pytest.raises(Exception, match="rows"):
        render("result.html", name="Run")


def test_the_templates_are_part_of_the_package():
    from importlib import resources

    for name in ("page.html", "parts.html", "study.html", "explore.html", "result.html", "style.css"):
        assert resources.files("symfric.templates").joinpath(name).is_file()


@pytest.mark.parametrize("text", ["\u001b[2J", "\u0000", "\u0007", "\u009b31m", "\u007f"])
def test_control_characters_are_refused(text):
    escaped = "".join(f"\\u{ord(c):04x}" if not c.isprintable() else c for c in text)
    for good, bad in (
        ('title = "T"', f'title = "{escaped}"'),
        ('"m" = "max(x)"', f'"{escaped}" = "max(x)"'),
        ('x = "m"', f'"{escaped}" = "m"'),
    ):
        whole = scene("m", "m").replace('title = "m"', 'title = "T"')
        assert good in whole
        with pytest.raises(sf.SceneError, match=rf"holds the control character U\+{ord(text[0]):04X}; remove it$") as e:
            read_scene_text(whole.replace(good, bad))
        assert str(e.value).isprintable()


@pytest.mark.parametrize("unit", NO_UNITS)
def test_a_text_that_is_no_unit_is_refused(unit):
    with pytest.raises(
        sf.SceneError, match="units.x: .* is not a unit; write N/m, kg, m/s, rad/s, or 1 for a plain number"
    ):
        read_scene_text(scene("evil", unit))


def test_a_unit_that_is_a_story_is_refused():
    with pytest.raises(sf.SceneError, match="units.x is longer than 40 characters; shorten it"):
        read_scene_text(scene("a", "W" * 41))


def test_escaping_is_that_of_html():
    assert html.unescape(re.search("<caption>(.*?)</caption>", html_table(EVIL, {}))[1]) == EVIL
