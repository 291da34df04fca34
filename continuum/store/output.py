"""Write results: whole or not at all, never over an input or a file of others, and never two writers at once.

Where that cannot be done, each function raises OutputError, and what was there stays as it was.

A lock is flock(2) on a file that names its process.  Where a file system has none, as NFS without a lock daemon, the
file itself is the lock: it holds until it is removed, or until its process has ended, which its own machine sees.
"""

import errno
import fcntl
import logging
import os
import socket
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from continuum.inputs.errors import OutputError

MARK = b"written by stickiness"
"""What pictures and pages say of themselves, where nobody reads it."""

_WITHOUT_LOCKS = frozenset({errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS})
_LOCKLESS = set[Path]()
"""Folders that were found to have no locks, which is said once of each."""


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
def _written(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {reason(error)}") from error


@contextmanager
def whole(path: str | Path) -> Iterator[BinaryIO]:
    """Open a new file, which gets its name only when it is complete and on the disk, and is removed otherwise."""
    path = Path(path)
    # Same folder, so that the replacement is a rename; host and process, so that two writers never share it.
    temporary = path.with_name(f"{_stem(path)}{socket.gethostname()}.{os.getpid()}.tmp")
    with _written(path):
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
    return mark.is_file() and not _was_left(mark)


def _was_left(mark: Path) -> bool:
    """Whether the process of a lock file has ended on this machine."""
    words = holder(mark).split()
    here = len(words) >= 4 and words[3] == socket.gethostname() and words[1].isdecimal()
    return here and not _alive(int(words[1]))


def placed(path: str | Path, final: str | Path) -> Path:
    """Move a complete file to its final name, in another folder of the same disk; returns that name."""
    final = Path(final)
    with _written(final):
        Path(path).replace(final)
        _sync(final.parent)
    return final


@contextmanager
def reserved(path: str | Path) -> Iterator[None]:
    """Lock a file that is about to be written, possibly many times, against other processes.

    Its folder is made, and remains of killed writers are removed.
    """
    path = Path(path)
    folder(path.parent)
    if path.exists() and not path.is_file():
        raise OutputError(f"{path}: is not a regular file; choose another folder with --output")

    def refusal(holder: str) -> str:
        return f"{path}: is being written by {holder}; wait for it, or choose another folder with --output"

    with locked(path.with_name(f".{path.name}.lock"), refusal):
        remove_stale(path)
        yield


@contextmanager
def locked(
    mark: Path, refusal: Callable[[str], str], *, inherited: bool = False, patience: float = 0.0
) -> Iterator[int]:
    """Hold a lock; yields its descriptor.

    Parameters
    ----------
    mark : the lock file, which is removed at the end.
    refusal : message if another process holds the lock, made of the name of that process.
    inherited : whether child processes get the descriptor, and hold the lock until the last of them has ended, even if
        this process is killed; the lock file then stays, so that none of them holds a file without a name.
    patience : seconds to wait for the lock.

    Raises LockedError if another process holds it, OutputError if the lock file cannot be written.
    """
    end = time.monotonic() + patience
    with _written(mark.parent):
        while (taken := _taken(mark)) is None:
            if time.monotonic() >= end:
                remedy = f"; if that process has ended, remove {mark}" if mark.parent.resolve() in _LOCKLESS else ""
                raise LockedError(refusal(holder(mark)) + remedy)
            time.sleep(0.02)
    descriptor, real = taken
    try:
        with _written(mark.parent):
            os.ftruncate(descriptor, 0)
            since = time.strftime("%Y-%m-%d %H:%M:%S")
            os.pwrite(descriptor, f"process {os.getpid()} on {socket.gethostname()} since {since}".encode(), 0)
        yield descriptor
    finally:
        if not (inherited and real):
            # Removed while it is locked: a waiting process sees that it has no name any more, and makes a new one.
            mark.unlink(missing_ok=True)
        os.close(descriptor)


def _taken(mark: Path) -> tuple[int, bool] | None:
    """Descriptor of a lock that is now held, and whether it is flock's; None if another process holds it."""
    try:
        descriptor, new = os.open(mark, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666), True
    except FileExistsError:
        try:
            descriptor, new = os.open(mark, os.O_RDWR), False
        except FileNotFoundError:  # released meanwhile; to make it here would make a lock that nobody holds
            return _taken(mark)
    try:
        real = _flock(descriptor, mark.parent)
        named = _is_at(mark, descriptor)
        if named and (real or (real is False and new)):
            return descriptor, real
        if named and real is False and _was_left(mark) and _is_at(mark, descriptor):
            mark.unlink(missing_ok=True)
            named = False
    except BaseException:
        os.close(descriptor)
        raise
    os.close(descriptor)
    return None if named else _taken(mark)


def _flock(descriptor: int, place: Path) -> bool | None:
    """Whether flock holds the file now; None if it does for another process, False where there is no flock."""
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):  # the latter on some network file systems
        return None
    except OSError as error:
        if error.errno not in _WITHOUT_LOCKS:
            raise
        if place.resolve() not in _LOCKLESS:
            _LOCKLESS.add(place.resolve())
            said = "this file system has no locks; a file there that names this process keeps others out instead"
            logging.getLogger(__name__).warning("%s: %s", place, said)
        return False
    return True


def _is_at(mark: Path, descriptor: int) -> bool:
    try:
        return os.path.samestat(mark.stat(), os.fstat(descriptor))
    except FileNotFoundError:
        return False


def holder(mark: Path) -> str:
    """Process and host that lock a file, from the lock file beside it."""
    try:
        return mark.read_text(errors="replace") or "another process"
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
