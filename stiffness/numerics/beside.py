"""Beside: work of a long path that another process does while this one goes on.

Python runs one thread at a time, and most of what is done with a path is Python and short calls of numpy. A forked
process sees the whole path without a copy; what it makes comes back through memory that both share. It is the same work
on the same numbers wherever it is done: no result depends on the cores.

Where that cannot be (one core, a short path, a system without fork, threads of others that might hold a lock), and
where the other process fails for whatever reason, the work is done here, when its result is asked for.
"""

from __future__ import annotations

import gc
import io
import mmap
import os
import pickle
import signal
import threading
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import is_dataclass
from typing import Any, Generic, TypeVar

import numpy as np

from stiffness.numerics.cores import cores, keep, left_with
from stiffness.numerics.kernel import POOL

A = TypeVar("A")
T = TypeVar("T")

_AT_WORK: ContextVar[bool] = ContextVar("at work", default=False)  # another process is: a further one may be, too

FROM = 30_000  # poses; below, a fork and what comes back cost more than they save
_ALIGNED = 64
_LENGTH = 8
_MANY = 1000  # objects; a longer list is not looked through


class Beside(Generic[T]):
    """Work that may already go on; ``with beside(...)`` makes it."""

    def __init__(self, work: Callable[[], T], known: Sequence[object], *, fork: bool) -> None:
        self._work, self._known, self._child, self._memory = work, _reachable(known) if fork else {}, 0, -1
        self._status: int | None = None
        if fork:
            self._memory = os.memfd_create("beside")
            self._child = _fork()
            if not self._child:
                self._serve()

    def __repr__(self) -> str:
        return f"Beside({'process ' + str(self._child) if self._child else 'here'})"

    @property
    def works(self) -> bool:
        """Whether another process is at it."""
        if self._child and self._status is None:
            child, status = os.waitpid(self._child, os.WNOHANG)
            self._status = status if child else None
        return bool(self._child) and self._status is None

    def result(self) -> T:
        """What the work gives; raises what it raises."""
        received = self._received()
        return received[0] if received else self._work()

    def found(self) -> T | None:
        """What the other process made; None where there is none, or where it failed, and the work can wait."""
        received = self._received()
        return received[0] if received else None

    def _received(self) -> list[T]:
        """What the other process made, alone in a list; an empty one where it made nothing."""
        if not self._child:
            return []
        try:
            if self.works:
                _, self._status = os.waitpid(self._child, 0)
            return [] if self._status else [_loads(self._memory, list(self._known.values()))]
        finally:
            self.drop()

    def drop(self) -> None:
        """End it where its result has not been asked for."""
        if self._child:
            if self.works:
                os.kill(self._child, signal.SIGKILL)
                os.waitpid(self._child, 0)
            self._child = 0
            os.close(self._memory)

    def _serve(self) -> None:
        """The life of the other process: it leaves nothing behind but what it has made."""
        status = 1
        try:
            signal.signal(signal.SIGINT, signal.SIG_IGN)  # the first process ends this one
            gc.freeze()  # what is looked through would be copied
            _dump(self._memory, self._work(), self._known)
            status = 0
        finally:
            os._exit(status)  # no handlers, no buffers of the first process


