"""How to cite the program, the paper (both from ``CITATION.cff``) and a data set."""

import html
import json
import re
from dataclasses import dataclass
from typing import Self

from continuum.files.toml import packaged


@dataclass(frozen=True)
class Citation:
    """What ``CITATION.cff`` says."""

    title: str
    """Title of the program."""
    authors: tuple[str, ...]
    """Authors of the program."""
    version: str
    license: str
    paper: str
    """Reference of the paper."""
    doi: str
    """DOI of the paper."""

    @property
    def program(self) -> str:
        """Reference of the program."""
        return f"{', '.join(self.authors)}, {self.title}, version {self.version}"

    @classmethod
    def read(cls) -> Self:
        """Read the file that comes with the package: only as much of YAML as it uses."""
        text = packaged("CITATION.cff").read_text(encoding="utf-8")
        program, _, article = text.partition("references:")
        names = zip(_all(article, "family-names"), _all(article, "given-names"), strict=True)
        authors = [" ".join([re.sub(r"(\w)\w*\.?", r"\1.", given), family]) for family, given in names]
        said = {key: _all(article, key)[0] for key in ("title", "journal", "volume", "start", "end", "year", "doi")}
        paper = "{}, {title}, {journal} {volume}, {start}-{end} ({year}), doi:{doi}".format(
            " and ".join(authors), **said
        )
        own = {key: _all(program, key)[0] for key in ("title", "version", "license")}
        return cls(own["title"], _all(program, "name"), own["version"], own["license"], paper, said["doi"])


@dataclass(frozen=True)
class Metadata:
    """Metadata of a publication for an archive."""

    title: str
    creators: tuple[str, ...]
    license: str
    description: str

    def zenodo(self, paper: str) -> str:
        """The text of ``.zenodo.json``, which refers to the paper of this DOI."""
        said = {
            "title": self.title,
            "upload_type": "dataset",
            "description": f"<p>{html.escape(self.description)}</p>",
            "creators": [{"name": name} for name in self.creators],
            "access_right": "open",
            "license": self.license,
            "keywords": ["contact mechanics", "adhesion", "surface roughness", "tribology"],
            "related_identifiers": [
                {"identifier": paper, "relation": "references", "resource_type": "publication-article"}
            ],
        }
        return json.dumps(said, indent=2, ensure_ascii=False) + "\n"


def _all(text: str, key: str) -> tuple[str, ...]:
    return tuple(re.findall(rf'^[ -]*{key}: "?(.*?)"?$', text, re.MULTILINE))
