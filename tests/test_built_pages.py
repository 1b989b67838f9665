"""The built documentation as browsers show it, on a phone and on a screen: every page, and what the search finds.

The pages are those of ``python -m docs``, or in the folder that the variable SYMFRIC_BUILT_PAGES names.
"""

import html
import os
import re
import time
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

from tests.browser import (
    broken_headings,
    chromium,
    complaints,
    missing_pictures,
    overflow,
    serious_findings,
    show,
    tallest,
)

ROOT = Path(__file__).parents[1]
PAGES = Path(os.environ.get("SYMFRIC_BUILT_PAGES", ROOT / "docs" / "_build" / "html")).resolve()
PHONE, SCREEN = 400, 1400
TALLEST = 120_000  # pixels on a phone
AWAY = ("genindex.html", "search.html", "studies/", "_static/")  # made by Sphinx; studies have tests of their own
_UNREAD = re.compile(r"<(script|style)\b.*?</\1>", re.DOTALL)
_ADDRESS = re.compile(r'(?:href|src)="([^"]+)"')
FOUND = {  # what people type: a page that the search has to find
    "did not converge": "reference/messages",
    "too slow": "howto/long_runs",
    "read a csv": "tutorials/record_to_law",
    "units": "howto/units",
    "nan": "reference/messages",
    "STEP_BUDGET": "reference/messages",
    "animation": "howto/notebooks",
    "amplitude after transient": "howto/outputs",
    "earthquake": "tutorials/isolator",
    "two directions": "explanation/plane",
    "how do I switch a force": "reference/other_words",
    "how do I save": "reference/other_words",
    "step in time": "howto/steps_in_time",
    "held": "howto/held",
    "ellipse": "explanation/plane",
    "lift off": "reference/other_words",
    "dead time": "howto/held",
    "bolted joint": "howto/memory",
    "parallel": "tutorials/sweeps",
}


@pytest.fixture(scope="module")
def browser():
    if not (PAGES / "index.html").is_file():
        pytest.skip(f"no built pages in {PAGES}: python -m docs")
    driver = chromium()
    yield driver
    driver.quit()


def pages():
    names = sorted(p.relative_to(PAGES).as_posix() for p in PAGES.rglob("*.html"))
    return [n for n in names if not n.startswith(AWAY)]


def test_links_within_the_pages_lead_to_files():
    if not (PAGES / "index.html").is_file():
        pytest.skip(f"no built pages in {PAGES}: python -m docs")
    dead = {}
    for page in PAGES.rglob("*.html"):
        text = _UNREAD.sub("", page.read_text(encoding="utf-8"))
        for address in set(_ADDRESS.findall(text)):
            parts = urlsplit(html.unescape(address))
            if parts.path and not parts.scheme and not (page.parent / unquote(parts.path)).exists():
                dead.setdefault(address, []).append(page.relative_to(PAGES).as_posix())
    assert dead == {}


@pytest.mark.parametrize("width", [PHONE, SCREEN])
def test_every_page_fits_its_window(browser, width):
    faults = []
    for name in pages():
        show(browser, (PAGES / name).as_uri(), width)
        if (wide := overflow(browser)) > 0:
            faults.append(f"{name} is {wide} pixels wider than its window of {width}")
        if broken := broken_headings(browser):
            faults.append(f"{name}: headings of tables are broken: {broken[:5]}")
        if width == PHONE and (tall := tallest(browser)) > TALLEST:
            faults.append(f"{name} is {tall} pixels tall")
        if width == SCREEN and (missing := missing_pictures(browser)):
            faults.append(f"{name} lacks the pictures {missing}")
        faults += [f"{name}: {said}" for said in complaints(browser)]
    assert faults == []


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_pages_are_accessible(browser, theme):
    faults = []
    for name in pages():
        if theme == "light" or name.count("/") == 0 or name.startswith(("tutorials/", "howto/")):
            show(browser, (PAGES / name).as_uri(), SCREEN, theme=theme)
            faults += [f"{name}: {finding}" for finding in serious_findings(browser)]
    assert faults == []


@pytest.mark.parametrize("words", FOUND)
def test_the_search_finds(browser, words):
    show(browser, f"{(PAGES / 'search.html').as_uri()}?q={words.replace(' ', '+')}", SCREEN)
    until = time.monotonic() + 20
    while time.monotonic() < until:
        found = browser.execute_script("return [...document.querySelectorAll('ul.search li a')].map(a => a.href)")
        if any(f"{FOUND[words]}.html" in address for address in found):
            return
        time.sleep(0.1)
    raise AssertionError(f"{words!r} finds {[a.rpartition('/html/')[2] for a in found]}")
