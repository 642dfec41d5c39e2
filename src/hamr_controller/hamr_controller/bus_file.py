"""The file behind the servo bus: where it lies, who owns it, and how dead ones go away.

One file per simulator life. The simulator writes it complete under another name and renames it into place, so nobody ever maps half a
file and a mapped file is never started anew: a driver that lost its simulator maps the next file. Who holds which end is a lock on one
byte of the file that the kernel drops when its holder dies, however it dies; the process ids in the header are for messages only.
"""

from __future__ import annotations

import fcntl
import mmap
import os
import re
import struct
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from enum import IntEnum
from pathlib import Path

import numpy as np

from hamr_description.errors import ConfigError

MAGIC = int.from_bytes(b"HAMRbus\0", "little")
LAYOUT_VERSION = 1
SIZE = 512  # bytes; see hamr_controller.bus for what lies where
MAGIC_WORD, LAYOUT_WORD, GENERATION_WORD, SIMULATOR_PID_WORD = range(4)
_FLOCK = "hhqqi0q"  # struct flock of Linux on 64 bits: type, whence, start, length, pid


class Role(IntEnum):
    """An end of the bus; the value is the byte that its holder locks."""

    SIMULATOR = 0
    DRIVER = 1


class BusTaken(ConfigError):
    """Another living process holds this end of the bus."""


def run_directory() -> Path:
    """The user's own directory for files that live as long as a run; made if missing, ConfigError if it is someone else's."""
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    path = Path(runtime, "hamr") if runtime else Path(tempfile.gettempdir(), f"hamr-{os.getuid()}")
    path.mkdir(mode=0o700, parents=True, exist_ok=True)
    if path.stat().st_uid != os.getuid():
        raise ConfigError(f"The run directory {path} belongs to another user: set XDG_RUNTIME_DIR to a directory of your own.")
    return path


def bus_path(run: str) -> Path:
    """The bus file of a run: one per ROS domain and run name."""
    if not re.fullmatch(r"[A-Za-z0-9_-]+", run):
        raise ConfigError(f"The run name '{run}' does not fit: use letters, digits, '_' and '-' only.")
    return run_directory() / f"bus-{os.environ.get('ROS_DOMAIN_ID') or 0}-{run}"


class BusFile:
    """A mapped bus file: the same memory as int64 `words` and float64 `reals`."""

    def __init__(self, path: Path, *, create: bool = False):
        self.path = path
        self._fd = os.open(path, os.O_RDWR | (os.O_CREAT | os.O_TRUNC if create else 0), 0o600)
        try:
            if create:
                os.ftruncate(self._fd, SIZE)
            if os.fstat(self._fd).st_size != SIZE:
                raise self._foreign()
            memory = mmap.mmap(self._fd, SIZE)
        except BaseException:
            os.close(self._fd)
            raise
        self.words, self.reals = np.frombuffer(memory, np.int64), np.frombuffer(memory, np.float64)
        if not create and (self.words[MAGIC_WORD], self.words[LAYOUT_WORD]) != (MAGIC, LAYOUT_VERSION):
            self.close()
            raise self._foreign()

    def _foreign(self) -> ConfigError:
        return ConfigError(f"{self.path} is not a servo bus of this version of hamr_controller: stop what uses it and delete it.")

    def lock(self, role: Role) -> bool:
        """Take an end; False if another holds it."""
        try:
            fcntl.fcntl(self._fd, fcntl.F_OFD_SETLK, struct.pack(_FLOCK, fcntl.F_WRLCK, os.SEEK_SET, role, 1, 0))
        except BlockingIOError:
            return False
        return True

    def held(self, role: Role) -> bool:
        """Whether a living process other than the asker holds an end."""
        answer = fcntl.fcntl(self._fd, fcntl.F_OFD_GETLK, struct.pack(_FLOCK, fcntl.F_WRLCK, os.SEEK_SET, role, 1, 0))
        return struct.unpack(_FLOCK, answer)[0] != fcntl.F_UNLCK

    def is_at_path(self) -> bool:
        """Whether the name still leads to this file."""
        try:
            return os.path.samestat(os.fstat(self._fd), os.stat(self.path))
        except FileNotFoundError:
            return False

    def close(self) -> None:
        """Give up what is held; the memory stays mapped, through a descriptor of its own, as long as arrays refer to it."""
        if self._fd >= 0:
            fcntl.fcntl(self._fd, fcntl.F_OFD_SETLK, struct.pack(_FLOCK, fcntl.F_UNLCK, os.SEEK_SET, 0, 0, 0))
            os.close(self._fd)
            self._fd = -1


@contextmanager
def _directory_lock(directory: Path) -> Iterator[None]:
    with open(directory / "lock", "w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _sweep(directory: Path) -> None:
    """Remove the bus files whose simulator is gone."""
    for path in directory.glob("bus-*"):
        try:
            file = BusFile(path)
        except (ConfigError, FileNotFoundError):
            continue  # not ours to judge; whoever opens it gets the sentence
        if not file.held(Role.SIMULATOR):
            path.unlink()
        file.close()


def create(path: Path) -> BusFile:
    """A new bus file with the simulator's end held.

    Raises:
        BusTaken: a living simulator has this bus.
    """
    with _directory_lock(path.parent):
        _sweep(path.parent)
        if path.exists():
            file = BusFile(path)
            pid = file.words[SIMULATOR_PID_WORD]
            file.close()
            raise BusTaken(f"A simulator (process {pid}) already runs on {path}: stop it, or set another 'run' or ROS_DOMAIN_ID.")
        file = BusFile(path.with_name(f"new-{path.name}"), create=True)
        file.words[[MAGIC_WORD, LAYOUT_WORD, GENERATION_WORD, SIMULATOR_PID_WORD]] = MAGIC, LAYOUT_VERSION, time.time_ns(), os.getpid()
        file.lock(Role.SIMULATOR)
        os.rename(file.path, path)
        file.path = path
    return file


def remove(file: BusFile) -> None:
    """The simulator's end of a bus's life."""
    with _directory_lock(file.path.parent):
        if file.is_at_path():
            file.path.unlink()
    file.close()
