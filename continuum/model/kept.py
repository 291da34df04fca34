"""Compiled code on disk: kept where a folder can be written, read if it is intact, and never needed.

numba's own cache stops a program whose folders cannot be written, whose disk is full, or whose cache is damaged, as by
a job that was killed while it wrote.  Here a file is sealed by a hash of its content, of the source and of numba's
version; what has another seal is not unpickled but compiled and written again, and what cannot be written is compiled
by each process.
"""

import hashlib
import pickle
import tempfile
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba import config as numba_config
from numba import njit
from numba.core import caching as numba_caching
from numba.core import serialize

from continuum.model import caches

Compiled = TypeVar("Compiled", bound=Callable[..., object])
caching: Any = numba_caching  # without types
config: Any = numba_config
dumps: Callable[[object], bytes] = serialize.dumps
_SEAL = 32
"""Bytes of a seal, SHA-256."""


def kept_on_disk(**options: Any) -> Callable[[Compiled], Compiled]:
    """Compile a function with the options of ``numba.njit``, and keep the result on disk if that can be done."""

    def made(function: Compiled) -> Compiled:
        compiled: Compiled = njit(**options)(function)
        dispatcher: Any = compiled
        # Whatever another numba or a folder does: without a cache it is compiled in memory.
        with suppress(Exception):
            dispatcher._cache = _Cache(function)
        return compiled

    return made


@cache
def folder_of_compiled(sources: Path) -> Path | None:
    """Folder for the compiled functions of a source folder; None if none can be written.

    The first that can be written of $NUMBA_CACHE_DIR, the ``__pycache__`` beside the source, the user's folder of
    caches, and a folder of this user alone among the temporary files.
    """
    name = caching._CacheLocator.get_suitable_cache_subpath(str(sources / "any.py"))
    places = [sources / "__pycache__"]
    if config.CACHE_DIR:
        places.insert(0, Path(config.CACHE_DIR) / name)
    return next(filter(caches.writable, places), None) or caches.folder_for(f"compiled/{name}")


class _Place(caching._SourceFileBackedLocatorMixin, caching._CacheLocator):  # type: ignore[misc]
    """Place of the compiled code of a function, in the form that numba asks for."""

    def __init__(self, function: Any, file: str, folder: Path) -> None:
        self._py_file, self._lineno = file, function.__code__.co_firstlineno
        self._cache_path = str(folder)

    def get_cache_path(self) -> str:
        return self._cache_path

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> "_Place | None":
        folder = folder_of_compiled(Path(py_file).absolute().parent)
        return None if folder is None else cls(py_func, py_file, folder)


class _Result(caching.CompileResultCacheImpl):  # type: ignore[misc]
    _locator_classes = (_Place,)


class _Files:
    """A sealed file for each signature of a function and each kind of processor."""

    def __init__(self, of_numba: Any) -> None:
        self._folder, self._base = Path(of_numba._cache_path), str(of_numba._index_name).removesuffix(".nbi")
        self._origin = repr((numba.__version__, of_numba._source_stamp))

    def _path(self, key: object) -> Path:
        return self._folder / f"{self._base}.{hashlib.sha256(repr(key).encode()).hexdigest()[:16]}.nbc"

    def _seal(self, key: object, content: bytes) -> bytes:
        return hashlib.sha256(f"{self._origin}{key!r}".encode() + content).digest()

    def load(self, key: object) -> Any:
        """Stored code; None if there is none, or if it is damaged or from another function."""
        file = self._path(key).read_bytes()
        seal, content = file[:_SEAL], file[_SEAL:]
        return pickle.loads(content) if seal == self._seal(key, content) else None

    def save(self, key: object, data: object) -> None:
        content = dumps(data)
        # Written beside and renamed: another process never reads half a file.
        with tempfile.NamedTemporaryFile(dir=self._folder, prefix=".kept-", delete=False) as file:
            try:
                file.write(self._seal(key, content) + content)
                file.close()
                Path(file.name).replace(self._path(key))
            except OSError:
                Path(file.name).unlink()
                raise


class _Cache(caching.FunctionCache):  # type: ignore[misc]
    """numba's cache of a function, which stops no run.

    Reading and writing it may fail in any way, by the disk or by another numba: then the function is compiled.
    """

    _impl_class = _Result

    def __init__(self, function: Any) -> None:
        super().__init__(function)
        self._cache_file: Any = _Files(self._cache_file)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        with suppress(Exception):
            return super().load_overload(sig, target_context)
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        with suppress(Exception):
            super().save_overload(sig, data)
