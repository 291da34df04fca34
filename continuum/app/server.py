"""The server of ``continuum view``, on this machine only, for users who have its address.

Each request needs the token of the address, first in the address and then in a cookie.  Host and origin are checked,
so that no web page can reach it through the browser.  It serves no file of the disk.
"""

import asyncio
import json
import secrets
import shlex
import shutil
import subprocess
import tempfile
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from importlib import resources
from pathlib import Path
from typing import Any, BinaryIO
from urllib.parse import unquote

from tornado.httpserver import HTTPServer
from tornado.iostream import StreamClosedError
from tornado.netutil import bind_sockets
from tornado.web import Application, HTTPError, RequestHandler, stream_request_body

from continuum.app.opened import EXAMPLE, EXAMPLE_FORM, OpenedMap, answer_of, known_to_page, safe_name, solved_layers
from continuum.app.states import OpenedResults, is_stored
from continuum.errors import InputError
from continuum.files.toml import find
from continuum.front.predict import Prediction

LARGEST = 200_000_000
"""Largest upload, in bytes."""
_COOKIE = "stickiness"
_PAGES = {"": "index.html", "states": "states.html"}
_TYPES = {".html": "text/html", ".js": "text/javascript", ".css": "text/css"}
# Nothing from another site, no code but ours; a report contains its style and its figures.
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src data:; connect-src 'self'; "
    "frame-src 'self'; frame-ancestors 'self'; base-uri 'none'; form-action 'none'"
)


@dataclass
class View:
    """The state of one call of ``continuum view``; the only mutable object here."""

    folder: Path
    """Private folder, removed when the program ends."""
    token: str = field(default_factory=lambda: secrets.token_urlsafe(24))
    port: int = 0
    opened: OpenedMap | None = None
    results: OpenedResults | None = None
    solving: subprocess.Popen[str] | None = None
    """The solver, running on the map in its own process."""
    began: float = 0.0
    uploads: int = 0
    working: asyncio.Lock = field(default_factory=asyncio.Lock)
    """Lock for solving and drawing: one thing at a time, as the style of figures is global to the process."""
    asked: int = 0
    """Questions so far: of those that wait or are solved, only the last one is answered."""
    last: Prediction | None = None
    """The last prediction of the open map."""

    def place(self, name: str) -> Path:
        """Path for an upload, in a new folder; raises InputError if it would be read as an input."""
        kept = safe_name(name)
        if kept.lower().endswith(".toml"):
            raise InputError("an input names files of this machine: open it with `continuum predict`")
        self.uploads += 1
        place = self.folder / f"map-{self.uploads}"
        place.mkdir()
        return place / kept

    def open(self, path: Path, shown: str, beside: bool = False) -> None:
        """Open a map in place of the open map, or results in place of the open results, which are forgotten.

        A map ``beside`` the open one is of the other body, or joined to it.  Raises InputError if it is a folder
        without results.
        """
        if path.is_dir() or is_stored(path):
            before = [] if self.results is None else [file.parent for file in self.results.runs.values()]
            self.results = OpenedResults.of(path)
        else:
            self.stop()
            self.asked, self.last, opened = self.asked + 1, None, self.opened
            if beside and opened is not None:
                self.opened = OpenedMap((*opened.paths, path), (*opened.shown, shown), opened.folder)
                return
            before = [] if opened is None else [*(each.parent for each in opened.paths), opened.folder]
            folder = self.folder / f"of-{secrets.token_hex(4)}"
            folder.mkdir()
            self.opened = OpenedMap((path,), (shown,), folder)
        self.forget(*before)

    def forget(self, *folders: Path) -> None:
        """Delete folders of uploads and of what was made of them, and none of the user's."""
        for folder in folders:
            if folder.parent == self.folder:
                shutil.rmtree(folder, ignore_errors=True)

    def is_open(self, path: Path) -> bool:
        """Whether a file is the open map or the open results."""
        results = () if self.results is None else self.results.runs.values()
        return path in results or (self.opened is not None and path in self.opened.paths)

    def stop(self) -> None:
        """End the solver, if it is running."""
        if self.solving is not None and self.solving.poll() is None:
            self.solving.terminate()
            self.solving.wait()
        self.solving = None


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
            said = self.without_folders(str(error)[:2000])
        self.set_header("Content-Type", "application/json")
        self.finish(json.dumps({"error": said}))

    def without_folders(self, said: str) -> str:
        """A text without names of folders."""
        opened, results = self.view.opened, self.view.results
        hidden = dict(zip(map(str, opened.paths), opened.shown, strict=True)) if opened is not None else {}
        hidden |= {f"{file.parent}/": "" for file in results.runs.values()} if results is not None else {}
        for place, shown in hidden.items():
            said = said.replace(place, shown)
        return said

    @property
    def opened(self) -> OpenedMap:
        if self.view.opened is None:
            raise HTTPError(409, reason="no map is open")
        return self.view.opened

    def asked(self) -> Mapping[str, str]:
        try:
            found = json.loads(self.request.body)
        except (ValueError, RecursionError):
            found = None
        if not isinstance(found, dict):
            raise HTTPError(400, reason="no form")
        return found


