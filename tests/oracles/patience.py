"""Guards against hangs and lost memory: no measure of speed, which is what benchmarks/ are for."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

#: What to put before a command whose memory is judged: on Linux a child begins with the peak of its parent (getrusage),
#: which a small shell between the two resets.
OWN_PEAK = ("sh", "-c", '"$@"; exit $?', "sh")


@contextmanager
def not_hanging(seconds: float = 120.0) -> Iterator[None]:
    """Fails what takes so much of the process's time: a hundred times of what it needs, so that only a hang does."""

    def fail(number: int, frame: FrameType | None) -> None:
        raise AssertionError(f"it hangs: {seconds:g} s of processor time are over")

    if not hasattr(signal, "SIGVTALRM"):
        yield
        return
    before = signal.signal(signal.SIGVTALRM, fail)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)
