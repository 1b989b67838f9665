"""A page as a browser shows it, in headless Chromium; a machine without it skips, with the reason."""

import shutil

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
    return selenium.Chrome(options, selenium.ChromeService(driver))


def show(browser, address: str, width: int, media: str = "screen") -> None:
    """Open a page at a width, on the screen or as it is printed."""
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": media})
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
