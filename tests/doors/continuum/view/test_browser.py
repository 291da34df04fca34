"""The page of `continuum view` in a real browser without a screen: each button, and what one map leaves to the next."""

from __future__ import annotations

import base64
import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import continuum

WITH = "needs the extra `browser`"
webdriver = pytest.importorskip("selenium.webdriver", reason=WITH)
By = pytest.importorskip("selenium.webdriver.common.by", reason=WITH).By
WebDriverWait = pytest.importorskip("selenium.webdriver.support.wait", reason=WITH).WebDriverWait
ActionChains = webdriver.ActionChains
StaleElementReferenceException = pytest.importorskip(
    "selenium.common.exceptions", reason=WITH
).StaleElementReferenceException

ROOT = Path(__file__).parents[4]
MAP = ROOT / "inputs" / "maps" / "wafer.txt"
FORM = {"size": "384nm", "unit": "nm", "material": "silicon, silicon"}
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
        process.send_signal(signal.SIGINT)
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


def slide(browser: webdriver.Chrome, name: str, value: float, where: str = "#form ") -> None:
    slider = browser.find_element(By.CSS_SELECTOR, f"{where}input[data-for={name}]")
    script = "arguments[0].value = arguments[1]; arguments[0].dispatchEvent(new Event('input', {bubbles: true}))"
    browser.execute_script(script, slider, value)


def choose(browser: webdriver.Chrome, name: str) -> None:
    browser.find_element(By.XPATH, f"//select[@id='layer']/option[.='{name}']").click()


def small_map(path: Path, seed: int, spike: float = 0.0) -> Path:
    """A map so small that everything is soon answered, in nm without saying so."""
    heights = continuum.SelfAffine(0.8, 0.05, 4.0, 16.0).synthesise(
        continuum.Grid.square(48), np.random.default_rng(seed)
    )
    heights[5, 7:9] += spike
    np.savetxt(path, heights)
    return path


def click(browser: webdriver.Chrome, name: str) -> None:
    browser.find_element(By.ID, name).click()


def value(browser: webdriver.Chrome, name: str) -> str:
    return str(browser.find_element(By.NAME, name).get_attribute("value"))


def shown(browser: webdriver.Chrome, name: str) -> bool:
    return bool(browser.find_element(By.ID, name).is_displayed())


