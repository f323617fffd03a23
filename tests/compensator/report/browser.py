"""A headless Chromium for tests of pages; tests that ask for it are skipped where there is none."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Page

CHROMIUM = os.environ.get("CHROMIUM", shutil.which("chromium") or "/usr/bin/chromium")
FLAGS = [
    *("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic"),
    *("--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"),
]
SLOW = 60_000  # ms: a machine without a graphics card draws slowly


@contextmanager
def opened(url: str, *, width: int = 900, height: int = 700) -> Iterator[tuple[Page, list[str]]]:
    """A page with what it complains about."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if not os.path.exists(CHROMIUM):
        pytest.skip(f"no Chromium at {CHROMIUM}: apt-get install chromium, or set CHROMIUM")
    complaints: list[str] = []
    with playwright.sync_playwright() as p:
        browser = p.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = browser.new_page(viewport={"width": width, "height": height})
        page.set_default_timeout(SLOW)
        page.on("console", lambda m: complaints.append(m.text) if m.type == "error" else None)
        page.on("pageerror", lambda e: complaints.append(str(e)))
        asked = lambda r: None if r.url.startswith(ours(url)) else complaints.append(f"asked for {r.url}")  # noqa: E731
        page.on("request", asked)
        page.goto(url)
        yield page, complaints
        browser.close()


def ours(url: str) -> tuple[str, ...]:
    """What a page may ask for: what it carries, and its own server."""
    return (url.split("?")[0] if url.startswith("http") else url, "data:", "blob:")
