"""A published sweep as an RO-Crate: https://w3id.org/ro/crate/1.1, metadata that data portals read.

The graph names the data set with its authors and licence, each file, and the program as the instrument that made them.
"""

import hashlib
import json
import mimetypes
import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from continuum.inputs.arguments import ArgumentError
from continuum.store.provenance import Citation

CRATE = "ro-crate-metadata.json"
_ORCID = re.compile(r"(.*?)[;\s(]*(?:https://orcid\.org/)?(\d{4}-\d{4}-\d{4}-\d{3}[\dX])\)?\s*")


class Creator(NamedTuple):
    """An author of data."""

    name: str
    """As "Family, Given"."""
    orcid: str = ""
    """As 0000-0002-1825-0097; empty if it is not known."""

    @classmethod
    def of(cls, text: str) -> "Creator":
        """The author of "Family, Given", with an ORCID after it or not; ArgumentError if that is misspelt."""
        found = _ORCID.fullmatch(text)
        if found is None:
            return cls(text)
        name, orcid = found.groups()
        if not name or _check_digit(orcid) != orcid[-1]:
            raise ArgumentError("creators", text, '"Family, Given; 0000-0002-1825-0097": a digit of the ORCID is wrong')
        return cls(name, orcid)

    @property
    def text(self) -> str:
        return f"{self.name}; {self.orcid}" if self.orcid else self.name

    @property
    def zenodo(self) -> dict[str, str]:
        return {"name": self.name, **({"orcid": self.orcid} if self.orcid else {})}


def _check_digit(orcid: str) -> str:
    """The last digit of an ORCID after ISO 7064, 11-2."""
    total = 0
    for digit in orcid.replace("-", "")[:-1]:
        total = 2 * (total + int(digit))
    left = (12 - total % 11) % 11
    return "X" if left == 10 else str(left)


def software_identifier(provenance: Mapping[str, object]) -> str:
    """The program in the Software Heritage archive, by its commit (ISO/IEC 18670); empty outside a checkout."""
    commit = str(provenance.get("provenance/git_commit", ""))
    return f"swh:1:rev:{commit}" if commit else ""


def crate(
    title: str, description: str, creators: Sequence[Creator], license: str, citation: Citation, software: str,
    date: str, files: Mapping[str, bytes],
) -> str:  # fmt: skip
    """The text of ``ro-crate-metadata.json``.

    Parameters
    ----------
    software : identifier of the program; empty if there is none.
    date : of the publication, as 2026-11-28.
    files : contents of the other files of the folder, by name.
    """
    people = [
        {"@id": f"https://orcid.org/{one.orcid}" if one.orcid else f"#creator-{i}", "@type": "Person", "name": one.name}
        for i, one in enumerate(creators, 1)
    ]
    program = {
        "@id": software or "#stickiness", "@type": "SoftwareApplication", "name": citation.title,
        "version": citation.version, "license": citation.license,
    }  # fmt: skip
    paper = {"@id": f"https://doi.org/{citation.doi}", "@type": "ScholarlyArticle", "name": citation.paper}
    parts = [
        {
            "@id": name, "@type": "File", "name": name, "contentSize": str(len(content)),
            "encodingFormat": mimetypes.guess_type(name)[0] or "application/octet-stream",
            "sha256": hashlib.sha256(content).hexdigest(),
        }
        for name, content in sorted(files.items())
    ]  # fmt: skip
    terms = {"@id": f"#{license}", "@type": "CreativeWork", "name": license, "identifier": license}
    root = {
        "@id": "./", "@type": "Dataset", "name": title, "description": description, "datePublished": date,
        "author": _links(people), "license": {"@id": terms["@id"]}, "citation": {"@id": paper["@id"]},
        "hasPart": _links(parts),
    }  # fmt: skip
    made = {
        "@id": "#sweep", "@type": "CreateAction", "instrument": {"@id": program["@id"]}, "result": {"@id": "./"},
        "object": {"@id": "sweep.toml"}, "name": "continuum sweep run",
    }  # fmt: skip
    head = {
        "@id": CRATE, "@type": "CreativeWork", "about": {"@id": "./"},
        "conformsTo": {"@id": "https://w3id.org/ro/crate/1.1"},
    }  # fmt: skip
    graph = [head, root, *people, terms, program, paper, made, *parts]
    said = {"@context": "https://w3id.org/ro/crate/1.1/context", "@graph": graph}
    return json.dumps(said, indent=2, ensure_ascii=False) + "\n"


def _links(entities: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    return [{"@id": one["@id"]} for one in entities]
