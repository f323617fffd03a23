"""Workers: the tasks of a study on local processes or on a Dask cluster; both run ``judged``.

The study is sent to every worker once; to local ones as a file. What a process is given at its start goes through a
pipe whose other end its parent holds as well until all is in it: more than the pipe takes, some 64 kB, and a process
that dies before it has read would never let its parent go on. A worker that dies costs the tasks that it had: they are
done again. Each local process is a pool of its own: a pool of several starts them one by one, and one that is started
while it finds another dead is never told to end (ProcessPoolExecutor of CPython 3.11: it then waits for it for ever).
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack
from dataclasses import replace
from functools import lru_cache
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Lock, Thread
from typing import Any

from compensator.errors import CompensatorError
from compensator.place.address import SECONDS, refuse_silent
from compensator.place.judge import Judge, Judgement
from compensator.place.study import Study

Done = tuple[range, list[Judgement]]
DEATHS = 5  # pools that may break before the study is given up: something in it kills its workers
_ALONE = Lock()


@lru_cache(maxsize=1)
def _judge(sent: bytes) -> Judge:
    study: Study = pickle.loads(sent)
    return Judge(study)


def packed(study: Study) -> bytes:
    """The study as it is sent: without what the arm has computed here."""
    return pickle.dumps(replace(study, arm=replace(study.arm)))


def judged(sent: bytes, start: int, stop: int) -> list[Judgement]:
    """The judgements of some candidates; ``sent``: the study, pickled."""
    with _ALONE:  # threads of one worker share its judge
        judge = _judge(sent)
        return [judge.row(k) for k in range(start, stop)]


def here(study: Study, batches: Sequence[range]) -> Iterator[Done]:
    """All tasks in this process."""
    judge = Judge(study)
    for batch in batches:
        yield batch, [judge.row(k) for k in batch]


_SENT: list[bytes] = []  # of a local worker: the study


def _receive(sent: str) -> None:
    Thread(target=_end_with_parent, daemon=True).start()
    _SENT[:] = [Path(sent).read_bytes()]


def _end_with_parent() -> None:
    """Wait for the end of the process that started this one: a parent that was killed can end none of its workers."""
    if (parent := multiprocessing.parent_process()) is not None:
        parent.join()
        os._exit(1)


def _local(start: int, stop: int) -> list[Judgement]:
    return judged(_SENT[0], start, stop)


def on_processes(study: Study, batches: Sequence[range], count: int) -> Iterator[Done]:
    """All tasks on ``count`` processes of this machine, in the order that they are done.

    Raises:
        CompensatorError: processes die again and again.
    """
    if count < 2 or len(batches) < 2:
        yield from here(study, batches)
        return
    left = list(batches)
    with TemporaryDirectory(prefix="compensator-") as folder:
        sent = Path(folder) / "study"
        sent.write_bytes(packed(study))
        for _ in range(DEATHS):
            done = set()
            try:
                for batch, found in _on_pools(str(sent), left, min(count, len(left))):
                    done.add(batch)
                    yield batch, found
                return
            except BrokenProcessPool:
                left = [b for b in left if b not in done]
    raise CompensatorError(f"local processes died {DEATHS} times: is there memory enough? Try --workers 1")


def _on_pools(sent: str, batches: Sequence[range], count: int) -> Iterator[Done]:
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    context = multiprocessing.get_context("spawn")
    with ExitStack() as stack:
        pools = [ProcessPoolExecutor(1, context, _receive, (sent,)) for _ in range(count)]
        left, busy = iter(batches), dict[Future[list[Judgement]], tuple[ProcessPoolExecutor, range]]()

        def employ(pool: ProcessPoolExecutor) -> None:
            for b in islice(left, 1):
                busy[pool.submit(_local, b.start, b.stop)] = pool, b

        for pool in pools:
            employ(stack.enter_context(pool))
        while busy:
            for future in wait(busy, return_when=FIRST_COMPLETED).done:
                pool, batch = busy.pop(future)
                yield batch, future.result()
                employ(pool)


def on_cluster(study: Study, batches: Sequence[range], address: str) -> Iterator[Done]:
    """All tasks on a Dask cluster, in the order that they are done.

    Raises:
        CompensatorError: dask is not installed, no scheduler answers, or it has no workers.
    """
    with _client(address) as client:
        from distributed import as_completed

        if not client.scheduler_info(n_workers=-1)["workers"]:
            raise CompensatorError(f"--scheduler {address}: it has no workers: start some with `dask worker {address}`")
        sent = client.scatter(packed(study), broadcast=True, hash=False)
        waiting = {client.submit(judged, sent, b.start, b.stop, pure=False, retries=DEATHS): b for b in batches}
        for future in as_completed(list(waiting), loop=client.loop):
            yield waiting.pop(future), future.result()


def _client(address: str) -> Any:
    try:
        from distributed import Client
    except ImportError as e:
        what = "--scheduler needs dask.distributed: pip install 'toolpath-compensator[cluster]'"
        raise CompensatorError(what) from e
    refuse_silent(address)  # a client that fails waits for its own end in its __del__
    try:
        return Client(address, timeout=SECONDS, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as e:
        raise CompensatorError(f"--scheduler {address}: no scheduler answers there within {SECONDS:g}s: {e}") from e
