"""The site builds without a warning, and can be read on a telephone."""

from __future__ import annotations

import html
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.style

ROOT = Path(__file__).parents[2]
WIDTH = 390
"""Of a telephone, in CSS pixels."""
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
LOOK = """<!doctype html><meta charset="utf-8"><body><script>
const scrolls = (box) => ["auto", "scroll"].includes(getComputedStyle(box).overflowX);
// A box around the whole article does not count: in that of the theme a table moves all of the text beside it.
const held = (part) => part.tagName !== "ARTICLE" && (scrolls(part) || held(part.parentElement));
const KINDS = ["table", "pre", "img", "p", "li", "dt", "code", "a:not(.headerlink)"];
const PARTS = KINDS.map((kind) => "article " + kind).join(", ");
(async () => {
  const found = {};
  for (const page of PAGES) {
    const frame = document.createElement("iframe");
    frame.style = "width: WIDTHpx; height: 800px; border: 0";
    await new Promise((done) => { frame.onload = done; frame.src = page; document.body.append(frame); });
    const root = frame.contentDocument.documentElement;
    const parts = [...root.querySelectorAll(PARTS)];
    const out = parts.filter((part) => part.getBoundingClientRect().right > root.clientWidth + 1 && !held(part));
    found[page] = [root.scrollWidth, out.map((part) => part.tagName + " " + part.textContent.slice(0, 60))];
    frame.remove();
  }
  const answer = document.createElement("pre");
  answer.id = "answer";
  answer.textContent = JSON.stringify(found);
  document.body.append(answer);
})();
</script>"""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("sphinx", reason="needs the extra `docs`")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", "docs", str(folder)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder


def widths(folder: Path, profile: Path) -> dict[str, tuple[float, list[str]]]:
    """Width to which each page scrolls, in a frame of WIDTH, and what stands beyond its edge in no box that scrolls."""
    pages = [
        path.relative_to(folder).as_posix() for path in sorted(folder.rglob("*.html")) if "_static" not in path.parts
    ]
    look = folder / "look.html"
    look.write_text(LOOK.replace("PAGES", json.dumps(pages)).replace("WIDTH", str(WIDTH)), encoding="utf-8")
    assert CHROMIUM is not None
    command = [
        CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
        "--disable-background-networking", "--disable-component-update", "--disable-sync",
        "--allow-file-access-from-files", f"--user-data-dir={profile}", "--virtual-time-budget=1000000", "--dump-dom",
        look.as_uri(),
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
    look.unlink()
    answer = re.search(r'<pre id="answer">(.*?)</pre>', done.stdout, re.DOTALL)
    assert answer is not None, done.stderr
    found: dict[str, tuple[float, list[str]]] = json.loads(html.unescape(answer[1]))
    assert set(found) == set(pages)
    return found


@pytest.mark.long
def test_the_site_builds_without_a_warning(site: Path) -> None:
    assert (site / "reference" / "run.html").is_file()


@pytest.mark.long
@pytest.mark.skipif(CHROMIUM is None, reason="needs chromium")
def test_no_page_is_wider_than_a_telephone(site: Path, tmp_path: Path) -> None:
    found = widths(site, tmp_path)
    assert {page: width for page, (width, _) in found.items() if width > WIDTH} == {}
    assert {page: parts for page, (_, parts) in found.items() if parts} == {}


@pytest.mark.long
@pytest.mark.skipif(CHROMIUM is None, reason="needs chromium")
def test_a_page_that_is_too_wide_is_seen(tmp_path: Path) -> None:
    for name, style in {"free": "", "cut": "overflow-x: hidden", "held": "overflow-x: auto"}.items():
        table = "<table><tr><td style='min-width: 800px'>wide</td></tr></table>"
        body = f"<html><body style='margin: 0'><article><div style='{style}'>{table}</div></article></body></html>"
        (tmp_path / f"{name}.html").write_text(f"<!doctype html>{body}")
    found = widths(tmp_path, tmp_path / "profile")
    assert {name: width > WIDTH for name, (width, _) in found.items()} == {
        "free.html": True, "cut.html": False, "held.html": False,
    }  # fmt: skip
    assert {name for name, (_, parts) in found.items() if any("TABLE" in part for part in parts)} == {
        "free.html", "cut.html",
    }  # fmt: skip
