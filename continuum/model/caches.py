"""Folders for what can be made again: the user's, or one for temporary files where there is no home."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path


def folder_for(name: str = "") -> Path | None:
    """A folder of this name in the user's folder of caches, or among the temporary files; None if none can be made.

    Somebody else could put files into a temporary folder that is not this user's alone: such a folder is not used.
    """
    return next((place / name for place in _places() if writable(place / name)), None)


def at_home() -> bool:
    """True if the user has a folder of caches that can be written."""
    home = _of_user()
    return home is not None and writable(home)


def writable(folder: Path) -> bool:
    """True if a file can be made in a folder, which is made if it is not there."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True


def _of_user() -> Path | None:
    named = os.environ.get("XDG_CACHE_HOME", "")
    with suppress(RuntimeError):  # a user without a home, as in a container
        place = Path(named) if Path(named).is_absolute() else Path.home() / ".cache"
        if place.is_absolute():
            return place / "stickiness"
    return None


def _places() -> Iterator[Path]:
    if (home := _of_user()) is not None:
        yield home
    with suppress(OSError):  # no folder for temporary files, or none that this user may use
        private = Path(tempfile.gettempdir()) / f"stickiness-{os.getuid()}"
        with suppress(FileExistsError):
            private.mkdir(mode=0o700)
        found = private.lstat()  # of a link itself
        if found.st_uid == os.getuid() and found.st_mode & 0o170077 == 0o040000:
            yield private