@contextmanager
def beside(work: Callable[[], T], *, known: Sequence[object], poses: int) -> Iterator[Beside[T]]:
    """Let another process work while this one goes on inside.

    Args:
        work: without side effects; it is done here where it cannot be done there, when ``result`` is asked for.
        known: what both have: objects and arrays in it come back as they are here, without a copy.
        poses: that it is about.
    """
    count = cores()
    fork = (count > 1 or _AT_WORK.get()) and poses >= FROM and _may_fork()
    theirs = max(count // 2, 1)
    if not fork:
        yield Beside(work, known, fork=False)
        return

    def there() -> T:
        keep(theirs)
        _AT_WORK.set(False)
        return work()

    other, token = Beside(there, known, fork=True), _AT_WORK.set(True)
    try:
        with left_with(lambda: max(count - theirs, 1) if other.works else count):
            yield other
    finally:
        _AT_WORK.reset(token)
        other.drop()


def halves(work: Callable[[A], T], things: Sequence[A], poses: int) -> list[T]:
    """What ``work`` makes of each thing, in their order: of the second half in another process, even where one is
    ``beside`` already: whichever of them is done first, no core is left idle.

    Args:
        work: as in ``beside``, but that it may write a file: done once more here, it writes the same one.
        poses: that all things are about.
    """
    half = (len(things) + 1) // 2
    if half == len(things):
        return [work(thing) for thing in things]
    with beside(lambda: [work(thing) for thing in things[half:]], known=(), poses=poses) as others:
        return [*(work(thing) for thing in things[:half]), *others.result()]


def _may_fork() -> bool:
    """Only a process whose other threads are idle ones of kernels: a lock of another one would never open again."""
    if not (hasattr(os, "fork") and hasattr(os, "memfd_create")):
        return False
    main = threading.main_thread()
    return threading.current_thread() is main and all(
        t is main or t.name.startswith(POOL) for t in threading.enumerate()
    )


def _fork() -> int:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # from 3.12 on, of the idle threads
        return os.fork()


class _Pickler(pickle.Pickler):
    """Objects that both processes have by their number, arrays of one value as that value."""

    def __init__(self, file: io.BytesIO, known: Mapping[int, object], buffers: list[pickle.PickleBuffer]) -> None:
        super().__init__(file, protocol=5, buffer_callback=buffers.append)
        self._number = {key: k for k, key in enumerate(known)}

    def persistent_id(self, obj: object) -> int | None:
        return self._number.get(id(obj))

    def reducer_override(self, obj: Any) -> Any:
        if isinstance(obj, np.ndarray) and obj.size > 1 and not any(obj.strides):
            return np.broadcast_to, (obj.flat[0], obj.shape)
        return NotImplemented


class _Unpickler(pickle.Unpickler):
    def __init__(self, file: io.BytesIO, known: Sequence[object], buffers: Sequence[memoryview]) -> None:
        super().__init__(file, buffers=buffers)
        self._known = known

    def persistent_load(self, pid: int) -> object:
        return self._known[pid]


def _dump(memory: int, made: object, known: Mapping[int, object]) -> None:
    text, buffers = io.BytesIO(), list[pickle.PickleBuffer]()
    _Pickler(text, known, buffers).dump(made)
    ends = list[tuple[int, int]]()
    with os.fdopen(os.dup(memory), "wb") as file:
        for part in (*(b.raw() for b in buffers), text.getbuffer()):
            file.write(bytes(-file.tell() % _ALIGNED))
            begin = file.tell()
            file.write(part)
            ends.append((begin, file.tell()))
        table = pickle.dumps(ends)
        file.write(table + len(table).to_bytes(_LENGTH, "little"))


def _loads(memory: int, known: Sequence[object]) -> Any:
    """Arrays stand in the memory that the other process wrote them to."""
    whole = memoryview(mmap.mmap(memory, 0, flags=mmap.MAP_PRIVATE, prot=mmap.PROT_READ | mmap.PROT_WRITE))
    size = int.from_bytes(whole[-_LENGTH:], "little")
    *parts, text = (whole[a:b] for a, b in pickle.loads(whole[-_LENGTH - size : -_LENGTH]))
    return _Unpickler(io.BytesIO(text), known, parts).load()


def _reachable(roots: Sequence[object]) -> dict[int, object]:
    """id -> object, of everything that dataclasses, mappings and sequences among ``roots`` hold."""
    found, open_ = dict[int, object](), list(roots)
    while open_:
        one = open_.pop()
        if id(one) in found or isinstance(one, str | bytes | int | float | bool | None):
            continue
        found[id(one)] = one
        if is_dataclass(one) and not isinstance(one, type):
            open_ += vars(one).values()  # what it holds, not what it would make
        elif isinstance(one, Mapping):
            open_ += one.values()
        elif isinstance(one, tuple | list) and len(one) <= _MANY:
            open_ += one
    return found
