"""The installation: whether what the packages need is there, and whether another distribution overwrites them."""

import re
from importlib import metadata
from itertools import chain

from packaging.requirements import Requirement

from continuum.inputs.errors import InputError

NAME = "stickiness"
PACKAGES = "continuum", "atomistic"
"""Our import packages.  On the package index other distributions have these names, and bring packages of them."""


def of_our_names() -> list[metadata.Distribution]:
    """Installed distributions that are called as our packages are: found at once."""
    return list(chain.from_iterable(metadata.distributions(name=name) for name in PACKAGES))


def beside_ours() -> list[metadata.Distribution]:
    """Installed distributions, whatever their names, that bring an import package of one of our names."""
    named = metadata.packages_distributions()
    names = {name for package in PACKAGES for name in named.get(package, ()) if _normal(name) != NAME}
    found = {_normal(one.metadata["Name"]): one for one in of_our_names()}
    return list({**{_normal(name): metadata.distribution(name) for name in sorted(names)}, **found}.values())


def told(others: list[metadata.Distribution]) -> str:
    """Name and version of the distribution whose files are mixed with ours."""
    listed = " and ".join(f"{one.metadata['Name']} {one.version}" for one in others)
    return (
        f"another distribution, {listed}, brings an import package of the same name: files of one overwrite the other's"
    )


def remedy(others: list[metadata.Distribution]) -> str:
    """Remedy by which both can be used: one overwrote files of the other, so that ours is installed anew."""
    names = " ".join(one.metadata["Name"] for one in others)
    return (
        f"install {NAME} in an environment of its own, or `python -m pip uninstall {names} {NAME}` "
        f"and install {NAME} again"
    )


def refuse_others() -> None:
    """Raise InputError if a distribution of another program is installed into our packages."""
    if others := of_our_names():
        raise InputError(f"{told(others)}; {remedy(others)}")


def missing(only: str = "") -> dict[str, str]:
    """Requirements that are not met, each with the installed version; ``only`` is a pattern of names."""
    found = {}
    for text in metadata.requires(NAME) or ():
        one = Requirement(text)
        if one.marker is not None and not one.marker.evaluate({"extra": ""}):
            continue
        if not re.fullmatch(only or ".*", one.name):
            continue
        try:
            version = metadata.version(one.name)
        except metadata.PackageNotFoundError:
            version = ""
        if not version or not one.specifier.contains(version, prereleases=True):
            found[f"{one.name}{one.specifier}"] = version or "not installed"
    return found


def _normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()
