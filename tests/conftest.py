"""What several tests use."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of shared data beside the checkout; the test is skipped where there is none."""
    folder = Path(__file__).resolve().parents[2] / "shared"
    if not folder.is_dir():
        pytest.skip("no folder ../shared beside the checkout")
    return folder


@pytest.fixture
def may_fork(monkeypatch: pytest.MonkeyPatch) -> None:
    """Threads that earlier tests left (a browser's watcher, a cluster's pool) are idle: work may go on beside them."""
    left, all_threads = threading.enumerate(), threading.enumerate
    main = threading.main_thread()
    monkeypatch.setattr(threading, "enumerate", lambda: [t for t in all_threads() if t is main or t not in left])
