"""The page of `continuum view` in a real browser without a screen: drop, slide, solve, save."""

from __future__ import annotations

import base64
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import continuum

pytestmark = pytest.mark.long
WITH = "needs the extra `browser`"
webdriver = pytest.importorskip("selenium.webdriver", reason=WITH)
By = pytest.importorskip("selenium.webdriver.common.by", reason=WITH).By
WebDriverWait = pytest.importorskip("selenium.webdriver.support.wait", reason=WITH).WebDriverWait
ActionChains = webdriver.ActionChains
StaleElementReferenceException = pytest.importorskip(
    "selenium.common.exceptions", reason=WITH
).StaleElementReferenceException

ROOT = Path(__file__).parents[3]
MAP = ROOT / "inputs" / "maps" / "wafer.txt"
FORM = {"size": "384nm", "unit": "nm", "material": "silicon, silicon", "fill": "5%"}
PICTURES = os.environ.get("STICKINESS_SCREENSHOTS", "")
"""Folder for screenshots, to be looked at; none are made if it is not given."""


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[webdriver.Chrome]:
    chromium, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if chromium is None or driver is None:
        pytest.skip("needs chromium and its driver")
    options = webdriver.ChromeOptions()
    options.binary_location = chromium
    for option in ("--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=1300,1500"):
        options.add_argument(option)
    saved = tmp_path_factory.mktemp("saved")
    options.add_experimental_option("prefs", {"download.default_directory": str(saved)})
    found = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
    found.saved = saved
    yield found
    found.quit()


