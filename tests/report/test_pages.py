"""The pages in a real browser: every picture there, nothing wider than the window, no word on the console."""

from pathlib import Path

import pytest

from symfric.report.study.page import page
from symfric.report.study.study import study
from symfric.scenefile import read_scene_text
from symfric_evidence.sources.gallery import gallery
from symfric_evidence.sources.reproduction import chosen
from tests.browser import chromium, complaints, missing_pictures, overflow, serious_findings, show
from tests.longer import longer

EXAMPLES = Path(__file__).parents[2] / "examples"
SOON = "number = 3\nsettle = 100\nwindow = 50"
FEWER = {"belt": ("number = 45", SOON), "two_masses": ("number = 23", SOON)}
PAGES = (*FEWER, "index")


@pytest.fixture(scope="module")
def browser():
    driver = chromium()
    yield driver
    driver.quit()


@pytest.fixture(scope="module")
def folder(browser, tmp_path_factory, request):
    """Studies, one with all sections and one with wide equations, if this run asks for it; the index of a reproduction."""
    place = tmp_path_factory.mktemp("pages")
    own = "test_a_page_is_whole_at_every_width"
    cases = [item for item in request.session.items if getattr(item, "originalname", None) == own]
    for name in {"belt", *(item.callspec.params["name"] for item in cases)} & set(FEWER):
        text = (EXAMPLES / f"{name}.toml").read_text().replace(*FEWER[name])
        (place / f"{name}.html").write_text(page(study(read_scene_text(text))), encoding="utf-8")
    made = {n: (e, e.make(), 0.1) for n, e in chosen(["guida-12", "guida-3", "rolling-table-2"]).items()}
    for name, (_, found, _) in made.items():
        if found.figure is not None:
            found.figure.savefig(place / f"{name}.png")
    (place / "index.html").write_text(gallery(made, {"symfric": "0"}), encoding="utf-8")
    return place


@pytest.mark.one_in(10)
@pytest.mark.parametrize(("width", "media"), [(400, "screen"), (1400, "screen"), (720, "print")])
@pytest.mark.parametrize("name", PAGES)
def test_a_page_is_whole_at_every_width(browser, folder, name, width, media):
    show(browser, (folder / f"{name}.html").as_uri(), width, media)
    assert browser.execute_script("return document.images.length") >= (2 if name == "index" else 5)
    assert missing_pictures(browser) == []
    assert overflow(browser) <= 0
    assert complaints(browser) == []


def test_a_wide_table_is_read_without_scrolling_on_a_narrow_screen(browser, folder):
    show(browser, (folder / "belt.html").as_uri(), 400)
    widths = browser.execute_script(
        "return [...document.querySelectorAll('table.cards')].map(t => [t.scrollWidth, t.parentElement.clientWidth])"
    )
    assert widths
    assert all(width <= room for width, room in widths)
    said = "return getComputedStyle(document.querySelector('.cards td:nth-child(2)'), '::before').content"
    assert browser.execute_script(said) == '"predicted"'


def test_a_page_follows_the_theme(browser, folder):
    colours = []
    for theme in ("light", "dark"):
        show(browser, (folder / "belt.html").as_uri(), 1400, theme=theme)
        colours.append(browser.execute_script("return getComputedStyle(document.body).backgroundColor"))
    assert colours == ["rgb(255, 255, 255)", "rgb(26, 26, 26)"]


@pytest.mark.parametrize("theme", longer(["light", "dark"], ["dark"]))
@pytest.mark.parametrize("name", longer(PAGES, ["two_masses"]))
def test_a_page_is_accessible(browser, folder, name, theme):
    show(browser, (folder / f"{name}.html").as_uri(), 1400, theme=theme)
    assert serious_findings(browser) == []


def test_a_missing_picture_would_be_seen(browser, folder):
    text = (folder / "index.html").read_text().replace("guida-3.png", "gone.png")
    (folder / "broken.html").write_text(text + '<p style="width: 3000px">wide</p>')
    show(browser, (folder / "broken.html").as_uri(), 400)
    assert len(missing_pictures(browser)) == 1
    assert overflow(browser) > 300
    assert complaints(browser)
