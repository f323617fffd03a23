"""What `place` refuses before it begins; its local processes end with the one that started them."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

from compensator.errors import CompensatorError
from compensator.place.address import host_and_port, refuse_silent
from compensator.place.candidates import box
from compensator.place.workers import on_cluster
from compensator.tasks.place import place_file

HOME = type("Home", (), {"xyz": (1500.0, -100.0, 800.0), "rpy": (0.0, 0.0, 20.0)})()
PARENT = """
import multiprocessing, os, pathlib, signal, sys, time
from concurrent.futures import ProcessPoolExecutor
from compensator.place import workers

if __name__ == "__main__":
    pathlib.Path(sys.argv[1]).write_bytes(b"")
    pool = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), workers._receive, (sys.argv[1],))
    print(pool.submit(os.getpid).result(), flush=True)
    pool.submit(time.sleep, 600)
    time.sleep(600)
"""


@pytest.mark.parametrize("words", ["x=1.2:1.8:3", "x=1.2:1.8:3,y=-0.4:0.4:3,yaw=0:90:3", "z=0.8"])
def test_a_box_in_metres(words: str) -> None:
    with pytest.raises(CompensatorError, match=r"is this in m\? mm are expected.*--list"):
        box(words, HOME)


@pytest.mark.parametrize("words", ["yaw=0:9:3", "x=1200:1800:3,y=-4:4:3", "x=0", "y=-10:0:3"])
def test_boxes_that_are_not(words: str) -> None:
    """Angles alone, one length that is none of m, the base itself, the bound."""
    assert len(box(words, HOME).poses) in (1, 3, 9)


def test_an_axis_that_is_named_twice() -> None:
    with pytest.raises(CompensatorError, match=r"'x=1500': x is given twice"):
        box("x=1200:1800:3, y=0 , x=1500", HOME)


@pytest.mark.parametrize("address", ["localhost", "tcp://localhost", "http://h:80", "tcp://h:0", "tcp://h:99999"])
def test_an_address_of_another_form(address: str, tmp_path: Path) -> None:
    """Refused before a file is read."""
    with pytest.raises(CompensatorError, match=r"expected tcp://host:port"):
        place_file(tmp_path / "no.csv", tmp_path / "no.toml", tmp_path / "s.parquet", within="x=1", scheduler=address)


def test_addresses() -> None:
    assert host_and_port("tcp://10.0.0.5:8786") == ("10.0.0.5", 8786) == host_and_port("10.0.0.5:8786")
    assert host_and_port("tls://[::1]:8786") == ("::1", 8786)


def test_nothing_listens_there(capfd: pytest.CaptureFixture[str]) -> None:
    """At once, in one message, and without a client that is left over."""
    with socket.socket() as held:
        held.bind(("127.0.0.1", 0))  # bound, and not listened at
        address = f"tcp://127.0.0.1:{held.getsockname()[1]}"
        with pytest.raises(CompensatorError, match="no scheduler answers there"):
            refuse_silent(address)
        pytest.importorskip("distributed", reason="dask.distributed is not installed")
        with pytest.raises(CompensatorError, match="no scheduler answers there"):
            next(on_cluster(None, [], address))  # type: ignore[arg-type]
    assert capfd.readouterr().err == ""


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="no /proc to look for a process in")
def test_a_worker_ends_with_its_parent(tmp_path: Path) -> None:
    script = tmp_path / "parent.py"
    script.write_text(PARENT)
    here = Path(__file__).parents[3]
    asked = [sys.executable, str(script), str(tmp_path / "study")]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
    parent = subprocess.Popen(asked, **pipes, env={**os.environ, "PYTHONPATH": str(here)})
    assert parent.stdout is not None
    worker = int(parent.stdout.readline())
    assert running(worker)
    parent.send_signal(signal.SIGKILL)
    parent.wait()
    until = time.monotonic() + 60
    while running(worker) and time.monotonic() < until:
        time.sleep(0.05)
    ended = not running(worker)
    if not ended:
        os.kill(worker, signal.SIGKILL)
    parent.stdout.close()
    assert ended


def running(pid: int) -> bool:
    """Whether a process is there and is no zombie."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