def test_each_button_does_what_it_says(browser: webdriver.Chrome, address: str, tmp_path_factory: Any) -> None:
    place = tmp_path_factory.mktemp("maps")
    browser.get(address)
    browser.find_element(By.ID, "file").send_keys(str(small_map(place / "one.txt", 1, spike=3.0)))
    until(browser, lambda: "size" in text(browser, "error"))
    for name, given in {"size": "48nm", "unit": "nm", "material": "silicon", "work": "1mJ/m2"}.items():
        browser.find_element(By.NAME, name).send_keys(given)
    click(browser, "ask")
    until(browser, lambda: shown(browser, "verdict") and not text(browser, "progress"))
    correct, show = browser.find_elements(By.CSS_SELECTOR, "#faults button")
    show.click()
    assert "correction takes off" in str(browser.find_element(By.CSS_SELECTOR, "#map svg").get_attribute("aria-label"))
    correct.click()
    until(browser, lambda: "--fill" in text(browser, "command") and not shown(browser, "faulty"))
    until(browser, lambda: "which heights decide" in text(browser, "layer"))
    choose(browser, "contact at the threshold")
    assert "repels" in text(browser, "map")
    slide(browser, "work", 1)
    until(browser, lambda: "--work 10mJ/m2" in text(browser, "command"))
    until(browser, lambda: not shown(browser, "stop"))
    # Beside the curve are sliders of w and of the pressure, too: both of one quantity move together.
    slide(browser, "work", 0.9, "#loads ")
    until(browser, lambda: "--work 7.94mJ/m2" in text(browser, "command"))
    assert {one.get_attribute("value") for one in browser.find_elements(By.CSS_SELECTOR, "[data-for=work]")} == {"0.9"}
    slide(browser, "pressure", -0.3, "#loads ")
    until(browser, lambda: "touch at a mean gap" in text(browser, "loads"))
    until(browser, lambda: not shown(browser, "stop"))
    # A file that cannot be read leaves the map as it is.
    (place / "contact.toml").write_text("maps = []")
    browser.find_element(By.ID, "file").send_keys(str(place / "contact.toml"))
    until(browser, lambda: "names files of this machine" in text(browser, "error"))
    assert text(browser, "name") == "one.txt"
    assert shown(browser, "verdict")
    click(browser, "solve")
    until(browser, lambda: "by a search with adhesion" in text(browser, "statements"))
    until(browser, lambda: "--solve" in text(browser, "command"))
    until(browser, lambda: not shown(browser, "stop"))
    click(browser, "solve")
    click(browser, "stop")
    assert not shown(browser, "stop")
    assert not text(browser, "progress")
    click(browser, "all")
    until(browser, lambda: shown(browser, "save"))
    click(browser, "save")
    until(browser, (browser.saved / "prediction.html").is_file)
    answered = browser.find_element(By.ID, "works").get_attribute("innerHTML")
    assert f">{text(browser, 'verdict')}</p><svg" in (browser.saved / "prediction.html").read_text(encoding="utf-8")
    assert "undecided" in answered
    (browser.saved / "prediction.html").unlink()

    # The next map has nothing of the one before, unless that is asked for.
    browser.find_element(By.ID, "file").send_keys(str(small_map(place / "two.txt", 2)))
    until(browser, lambda: text(browser, "name") == "two.txt" and "size" in text(browser, "error"))
    assert [value(browser, name) for name in ("size", "unit", "material", "work")] == [""] * 4
    assert not shown(browser, "verdict")
    assert not browser.find_element(By.ID, "solve").is_enabled()
    click(browser, "again")
    until(browser, lambda: shown(browser, "verdict") and "two.txt --size 48nm" in text(browser, "command"))
    assert value(browser, "material") == "silicon"
    # Another map is the other body, or another measurement of the same surface.
    browser.find_element(By.ID, "another").send_keys(str(place / "one.txt"))
    until(browser, lambda: text(browser, "name") == "two.txt on one.txt")
    browser.find_element(By.NAME, "join").click()
    assert text(browser, "name") == "two.txt + one.txt"
    click(browser, "example")
    until(browser, lambda: value(browser, "size") == "384nm" and "scars" in text(browser, "faults"))
    assert value(browser, "work") == ""
    click(browser, "stop")


@pytest.mark.long
def test_a_map_is_dropped_corrected_slid_solved_and_saved(browser: webdriver.Chrome, address: str) -> None:
    browser.get(address)
    assert "token" not in browser.current_url
    assert "Nothing leaves this machine" in text(browser, "error")
    browser.find_element(By.ID, "file").send_keys(str(MAP))
    until(browser, lambda: text(browser, "name") == "wafer.txt")
    until(browser, lambda: "size" in text(browser, "error"))  # what the file does not say is asked for
    size = browser.find_element(By.NAME, "size")
    assert size.get_attribute("class") == "asked"
    assert "x (pixels)" in text(browser, "map"), "the map is seen before any field is filled"
    for name, value in FORM.items():
        browser.find_element(By.NAME, name).send_keys(value)
    browser.find_element(By.ID, "ask").click()
    until(browser, lambda: text(browser, "verdict") == "Sticky")
    assert "8 scars" in text(browser, "faults")
    until(browser, lambda: "which heights decide" in text(browser, "layer"))
    for width in (1280, 390):
        sizes = {"width": width, "height": 2400, "deviceScaleFactor": 1, "mobile": False}
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", sizes)
        pictured(browser, f"asked-{width}")
        assert browser.execute_script("return document.documentElement.scrollWidth") <= width
    above = browser.find_element(By.ID, "verdict").rect["y"] < browser.find_element(By.ID, "form").rect["y"]
    assert above, "on a narrow screen the answer comes before the form"
    browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})

    correct, show = browser.find_elements(By.CSS_SELECTOR, "#faults button")
    show.click()
    assert "scars" in str(browser.find_element(By.CSS_SELECTOR, "#map svg").get_attribute("aria-label"))
    correct.click()
    until(browser, lambda: "--fill 5%" in text(browser, "command"))
    assert not browser.find_element(By.ID, "faulty").is_displayed()
    for name in ("which heights decide", "contact at the threshold"):
        until(browser, lambda name=name: name in text(browser, "layer"))
        choose(browser, name)
    assert "repels" in text(browser, "map")

    slide(browser, "work", -1)
    until(browser, lambda: text(browser, "verdict") == "Not sticky")
    assert browser.find_element(By.NAME, "work").get_attribute("value") == "10mJ/m2"
    slide(browser, "contact_modulus", -1)  # a tenth of both is the same contact
    until(browser, lambda: text(browser, "verdict") == "Sticky")
    assert "--estar 8.24GPa" in text(browser, "command")
    pictured(browser, "slid")

    browser.find_element(By.ID, "solve").click()
    until(browser, lambda: "by a search with adhesion" in text(browser, "statements"))
    pictured(browser, "solved")
    browser.find_element(By.ID, "all").click()
    until(browser, browser.find_element(By.ID, "save").is_displayed)
    browser.find_element(By.ID, "save").click()
    saved = browser.saved / "prediction.html"
    until(browser, saved.is_file)
    assert "by a search with adhesion" in saved.read_text(encoding="utf-8")
    browser.get(saved.as_uri())
    assert base64.b64decode(browser.print_page()).startswith(b"%PDF")


