"""One page of HTML that needs no other file: a sentence, warnings, sheets and figures."""

import base64
import html
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import quote

import continuum
from continuum.store import output
from continuum.store.sheet import Sheet

PIXELS = 2
"""Pixels of a picture per point of the screen, so that a figure of the width of a printed page is as wide as the
text."""
_WIDE = 640
"""Width of a picture of several panels, in points of the screen, which no narrow screen shows legibly."""
_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; max-width: 66rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
div.sheet { overflow-x: auto; }
table { border-collapse: collapse; margin: 0.4rem 0 1rem; font-size: 13px; }
th, td { text-align: left; vertical-align: top; padding: 0.2rem 0.7rem 0.2rem 0; border-bottom: 1px solid #ddd; }
th { border-bottom: 2px solid #888; }
h1 { font-size: 1.4rem; } h2 { font-size: 1.05rem; margin: 1.4rem 0 0; }
img { max-width: 100%; height: auto; }
pre { font-size: 12px; background: #f6f6f6; padding: 1em; overflow-x: auto; }
p.answer { font-size: 2.6rem; line-height: 1.1; font-weight: 700; margin: 0 0 0.5rem; padding: 0.1em 0.3em; color: #fff;
  print-color-adjust: exact; }
svg { width: min(100%, 40rem); print-color-adjust: exact; }
p.verdict { font-size: 1.1rem; padding: 0.6rem 0.9rem; background: #eef3f7; }
p.note, figcaption { font-size: 13px; color: #555; white-space: pre-line; }
figure { margin: 1rem 0; overflow-x: auto; }
@media (max-width: 40rem) { figure img.wide { max-width: none; width: 44rem; } }
footer { color: #666; font-size: 12px; margin-top: 2rem; }
@media print {
  body { margin: 0; max-width: none; font-size: 10pt; } table { font-size: 8pt; }
  div.sheet, pre { overflow: visible; white-space: pre-wrap; } div.sheet { white-space: normal; }
  figure, tr { break-inside: avoid; } h2 { break-after: avoid; }
}
"""


@dataclass(frozen=True)
class Page:
    """Contents of a page, from top to bottom.

    Parameters
    ----------
    title : of the page.
    verdict : the answer, in one sentence.
    warnings : warnings, one sentence each.
    figures : PNG files with their captions; they become part of the page.
    sheets : tables, each under its title.
    listing : title and text of a verbatim part, such as an input.
    sources : references, at its foot.
    files : files beside the page with their descriptions, to which the page links.
    answers : sentences that follow the verdict, one a line.
    answer : the verdict in a word, its colour, and an SVG that shows it; None to begin with the sentence.
    """

    title: str
    verdict: str
    warnings: Sequence[str] = ()
    figures: Sequence[tuple[Path, str]] = ()
    sheets: Sequence[Sheet] = ()
    listing: tuple[str, str] | None = None
    sources: str = field(default="")
    files: Sequence[tuple[str, str]] = ()
    answers: Sequence[str] = ()
    answer: tuple[str, str, str] | None = None

    def html(self) -> str:
        """The page; figures are read now."""
        return "\n".join(self._parts()) + "\n"

    def write(self, path: Path) -> Path:
        """Write the page; returns its path."""
        return output.save(path, self.html())

    def _parts(self) -> Iterator[str]:
        title = html.escape(self.title)
        yield '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        yield f'<meta name="generator" content="{output.MARK.decode()}">'
        yield '<meta name="viewport" content="width=device-width, initial-scale=1">'
        yield f"<title>{title}</title><style>{_STYLE}</style></head><body>"
        yield f"<h1>{title}</h1>"
        if self.answer is not None:
            word, colour, drawing = self.answer
            yield f'<p class="answer" style="background: {colour}">{html.escape(word)}</p>{drawing}'
        yield f'<p class="verdict">{html.escape(self.verdict)}</p>'
        yield from (f"<p>{html.escape(text)}</p>" for text in self.answers)
        if self.warnings:
            items = "".join(f"<li>{html.escape(text)}</li>" for text in self.warnings)
            yield f"<h2>Warnings</h2><ul>{items}</ul>"
        for path, caption in self.figures:
            image = picture(path.read_bytes(), path.stem)
            yield f"<figure>{image}<figcaption>{html.escape(caption)}</figcaption></figure>"
        for sheet in self.sheets:
            note = f'<p class="note">{html.escape(sheet.note)}</p>' if sheet.note else ""
            yield f'<h2>{html.escape(sheet.title)}</h2><div class="sheet">{sheet.html()}</div>{note}'
        if self.files:
            links = (f'<a href="{html.escape(quote(name))}">{html.escape(name)}</a>' for name, _ in self.files)
            items = "".join(
                f"<li>{link}: {html.escape(what)}</li>" for link, (_, what) in zip(links, self.files, strict=True)
            )
            yield f"<h2>Files</h2><ul>{items}</ul>"
        if self.listing is not None:
            yield f"<h2>{html.escape(self.listing[0])}</h2><pre>{html.escape(self.listing[1])}</pre>"
        made = html.escape(f"stickiness {continuum.__version__}. {self.sources}")
        yield f"<footer>{made}</footer></body></html>"


def with_picture(shown: Any) -> str:
    """Sheet and picture of a state or a path, as a notebook shows it."""
    from continuum.show.plot import image_bytes  # matplotlib takes half a second to import

    sheet: Sheet = shown.sheet()
    return sheet._repr_html_() + picture(image_bytes(shown.plot()), repr(shown))


def picture(png: bytes, instead: str) -> str:
    """A picture as part of a page, with alternative text; letters have the same size in all pictures."""
    data = base64.b64encode(png).decode("ascii")
    width = int.from_bytes(png[16:20], "big") // PIXELS  # in points of the screen, from the header of the PNG
    kind = ' class="wide"' if width > _WIDE else ""  # on a narrow screen it is shown whole, and scrolls
    return f'<img{kind} alt="{html.escape(instead)}" width="{width}" src="data:image/png;base64,{data}">'
