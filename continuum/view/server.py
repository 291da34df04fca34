"""The server of ``continuum view``, on this machine only, for users who have its address.

Each request needs the token of the address, first in the address and then in a cookie.  Host and origin are checked,
so that no web page can reach it through the browser.  It serves no file of the disk.
"""

import asyncio
import json
import secrets
import tempfile
from collections.abc import Mapping
from contextlib import suppress
from importlib import resources
from pathlib import Path
from typing import Any, BinaryIO
from urllib.parse import unquote

from tornado.httpserver import HTTPServer
from tornado.iostream import StreamClosedError
from tornado.netutil import bind_sockets
from tornado.web import Application, HTTPError, RequestHandler, stream_request_body

from continuum.front.predict import Prediction
from continuum.inputs.errors import InputError
from continuum.inputs.toml import find
from continuum.maps.verdict.materials import materials
from continuum.maps.verdict.tables import OPTIONS
from continuum.show.plot import contact_colours, map_colours
from continuum.view.opened import OpenedMap, Told, View, answer_of, arguments, look, solved_layers
from continuum.view.states import is_stored

LARGEST = 200_000_000
"""Largest upload, in bytes."""
EXAMPLE = "inputs/maps/wafer.txt"
"""A map to try, and what is filled in for it."""
EXAMPLE_FORM = {"size": "384nm", "unit": "nm", "material": "silicon, silicon"}
_COOKIE = "stickiness"
_PAGES = {"": "index.html", "states": "states.html"}
_TYPES = {".html": "text/html", ".js": "text/javascript", ".css": "text/css"}
# Nothing from another site, no code but ours; a report contains its style and its figures.
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src data:; connect-src 'self'; "
    "frame-src 'self'; frame-ancestors 'self'; base-uri 'none'; form-action 'none'"
)


class _Handler(RequestHandler):
    """Checks and headers of every request."""

    view: View

    def initialize(self, view: View) -> None:
        self.view = view

    def set_default_headers(self) -> None:
        self.set_header("Content-Security-Policy", _POLICY)
        self.set_header("Cache-Control", "no-store")
        self.set_header("X-Content-Type-Options", "nosniff")
        self.set_header("Referrer-Policy", "no-referrer")

    def prepare(self) -> None:
        """Refuse requests without the token, and requests of other pages in the browser."""
        hosts = {f"{name}:{self.view.port}" for name in ("127.0.0.1", "localhost")}
        if self.request.host not in hosts:
            raise HTTPError(403, reason="not the address of this program")
        origin = self.request.headers.get("Origin")
        if origin is not None and origin not in {f"http://{host}" for host in hosts}:
            raise HTTPError(403, reason="asked for by another page")
        given = self.get_query_argument("token", "") or self.get_cookie(_COOKIE) or ""
        if not secrets.compare_digest(given.encode(), self.view.token.encode()):
            raise HTTPError(403, reason="the address lacks its token: use the one that the program has printed")

    def log_exception(self, kind: Any, error: Any, trace: Any) -> None:
        if not isinstance(error, InputError):
            super().log_exception(kind, error, trace)

    def write_error(self, status_code: int, **more: Any) -> None:
        """Answer what is wrong, with the message of the command and without names of folders."""
        _, error, _ = more.get("exc_info", (None, None, None))
        said = self._reason if status_code != 405 else f"{self.request.method} is not answered here"
        if isinstance(error, InputError):
            self.set_status(422)
            said = self.view.without_folders(str(error)[:2000])
        self.finish({"error": said})

    @property
    def opened(self) -> OpenedMap:
        if self.view.opened is None:
            raise HTTPError(409, reason="no map is open")
        return self.view.opened


class _Static(_Handler):
    """The page and its scripts and styles."""

    def get(self, name: str) -> None:
        view = self.view
        if self.get_query_argument("token", ""):  # from now on in a cookie, not in the history of the browser
            self.set_cookie(_COOKIE, view.token, httponly=True, samesite="Strict")
            self.redirect("/states" if view.results is not None and view.opened is None else "/")
            return
        file = resources.files("continuum.view") / "static" / _PAGES.get(name, name)
        text = file.read_text(encoding="utf-8")
        if name in _PAGES:
            known = {
                "opened": [] if view.opened is None else view.opened.shown,
                "materials": sorted(materials()),
                "colours": {"contact": contact_colours(), "numbers": map_colours()},  # from the lowest value on
                "help": {name: " ".join((one.description or "").split()) for name, one in OPTIONS.items()},
            }
            if view.results is not None:
                known |= {"results": view.results.shown, "runs": list(view.results.runs)}
            text = text.replace("{known}", json.dumps(known).replace("<", "\\u003c"))
        self.set_header("Content-Type", f"{_TYPES[Path(file.name).suffix]}; charset=utf-8")
        self.write(text)


@stream_request_body
class _Upload(_Handler):
    """Upload of a map: its bytes, with its name in a header."""

    _path: Path | None = None
    _file: BinaryIO

    def prepare(self) -> None:
        super().prepare()
        if self.request.method != "PUT":
            raise HTTPError(405)
        length = self.request.headers.get("Content-Length", "")
        if not length.isdecimal():
            raise HTTPError(411, reason="the request does not say how long the file is")
        if len(length) > len(str(LARGEST)) or int(length) > LARGEST:
            raise HTTPError(413, reason=f"more than {LARGEST // 10**6} MB")
        self._path = self.view.place(unquote(self.request.headers.get("X-Name", ""))[:200])
        self._file = self._path.open("xb")

    def data_received(self, chunk: bytes) -> None:
        self._file.write(chunk)

    def put(self) -> None:
        assert self._path is not None
        self._file.close()
        self.view.open(self._path, self._path.name, beside="X-Beside" in self.request.headers)
        states = is_stored(self._path)
        self.write({"opened": [self._path.name] if states else self.opened.shown, "states": states})

    def on_finish(self) -> None:
        """Delete what was not opened, or came in part only."""
        if self._path is not None and not self.view.is_open(self._path):
            self._file.close()
            self.view.forget(self._path.parent)

    on_connection_close = on_finish


