"""A page as a browser shows it, in headless Chromium; a machine without it skips, with the reason."""

import shutil
from pathlib import Path

import pytest


def chromium():
    """Return a driver of a headless Chromium, or skip."""
    selenium = pytest.importorskip("selenium.webdriver", reason="selenium is not installed: pip install '.[test]'")
    program, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if program is None or driver is None:
        pytest.skip("no Chromium here: install Debian's packages chromium and chromium-driver")
    options = selenium.ChromeOptions()
    options.binary_location = program
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    browser = selenium.Chrome(options, selenium.ChromeService(driver))
    browser.set_script_timeout(300)  # axe takes over half a minute for a long page where other work runs
    return browser


def show(browser, address: str, width: int, media: str = "screen", theme: str = "light") -> None:
    """Open a page at a width, on the screen or as it is printed, where a light or a dark theme is preferred."""
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    preferred = [{"name": "prefers-color-scheme", "value": theme}]
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": media, "features": preferred})
    browser.get(address)


def missing_pictures(browser) -> list[str]:
    """Return the pictures that have no size, the lazy ones loaded first."""
    return browser.execute_async_script(
        "const done = arguments[0], all = [...document.images];"
        "all.forEach(i => i.loading = 'eager');"
        "Promise.all(all.map(i => i.decode().catch(() => 0)))"
        ".then(() => done(all.filter(i => !(i.complete && i.naturalWidth > 0)).map(i => i.alt)));"
    )


def overflow(browser) -> int:
    """Return by how many pixels the page is wider than the window."""
    return browser.execute_script("const e = document.documentElement; return e.scrollWidth - e.clientWidth;")


def complaints(browser) -> list[str]:
    """Return what the console has to say since it was last asked, warnings and errors."""
    return [entry["message"] for entry in browser.get_log("browser") if entry["level"] in ("WARNING", "SEVERE")]


def broken_headings(browser) -> list[str]:
    """Return the words of headings of tables that are broken into pieces, one below the other."""
    return browser.execute_script(
        """
        const broken = [];
        for (const cell of document.querySelectorAll('th')) {
          const walker = document.createTreeWalker(cell, NodeFilter.SHOW_TEXT);
          for (let node = walker.nextNode(); node; node = walker.nextNode())
            for (const word of node.data.matchAll(/[\\p{L}\\p{N}]{2,}/gu)) {
              const range = document.createRange();
              range.setStart(node, word.index);
              range.setEnd(node, word.index + word[0].length);
              const lines = new Set([...range.getClientRects()].map(r => Math.round(r.top)));
              if (lines.size > 1) broken.push(word[0]);
            }
        }
        return broken;
        """
    )


def tallest(browser) -> int:
    """Return the height of the page, in pixels."""
    return browser.execute_script("return document.documentElement.scrollHeight;")


def serious_findings(browser, without: tuple[str, ...] = ()) -> list[str]:
    """Return what axe-core, the checker of accessibility, finds serious or critical: the rule, and what breaks it.

    Skips where axe-core is not installed.
    """
    package = pytest.importorskip("axe_core_python", reason="axe-core is not installed: pip install '.[test]'")
    script = next(Path(package.__path__[0]).glob("axe.min.js")).read_text(encoding="utf-8")
    browser.execute_script(script)
    found = browser.execute_async_script(
        "const [left, done] = arguments;"
        "axe.run({resultTypes: ['violations'], rules: Object.fromEntries(left.map(r => [r, {enabled: false}]))})"
        ".then(r => done(r.violations), e => done([{impact: 'critical', id: String(e), nodes: []}]));",
        list(without),
    )
    serious = [v for v in found if v["impact"] in ("serious", "critical")]
    return [
        f"{v['id']}: {n['target']} {n['html'][:150]}"
        for v in serious
        for n in v["nodes"][:3] or [{"target": "", "html": ""}]
    ]
