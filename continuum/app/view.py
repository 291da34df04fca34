"""``continuum view``: the command."""

from __future__ import annotations

import asyncio
import webbrowser
from contextlib import suppress
from pathlib import Path

from continuum.arguments import count, flag
from continuum.errors import InputError
from continuum.show.console import tell


def view(file: str | Path | None = None, *, port: int = 0, browser: bool = True) -> None:
    """Is my surface sticky?  The page of `continuum predict` alive, in a browser on this machine only.

    Drop a map on the page, or name one; sliders change the work of adhesion, E*, the range and the cut-off.

    Parameters
    ----------
    file : a measured topography that is open from the beginning.
    port : of this machine; a free one if it is 0.
    browser : whether to open the page in a browser; its address is printed in any case.

    Raises InputError if the file is not there, or the program that serves the page is not installed.
    """
    count("port", port, 0, 65535)
    flag("browser", browser)
    path = None if file is None else Path(file)
    if path is not None and not path.is_file():
        raise InputError(f"{path}: no such file")
    try:
        from continuum.app.server import serve_view
    except ModuleNotFoundError as error:
        raise InputError("the page needs tornado: pip install 'stickiness[app]'") from error

    def begun(address: str) -> None:
        tell(f"open {address}\nCtrl-C ends it; nothing that is dropped on the page is kept")
        if browser:
            webbrowser.open(address)

    try:
        with suppress(KeyboardInterrupt):
            asyncio.run(serve_view(path, port, begun))
    except OSError as error:
        raise InputError(f"port {port} of this machine cannot be used: {error.strerror or error}") from error