class _Example(_Handler):
    """Open a map that comes with the package, and say what its form is."""

    def post(self) -> None:
        self.view.open(find(EXAMPLE), EXAMPLE)
        self.write({"opened": self.opened.shown, "form": EXAMPLE_FORM})


class _Question(_Handler):
    """A question about the open map, answered in lines of JSON as they are found."""

    mine = 0

    async def post(self) -> None:
        try:
            asked = json.loads(self.request.body)
        except (ValueError, RecursionError):
            asked = None
        if not isinstance(asked, dict):
            raise HTTPError(400, reason="no form")
        opened, self.mine = self.opened, self.view.ask()
        try:
            await self.answer(opened, asked)
        except InputError as error:
            if not self._headers_written:
                raise
            self.line({"error": self.view.without_folders(str(error)[:2000])})

    async def answer(self, opened: OpenedMap, asked: Mapping[str, str]) -> None:
        raise NotImplementedError

    def wanted(self) -> None:
        """Raise InputError if something else has been asked."""
        if self.mine != self.view.asked:
            raise InputError("another request replaced this one")

    def on_connection_close(self) -> None:
        if self.mine == self.view.asked:
            self.view.ask()

    def line(self, said: Mapping[str, Any]) -> None:
        if not self._finished:
            with suppress(StreamClosedError):
                self.write(json.dumps(said) + "\n")
                self.flush()


class _Look(_Question):
    """The map as it is seen before anything of the bodies is known, and then its faults."""

    async def answer(self, opened: OpenedMap, asked: Mapping[str, str]) -> None:
        parts = look(opened.paths, arguments(asked))
        while (said := await asyncio.to_thread(next, parts, None)) is not None:
            self.wanted()
            self.line(said)


class _Predict(_Question):
    """Progress, the answer, and then maps of the solution."""

    async def answer(self, opened: OpenedMap, asked: Mapping[str, str]) -> None:
        loop = asyncio.get_running_loop()

        def told(text: str) -> None:
            self.wanted()
            loop.call_soon_threadsafe(self.line, {"told": text})

        async with self.view.working:
            self.wanted()
            found, command = await asyncio.to_thread(self.predict, opened, asked, told)
            self.wanted()
            self.view.last = found
            self.line({"answer": await asyncio.to_thread(answer_of, found) | {"command": command}})
            self.line({"layers": await asyncio.to_thread(solved_layers, found)})

    def predict(self, opened: OpenedMap, asked: Mapping[str, str], told: Told) -> tuple[Prediction, str]:
        return opened.predict(asked, self.view.last, told), opened.command(asked)


class _Solve(_Predict):
    """The same after a search with adhesion."""

    def predict(self, opened: OpenedMap, asked: Mapping[str, str], told: Told) -> tuple[Prediction, str]:
        return opened.searched(asked, self.view.searching, told), opened.command(asked, "--solve")


class _Report(_Handler):
    """The page that `continuum predict` writes, of the last answer."""

    async def post(self) -> None:
        opened, found = self.opened, self.view.last
        if found is None:
            raise HTTPError(409, reason="nothing has been answered yet")
        async with self.view.working:
            self.write({"page": await asyncio.to_thread(opened.report, found)})


class _States(_Handler):
    """The states of a stored run, or the map of one of them as plain numbers, x slowest."""

    async def get(self, run: str, step: str | None = None, kind: str = "") -> None:
        results = self.view.results
        if results is None:
            raise HTTPError(409, reason="no results are open")
        if step is None:
            self.write(await asyncio.to_thread(results.states, int(run)))
            return
        found = await asyncio.to_thread(results.map, int(run), int(step), kind)
        self.set_header("Content-Type", "application/octet-stream")
        self.write(found.astype(found.dtype.newbyteorder("<")).tobytes())


def listen(view: View, port: int) -> HTTPServer:
    """Answer on a port of this machine, or on a free one if it is 0, in the running event loop."""
    given = {"view": view}
    application = Application([
        (r"/(|view\.js|draw\.js|view\.css|states|states\.js)", _Static, given),
        (r"/map", _Upload, given),
        (r"/example", _Example, given),
        (r"/look", _Look, given),
        (r"/predict", _Predict, given),
        (r"/solve", _Solve, given),
        (r"/report", _Report, given),
        (r"/runs/(\d{1,9})(?:/(\d{1,9})/([a-z]{1,9}))?", _States, given),
    ])  # fmt: skip
    server = HTTPServer(application, max_body_size=LARGEST, max_buffer_size=2 * 2**20)
    sockets = bind_sockets(port, "127.0.0.1")
    view.port = sockets[0].getsockname()[1]
    server.add_sockets(sockets)
    return server


async def serve_view(path: Path | None, port: int, begun: Told) -> None:
    """Serve until it is stopped.

    Parameters
    ----------
    path : a map or results to open first.
    port : port to use; 0 for a free one.
    begun : called with the address.
    """
    with tempfile.TemporaryDirectory(prefix="stickiness-view-") as folder:
        view = View(Path(folder))
        if path is not None:
            view.open(path.resolve(), path.name)
        server = listen(view, port)
        begun(f"http://127.0.0.1:{view.port}/?token={view.token}")
        try:
            await asyncio.Event().wait()
        finally:
            server.stop()
            await server.close_all_connections()
            view.ask()
            async with view.working:  # what is worked on ends by itself, so that nothing is cancelled in the middle
                pass