@pytest.mark.long
def test_an_example_is_tried(browser: webdriver.Chrome, address: str) -> None:
    browser.get(address)
    browser.find_element(By.ID, "example").click()
    until(browser, lambda: text(browser, "verdict") == "Sticky")
    browser.find_element(By.ID, "all").click()
    until(browser, browser.find_element(By.ID, "report").is_displayed)


def test_states_of_a_stored_run_are_seen(browser: webdriver.Chrome, address: str, tmp_path_factory: Any) -> None:
    result = continuum.run("inputs/smoke/path.toml", tmp_path_factory.mktemp("run"))
    browser.get(address)
    browser.find_element(By.ID, "file").send_keys(str(result.path))
    until(browser, lambda: text(browser, "name") == "States of path.h5")
    place = browser.find_element(By.ID, "map")
    most = max(range(len(result.points)), key=lambda i: result.points[i].area_rep)
    until(browser, lambda: place.get_attribute("data-shown") == f"contact {most}")
    # The map under the mouse is the stored one: a pixel of the picture, and the words.
    contact = result.contact_map(most)
    i, j = (int(k[0]) for k in np.nonzero(contact == 2))
    pixel = browser.execute_async_script(
        """
        const [place, i, j, done] = arguments, image = new Image();
        image.onload = () => {
            const [width, height] = [image.width, image.height];
            const canvas = Object.assign(document.createElement("canvas"), { width, height });
            canvas.getContext("2d").drawImage(image, 0, 0);
            done([...canvas.getContext("2d").getImageData(i, j, 1, 1).data]);
        };
        image.src = place.querySelector("image").getAttribute("href");
        """,
        place, i, contact.shape[1] - 1 - j,
    )  # fmt: skip
    assert pixel == [0xF0, 0x80, 0, 255]
    browser.find_element(By.ID, "a0").send_keys("0.3")
    image = browser.find_element(By.CSS_SELECTOR, "#map image")
    box = image.rect
    across = (i + 0.5) / contact.shape[0] * box["width"] - box["width"] / 2
    up = (contact.shape[1] - j - 0.5) / contact.shape[1] * box["height"] - box["height"] / 2
    ActionChains(browser).move_to_element_with_offset(image, round(across), round(up)).perform()
    until(browser, lambda: "repulsive" in text(browser, "under"))
    assert "a0 = " in text(browser, "under")
    assert "nm" in text(browser, "under")
    pictured(browser, "states")
    browser.find_elements(By.CSS_SELECTOR, "circle.state")[0].click()
    until(browser, lambda: place.get_attribute("data-shown") == "contact 0")
    assert text(browser, "which") == f"1 of {len(result.points)}"


@pytest.mark.long
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
