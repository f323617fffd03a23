"""Studies on several processes: of this machine, and of a Dask cluster one of whose workers is killed on the way."""

from __future__ import annotations

import os
import signal
from multiprocessing import util
from pathlib import Path

import pytest

from compensator.place import study as study_module
from compensator.place import workers
from compensator.place.parts import Parts
from compensator.tasks.place import place_file
from tests.compensator import small_job
from tests.compensator.place import placement_job

distributed = pytest.importorskip("distributed", reason="dask.distributed is not installed")


def study(files: small_job.Files, name: str, **options) -> bytes:
    place_file(
        files.toolpath, files.cell, files.out / name, within="x=1100:2000:6,y=-300:300:4", turns=4, poses=20, **options
    )
    return (files.out / name).read_bytes()


@pytest.fixture
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> small_job.Files:
    monkeypatch.setattr(study_module, "POSTURES", 640)  # a task for each placement
    return placement_job.files(tmp_path)


@pytest.mark.filterwarnings("ignore")  # of dask, about the worker that dies
def test_a_killed_worker_of_a_cluster_costs_its_tasks_only(
    files: small_job.Files, monkeypatch: pytest.MonkeyPatch
) -> None:
    undisturbed = study(files, "local.parquet", workers=1)
    parts: list[range] = []
    written = Parts.write
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    ) as cluster:
        victim = next(iter(cluster.workers.values())).pid

        def kills(self: Parts, batch: range, rows) -> None:
            written(self, batch, rows)
            parts.append(batch)
            if len(parts) == 3:
                os.kill(victim, signal.SIGKILL)

        monkeypatch.setattr(Parts, "write", kills)
        assert study(files, "cluster.parquet", scheduler=cluster.scheduler_address) == undisturbed
        now = [w.pid for w in cluster.workers.values()]
    assert victim not in now
    assert sorted(b.start for b in parts) == list(range(24))  # each task once


def test_a_killed_local_process_costs_its_tasks_only(files: small_job.Files, monkeypatch: pytest.MonkeyPatch) -> None:
    undisturbed = study(files, "one.parquet", workers=1)
    pools: list[int] = []
    pool = workers.ProcessPoolExecutor

    class Watched(pool):
        def submit(self, *args, **options):
            future = super().submit(*args, **options)
            if not pools:
                pools.append(next(iter(self._processes)))
            return future

    written, parts = Parts.write, list[range]()

    def kills(self: Parts, batch: range, rows) -> None:
        written(self, batch, rows)
        parts.append(batch)
        if len(parts) == 3:
            os.kill(pools[0], signal.SIGKILL)

    monkeypatch.setattr(Parts, "write", kills)
    monkeypatch.setattr(workers, "ProcessPoolExecutor", Watched)
    assert study(files, "two.parquet", workers=2) == undisturbed
    assert len(pools) == 1


@pytest.mark.skipif(not hasattr(signal, "SIGALRM"), reason="no alarm to end a test that hangs")
def test_a_process_that_dies_at_its_very_start_does_not_hold_the_study(
    files: small_job.Files, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is killed before it has read anything; the study is larger than the pipe to it takes."""
    undisturbed = study(files, "one.parquet", workers=1)
    packed, spawn, killed = workers.packed, util.spawnv_passfds, list[int]()

    def kills(path, args, passfds) -> int:
        pid: int = spawn(path, args, passfds)
        if not killed and any(b"multiprocessing-fork" in os.fsencode(a) for a in args):
            killed.append(pid)
            os.kill(pid, signal.SIGKILL)
        return pid

    def hangs(*_: object) -> None:
        raise TimeoutError("the study hangs")

    monkeypatch.setattr(util, "spawnv_passfds", kills)
    monkeypatch.setattr(workers, "packed", lambda study: packed(study) + bytes(1 << 20))  # pickle stops at its end
    before = signal.signal(signal.SIGALRM, hangs)
    signal.alarm(300)
    try:
        assert study(files, "two.parquet", workers=2) == undisturbed
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
    assert len(killed) == 1
