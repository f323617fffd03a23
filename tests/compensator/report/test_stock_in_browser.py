"""The stock in a browser: it shrinks along the slider, and stays hidden where a reader hides it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

from compensator.report.html.path import path_page
from compensator.tasks.compensate import preview_file
from tests.compensator import small_job
from tests.compensator.report.browser import opened

if TYPE_CHECKING:
    from playwright.sync_api import Page


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Page, list[str]]]:
    """The report of a milled path, at the cut, with nothing shown but what is left of the stock."""
    folder = tmp_path_factory.mktemp("milled")
    job = small_job.files(folder, {"process": small_job.milling(folder)})
    done = preview_file(folder / "path.csv", job.cell)
    (folder / "report.html").write_text(path_page(done.result, done.report))
    with opened((folder / "report.html").as_uri()) as (page, complaints):
        page.locator("[data-do=cut]").click()
        for box in page.locator(".layers input").all():
            box.set_checked(box.get_attribute("value") == "left")
        yield page, complaints


def drawn(page: Page, share: float) -> bytes:
    """What the canvas shows with the slider there."""
    slider = page.locator("[data-do=walk]")
    slider.fill(str(round(share * int(slider.get_attribute("max") or 0))))
    picture: bytes = page.locator(".scene canvas").screenshot()
    return picture


def test_the_stock_shrinks_along_the_slider(shown: tuple[Page, list[str]]) -> None:
    page, complaints = shown
    first, middle, last = drawn(page, 0.0), drawn(page, 0.5), drawn(page, 1.0)
    assert len({first, middle, last}) == 3
    assert drawn(page, 0.0) == first and drawn(page, 0.5) == middle  # and grows back
    assert complaints == []


def test_the_small_plotly_draws_every_figure(shown: tuple[Page, list[str]]) -> None:
    """A kind of curve that the library lacks would be drawn as another, or the numbers of a mesh not be read."""
    page, complaints = shown
    for name in ("path", "cut", "cut_along", "along", "joints"):
        page.locator(f"#{name}").scroll_into_view_if_needed()
        page.wait_for_selector(f"#{name} .main-svg", state="attached")
    kinds = page.evaluate("document.getElementById('cut')._fullData.map(trace => [trace.type, trace.visible])")
    assert kinds[0] == ["mesh3d", True] and {kind for kind, _ in kinds[1:]} == {"scatter3d"}
    corners, faces = page.evaluate("(({x, i}) => [x.length, i.length])(document.getElementById('cut')._fullData[0])")
    assert 500 < corners < faces < 2.1 * corners
    assert complaints == []


def test_what_is_hidden_stays_hidden(shown: tuple[Page, list[str]]) -> None:
    page, _ = shown
    box = page.locator(".layers input[value=left]")
    with_it = drawn(page, 0.5)
    box.uncheck()
    without = drawn(page, 0.5)
    assert without != with_it
    assert drawn(page, 0.0) == without == drawn(page, 1.0)
    box.check()
    assert drawn(page, 0.5) == with_it
