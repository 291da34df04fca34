"""Write results: whole or not at all, never over an input or a file of others, and never two writers at once.

Where that cannot be done, each function raises OutputError, and what was there stays as it was.
"""

import os
import socket
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from filelock import FileLock, Timeout

from continuum.errors import OutputError

MARK = b"written by stickiness"
"""What pictures and pages say of themselves, where nobody reads it."""


class LockedError(OutputError):
    """Another process is writing there."""


def folder(path: str | Path) -> Path:
    """Make a folder unless it exists, and check that it can be written to; returns it."""
    path = Path(path)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        msg = f"{path}: cannot make a folder for results there ({reason(error)}); choose another with --output"
        raise OutputError(msg) from error
    if not os.access(path, os.W_OK | os.X_OK):
        raise OutputError(f"{path}: no permission to write to this folder; choose another with --output")
    return path


@contextmanager
def whole(path: str | Path) -> Iterator[BinaryIO]:
    """Open a new file, which gets its name only when it is complete and on the disk, and is removed otherwise."""
    path = Path(path)
    # Same folder, so that the replacement is a rename; host and process, so that two writers never share it.
    temporary = path.with_name(f"{_stem(path)}{socket.gethostname()}.{os.getpid()}.tmp")
    try:
        if path.exists() and not path.is_file():
            raise OutputError(f"{path}: is not a regular file; choose another name or folder")
        try:
            with temporary.open("w+b") as file:
                yield file
                file.flush()
                os.fsync(file.fileno())
            temporary.replace(path)
            _sync(path.parent)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {reason(error)}") from error


def save(path: str | Path, content: bytes | str, *, own: bool = False) -> Path:
    """Write a small file, whole or not at all; returns its path.

    A file of that name is replaced if this program wrote it: if it contains :data:`MARK`, or begins like a new file
    without that mark.  Any other file is kept, and OutputError raised.

    Parameters
    ----------
    own : whether the folder is the program's own, so that whatever has this name there is replaced.
    """
    path, data = Path(path), content.encode() if isinstance(content, str) else content
    if not own and path.is_file() and not _is_ours(path, data):
        msg = f"{path}: was not written by this program, and is left alone; move it, or choose another folder"
        raise OutputError(msg)
    with whole(path) as file:
        file.write(data)
    return path


def _is_ours(path: Path, new: bytes) -> bool:
    """Whether this program wrote the existing file that a new one would replace; an empty file counts as such."""
    try:
        old = path.read_bytes()
    except OSError as error:
        raise OutputError(f"{path}: cannot be replaced, as it cannot be read: {reason(error)}") from error
    if MARK in new:
        return not old or MARK in old
    first = (content.partition(b"\n")[0].partition(b",")[0].strip() for content in (old, new))  # line, or cell
    return not old or len({*first}) == 1


def distinct(path: Path, inputs: Iterable[Path]) -> None:
    """Refuse to write over an input, whatever it is called: files are compared by device and inode."""
    for used in inputs:
        try:
            same = path.samefile(used)
        except OSError:
            same = False
        if same:
            raise OutputError(f"{path}: is an input ({used}), and is left alone; choose another folder with --output")


def is_locked(mark: Path) -> bool:
    """Whether the process of a lock file still runs; on other machines it is assumed to."""
    words = holder(mark).split()
    if len(words) < 4 or words[3] != socket.gethostname() or not words[1].isdecimal():
        return mark.is_file()
    return _alive(int(words[1]))


def placed(path: str | Path, final: str | Path) -> Path:
    """Move a complete file to its final name, in another folder of the same disk; returns that name."""
    final = Path(final)
    try:
        Path(path).replace(final)
        _sync(final.parent)
    except OSError as error:
        raise OutputError(f"{final}: cannot be written: {reason(error)}") from error
    return final


@contextmanager
def reserved(path: str | Path) -> Iterator[None]:
    """Lock a file that is about to be written, possibly many times, against other processes.

    Its folder is made, and remains of killed writers are removed.
    """
    path = Path(path)
    folder(path.parent)
    try:
        if path.exists() and not path.is_file():
            raise OutputError(f"{path}: is not a regular file; choose another folder with --output")
        mark = path.with_name(f".{path.name}.lock")
        lock = FileLock(mark, timeout=0)
        lock.acquire()
    except Timeout:
        msg = f"{path}: is being written by {holder(mark)}; wait for it, or choose another folder with --output"
        raise LockedError(msg) from None
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {reason(error)}") from error
    try:
        mark.write_text(f"process {os.getpid()} on {socket.gethostname()} since {time.strftime('%Y-%m-%d %H:%M:%S')}")
        remove_stale(path)
        yield
    finally:
        # Removed while it is locked: a waiting process sees that it has no name any more, and makes a new one.
        mark.unlink(missing_ok=True)
        lock.release()


def holder(mark: Path) -> str:
    """Process and host that lock a file, from the lock file beside it."""
    try:
        return mark.read_text() or "another process"
    except OSError:
        return "another process"


def remove_stale(path: str | Path) -> None:
    """Remove what writers of this file left behind when they were killed on this machine."""
    path = Path(path)
    stem = _stem(path) + socket.gethostname() + "."
    if not path.parent.is_dir():
        return
    for entry in path.parent.iterdir():
        process = entry.name.removeprefix(stem).removesuffix(".tmp")
        if entry.name == f"{stem}{process}.tmp" and process.isdecimal() and not _alive(int(process)):
            entry.unlink(missing_ok=True)


def reason(error: OSError) -> str:
    """Why a file could not be read or written, without its name."""
    return error.strerror or str(error)


def _stem(path: Path) -> str:
    return f".{path.name}."


def _alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True


def _sync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