class _Static(_Handler):
    """The page and its scripts and styles."""

    def get(self, name: str) -> None:
        if self.get_query_argument("token", ""):  # from now on in a cookie, not in the history of the browser
            self.set_cookie(_COOKIE, self.view.token, httponly=True, samesite="Strict")
            self.redirect("/states" if self.view.results is not None and self.view.opened is None else "/")
            return
        file = resources.files("continuum.app") / "static" / _PAGES.get(name, name)
        text = file.read_text(encoding="utf-8")
        if name in _PAGES:
            opened, results = self.view.opened, self.view.results
            known = {"opened": opened.shown if opened is not None else [], **known_to_page()}
            if results is not None:
                known |= {"results": results.shown, "runs": list(results.runs)}
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


class _Look(_Handler):
    """The map as it is seen before anything of the bodies is known."""

    async def post(self) -> None:
        self.write(await _aside(self.opened.look, self.asked()))


class _Predict(_Handler):
    """The answer, as lines of JSON: what is being done, the answer, and then maps of the solution."""

    async def post(self) -> None:
        view, opened, asked = self.view, self.opened, self.asked()
        view.asked += 1
        mine, loop = view.asked, asyncio.get_running_loop()

        def told(text: str) -> None:
            if mine != view.asked:
                raise InputError("something else was asked meanwhile")
            loop.call_soon_threadsafe(self._line, {"told": text})

        try:
            async with view.working:
                if mine != view.asked:
                    raise HTTPError(409, reason="something else was asked meanwhile")
                found = await _aside(opened.predict, asked, view.last, told)
                if opened is view.opened:
                    view.last = found
                self._line({"answer": await _aside(answer_of, found) | {"command": shlex.join(opened.command(asked))}})
                self._line({"layers": await _aside(solved_layers, found)})
        except InputError as error:
            if not self._headers_written:
                raise
            self._line({"error": self.without_folders(str(error)[:2000])})

    def _line(self, said: dict[str, Any]) -> None:
        with suppress(StreamClosedError):
            self.write(json.dumps(said) + "\n")
            self.flush()


class _Report(_Handler):
    """The page that `continuum predict` writes, of the last answer."""

    async def post(self) -> None:
        opened, found = self.opened, self.view.last
        if found is None:
            raise HTTPError(409, reason="nothing has been answered yet")
        async with self.view.working:
            self.write({"page": await _aside(opened.report, found)})


class _States(_Handler):
    """The states of a stored run, or the map of one of them as plain numbers, x slowest."""

    async def get(self, run: str, step: str | None = None, kind: str = "") -> None:
        results = self.view.results
        if results is None:
            raise HTTPError(409, reason="no results are open")
        if step is None:
            self.write(await _aside(results.states, int(run)))
            return
        found = await _aside(results.map, int(run), int(step), kind)
        self.set_header("Content-Type", "application/octet-stream")
        self.write(found.astype(found.dtype.newbyteorder("<")).tobytes())


class _Solve(_Handler):
    """Start the solver, report its progress, or stop it."""

    async def post(self) -> None:
        opened, asked = self.opened, self.asked()
        self.view.stop()
        with (opened.folder / "said.txt").open("w") as said, (opened.folder / "solved.txt").open("w") as lines:
            self.view.solving = subprocess.Popen(
                opened.solving(asked), cwd=opened.folder, stdin=subprocess.DEVNULL, stdout=lines, stderr=said, text=True
            )
        self.view.began = time.monotonic()
        self.write({"solving": True})

    def get(self) -> None:
        opened, solving = self.opened, self.view.solving
        if solving is None:
            self.write({"solving": False})
            return
        code = solving.poll()
        said = self.without_folders((opened.folder / "said.txt").read_text(encoding="utf-8", errors="replace"))
        known = {"code": code, "seconds": round(time.monotonic() - self.view.began), "said": said[-2000:]}
        self.write({"solving": code is None} | known)

    def delete(self) -> None:
        self.view.stop()
        self.write({"solving": False})


class _Solved(_Handler):
    """The answer of the solver, and its page."""

    def get(self) -> None:
        self.write(self.opened.solved())


async def _aside(work: Any, *given: Any) -> Any:
    """Run a function in another thread, so that the server keeps answering."""
    return await asyncio.get_running_loop().run_in_executor(None, partial(work, *given))


def application(view: View) -> Application:
    """The application of a view."""
    given = {"view": view}
    return Application([
        (r"/(|view\.js|draw\.js|view\.css|states|states\.js)", _Static, given),
        (r"/map", _Upload, given),
        (r"/example", _Example, given),
        (r"/look", _Look, given),
        (r"/predict", _Predict, given),
        (r"/report", _Report, given),
        (r"/runs/(\d{1,9})(?:/(\d{1,9})/([a-z]{1,9}))?", _States, given),
        (r"/solve", _Solve, given),
        (r"/solved", _Solved, given),
    ])  # fmt: skip


def listen(view: View, port: int) -> HTTPServer:
    """Answer on a port of this machine, or on a free one if it is 0, in the running event loop."""
    server = HTTPServer(application(view), max_body_size=LARGEST, max_buffer_size=2 * 2**20)
    sockets = bind_sockets(port, "127.0.0.1")
    view.port = sockets[0].getsockname()[1]
    server.add_sockets(sockets)
    return server


async def serve_view(path: Path | None, port: int, begun: Any) -> None:
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
            view.stop()
