"""The page of `view` in a browser: an edit is computed and seen, a refusal is told, the cell is saved."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING

import pytest

from compensator.tasks.view import view_server
from tests.compensator.report.browser import opened
from tests.compensator.report.small_path import prepared

if TYPE_CHECKING:
    from playwright.sync_api import Page

HOSTILE = "<img src=x onerror=window.hit=1>"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cell whose tool, and whose file, have hostile names."""
    made = prepared(tmp_path_factory.mktemp("view"))
    (made / f"{HOSTILE}.csv").write_text((made / "circle.csv").read_text())
    return made


@pytest.fixture(scope="module")
def shown(folder: Path) -> Iterator[tuple[Page, list[str]]]:
    with view_server(folder / "cell.toml", [folder / f"{HOSTILE}.csv"]) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        with opened(server.url) as page:
            yield page
        server.shutdown()


def told(page: Page, text: str) -> str:
    page.locator(".told", has_text=text).wait_for()
    return page.locator(".told").inner_text()


def press_enter(page: Page) -> None:
    with page.expect_response("**/edit"):
        page.keyboard.press("Enter")


def test_an_edit_is_computed_and_seen(shown: tuple[Page, list[str]]) -> None:
    page, _ = shown
    tip, before = page.evaluate("sceneView.placement(7)"), page.locator(".three b").all_inner_texts()
    of_file = page.locator(".three small")
    assert of_file.all_inner_texts() == ["", "", ""]
    page.locator("[name='workobject|xyz|1']").fill("150")
    press_enter(page)
    assert "the file is as it was" in told(page, "computed in")
    moved = page.evaluate("sceneView.placement(7)")
    assert moved[7] - tip[7] == pytest.approx(0.25, abs=0.1)
    page.locator("[name='tool|xyz|2']").fill("500")
    press_enter(page)
    told(page, "computed in")
    assert page.locator(".three b").all_inner_texts() != before
    assert of_file.all_inner_texts() == [f"the cell in the file: {value}" for value in before]
    page.get_by_role("button", name="back to the file").click()
    of_file.first.filter(has_not_text="file").wait_for(state="attached")
    assert page.locator(".three b").all_inner_texts() == before


def test_out_of_reach_is_told_and_the_arm_stays(shown: tuple[Page, list[str]]) -> None:
    page, _ = shown
    tip = page.evaluate("sceneView.placement(7)")
    page.locator("[name='workobject|xyz|0']").fill("4000")
    page.get_by_role("button", name="compute").click()
    assert ".csv:" in told(page, ".csv:")
    assert page.evaluate("sceneView.placement(7)") == tip
    page.get_by_role("button", name="back to the file").click()
    told(page, "computed in")
    assert page.locator("[name='workobject|xyz|0']").input_value() == "1500"


def test_the_cell_is_saved(shown: tuple[Page, list[str]], folder: Path) -> None:
    page, _ = shown
    page.locator("[name='tool|rpy|2']").fill("90")
    page.get_by_role("button", name="save", exact=True).click()
    assert told(page, "saved as").endswith("cell-2.toml")
    assert "rpy = [0.0, 0.0, 90.0]" in (folder / "cell-2.toml").read_text()
    page.get_by_role("button", name="save", exact=True).click()
    told(page, "stands there already")


def test_nothing_complained_and_no_name_became_a_script(shown: tuple[Page, list[str]]) -> None:
    page, complaints = shown
    assert HOSTILE in page.locator("p.quiet").first.inner_text()
    assert page.evaluate("window.hit") is None and page.locator("img").count() == 0
    assert complaints == []
