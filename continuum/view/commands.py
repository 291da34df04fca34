"""The command ``continuum view``, which starts the server of its page."""

import asyncio
import webbrowser
from pathlib import Path
from typing import Any

from continuum.front.options import like
from continuum.inputs.arguments import count, flag
from continuum.inputs.errors import OK, InputError
from continuum.inputs.toml import find
from continuum.show.console import tell, until_ctrl_c


def open_page(file: str | Path | None = None, *, port: int = 0, browser: bool = True) -> None:
    """Show a height map or stored results on a page in a browser, on this machine only.

    For a map it shows the answer of `continuum predict`, with sliders for the work of adhesion, E*, the range and the
    cut-off.  For a stored run, a sweep, or a deck that `atomistic read` stored, it shows load, areas and the contact
    map of every state.  Files can also be dropped on the page.

    Parameters
    ----------
    file : file to open first: a measured topography, ``inputs/...`` for one that comes with the package, a stored run,
        or the folder of a sweep.
    port : port to use; 0 for a free one.
    browser : whether to open the page in a browser; its address is printed in any case.

    Raises InputError if the file does not exist, the folder is not a sweep, or the server is not installed.
    """
    count("port", port, 0, 65535)
    flag("browser", browser)
    path = None if file is None else find(file)
    if path is not None and not path.exists():
        raise InputError(f"{path}: no such file")
    try:
        from continuum.view.server import serve_view
    except ModuleNotFoundError as error:
        raise InputError("the page needs tornado: pip install 'stickiness[app]'") from error

    def begun(address: str) -> None:
        tell(f"open {address}\nCtrl-C ends it; files dropped on the page are not kept")
        if browser:
            webbrowser.open(address)

    try:
        with until_ctrl_c():
            asyncio.run(serve_view(path, port, begun))
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"port {port} of this machine cannot be used: {error.strerror or error}") from error


@like(open_page)
def view(*file: Path, **given: Any) -> int:
    if len(file) > 1:
        raise InputError(f"{file[1]}: only one file can be opened at a time")
    open_page(*file, **given)
    return OK