@pytest.fixture
def address(tmp_path: Path) -> Iterator[str]:
    """Of a view that a user starts in a process of its own."""
    command = [sys.executable, "-m", "continuum", "view", "--no-browser"]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    with subprocess.Popen(command, cwd=tmp_path, env=environment, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        found = re.search(r"http\S+", process.stderr.readline())
        assert found is not None
        yield found[0]
        process.terminate()
    assert process.returncode == 0
    assert not list(tmp_path.iterdir()), "nothing is left where it was started"


def text(browser: webdriver.Chrome, name: str) -> str:
    return browser.find_element(By.ID, name).text


def until(browser: webdriver.Chrome, what: Callable[[], Any]) -> None:
    # Elements that were found before another page came are looked for again.
    WebDriverWait(browser, 300, ignored_exceptions=[StaleElementReferenceException]).until(lambda _: what())


def pictured(browser: webdriver.Chrome, name: str) -> None:
    if PICTURES:
        browser.save_screenshot(str(Path(PICTURES) / f"{name}.png"))


def slide(browser: webdriver.Chrome, name: str, value: float) -> None:
    slider = browser.find_element(By.CSS_SELECTOR, f"input[data-for={name}]")
    script = "arguments[0].value = arguments[1]; arguments[0].dispatchEvent(new Event('input', {bubbles: true}))"
    browser.execute_script(script, slider, value)


def test_a_map_is_dropped_slid_solved_and_saved(browser: webdriver.Chrome, address: str) -> None:
    browser.get(address)
    assert "token" not in browser.current_url
    assert "Nothing leaves this machine" in text(browser, "answer")
    browser.find_element(By.ID, "file").send_keys(str(MAP))
    until(browser, lambda: text(browser, "name") == "wafer.txt")
    until(browser, lambda: "size" in text(browser, "answer"))  # what the file does not say is asked for
    for name, value in FORM.items():
        browser.find_element(By.NAME, name).send_keys(value)
    browser.find_element(By.ID, "ask").click()
    until(browser, lambda: text(browser, "answer").startswith("Undecided (82 %"))
    until(browser, browser.find_element(By.ID, "report").is_displayed)
    assert text(browser, "command").endswith("--material silicon --material silicon")
    pictured(browser, "asked")

    slide(browser, "work", -1)
    until(browser, lambda: text(browser, "answer").startswith("Not sticky"))
    assert browser.find_element(By.NAME, "work").get_attribute("value") == "10mJ/m2"
    slide(browser, "contact_modulus", -1)  # a tenth of both is the same contact
    until(browser, lambda: text(browser, "answer").startswith("Undecided (82 %"))
    assert "--estar 8.24GPa" in text(browser, "command")
    report = browser.find_element(By.ID, "report")
    until(browser, lambda: "old" not in (report.get_attribute("class") or ""))
    assert "at w = 7.71 mJ/m²" in str(report.get_attribute("srcdoc")), "the report is of what was asked last"
    pictured(browser, "slid")

    browser.find_element(By.ID, "solve").click()
    until(browser, lambda: text(browser, "answer").startswith("Sticky, solved on the map: w = 10 mJ/m²"))
    assert "solved in" in text(browser, "progress")
    pictured(browser, "solved")

    # The button prints the report itself, and what is printed is a PDF of several pages.
    browser.execute_script("arguments[0].contentWindow.print = () => { document.title = 'printed'; }", report)
    browser.find_element(By.ID, "print").click()
    until(browser, lambda: browser.title == "printed")

    browser.find_element(By.ID, "save").click()
    saved = browser.saved / "prediction.html"
    until(browser, saved.is_file)
    assert "Sticky, solved on the map" in saved.read_text(encoding="utf-8")
    browser.get(saved.as_uri())
    pdf = base64.b64decode(browser.print_page())
    assert pdf.startswith(b"%PDF")
    if PICTURES:
        (Path(PICTURES) / "report.pdf").write_bytes(pdf)


def test_a_map_is_seen_before_and_after_it_is_mended(browser: webdriver.Chrome, address: str) -> None:
    browser.get(address)
    browser.find_element(By.ID, "file").send_keys(str(MAP))
    for name, value in FORM.items():
        browser.find_element(By.NAME, name).send_keys(value)
    browser.find_element(By.NAME, "detrend").send_keys("lines")
    browser.find_element(By.ID, "ask").click()
    mending = browser.find_element(By.ID, "mending")
    until(browser, mending.is_displayed)
    until(browser, lambda: mending.find_element(By.TAG_NAME, "img").get_property("naturalWidth") > 100)
    browser.execute_script("arguments[0].scrollIntoView()", mending)
    pictured(browser, "mended")
    slide(browser, "cutoff", 0.5)
    until(browser, lambda: "--cutoff" in text(browser, "command"))


def test_states_of_a_stored_run_are_seen(browser: webdriver.Chrome, address: str, tmp_path_factory: Any) -> None:
    result = continuum.run("inputs/smoke/path.toml", tmp_path_factory.mktemp("run"))
    browser.get(address)
    browser.find_element(By.ID, "file").send_keys(str(result.path))
    until(browser, lambda: text(browser, "name") == "States of path.h5")
    canvas = browser.find_element(By.ID, "map")
    most = max(range(len(result.points)), key=lambda i: result.points[i].area_rep)
    until(browser, lambda: canvas.get_attribute("data-shown") == f"contact {most}")
    # The map under the mouse is the stored one: a pixel of the canvas, and the words.
    contact = result.contact_map(most)
    i, j = (int(k[0]) for k in np.nonzero(contact == 2))
    pixel = browser.execute_script(
        "return [...arguments[0].getContext('2d').getImageData(arguments[1], arguments[2], 1, 1).data]",
        canvas, i, contact.shape[1] - 1 - j,
    )  # fmt: skip
    assert pixel == [0xF0, 0x80, 0, 255]
    browser.find_element(By.ID, "a0").send_keys("0.3")
    box = canvas.rect
    across = (i + 0.5) / contact.shape[0] * box["width"] - box["width"] / 2
    up = (contact.shape[1] - j - 0.5) / contact.shape[1] * box["height"] - box["height"] / 2
    ActionChains(browser).move_to_element_with_offset(canvas, round(across), round(up)).perform()
    until(browser, lambda: "repulsive" in text(browser, "under"))
    assert "a0 = " in text(browser, "under")
    assert "nm" in text(browser, "under")
    pictured(browser, "states")
    browser.find_elements(By.CSS_SELECTOR, "circle.state")[0].click()
    until(browser, lambda: canvas.get_attribute("data-shown") == "contact 0")
    assert text(browser, "which") == f"1 of {len(result.points)}"


def test_a_page_of_the_web_gets_nothing(browser: webdriver.Chrome, address: str, tmp_path: Path) -> None:
    """A page from elsewhere, in the browser that has the cookie, cannot ask, read or frame."""
    browser.get(address)
    host = address.partition("/?")[0]
    browser.get("data:text/html,<p id=said></p>")
    script = """
        const done = arguments[1];
        fetch(arguments[0] + "/predict", {method: "POST", body: "{}", credentials: "include"})
            .then((answer) => answer.text()).then(done, (error) => done("refused: " + error));
    """
    assert browser.execute_async_script(script, host).startswith("refused")
