"""The arm at work in a browser: it moves, findings jump, the keyboard is enough, nothing is fetched."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from compensator.report.html.path import path_page
from compensator.solve.compensation import Compensation
from tests.compensator.report.browser import opened

if TYPE_CHECKING:
    from playwright.sync_api import Page

HOSTILE = "</script><img src=x onerror=window.hit=1>\"'"
Run = tuple[Compensation, dict[str, Any]]


@pytest.fixture(scope="module")
def shown(run: Run, tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Page, list[str]]]:
    """The report in a browser, its last finding about pose 40; comments of the file are hostile."""
    c, report = run
    line = int(c.path.toolpath.line[40])
    about = {"level": "warning", "kind": "path", "what": HOSTILE, "remedy": "", "count": 1}
    found = [*report["findings"], {**about, "where": f"a.csv:{line} (pose 40)", "source_line": line}]
    file = tmp_path_factory.mktemp("page") / "report.html"
    texts = {int(k): HOSTILE for k in c.path.toolpath.line}
    file.write_text(path_page(c, {**report, "findings": found}, np.full(len(c), 3e-8), texts=texts))
    with opened(file.as_uri()) as page:
        yield page


def tip(page: Page, side: str = "before") -> list[float]:
    m = page.evaluate(f"sceneView.placement(7, '{side}')")
    return [m[3], m[7], m[11]]


def pixels(page: Page) -> bytes:
    picture: bytes = page.locator(".scene canvas").screenshot()
    return picture


def test_the_slider_moves_the_arm(shown: tuple[Page, list[str]], run: Run) -> None:
    page, _ = shown
    c, _ = run
    page.evaluate("sceneView.enlarge(1), sceneView.go(0)")
    before = pixels(page)
    slider = page.locator("[data-do=walk]")
    slider.fill("30")
    assert tip(page) == pytest.approx(c.before[30].tolist(), abs=5e-6)
    assert tip(page, "after") == pytest.approx(c.path.tcp.origin[30].tolist(), abs=5e-6)
    assert f"line {c.path.toolpath.line[30]}, pose 30" in page.locator(".where").inner_text()
    assert pixels(page) != before


def test_deflection_is_enlarged_by_the_factor(shown: tuple[Page, list[str]], run: Run) -> None:
    page, _ = shown
    c, _ = run
    page.evaluate("sceneView.go(30)")
    drawn = pixels(page)
    page.locator("[data-do=factor]").fill("1000")
    assert page.locator("[data-show=factor]").inner_text() == "2000"
    moved = np.array(tip(page)) - c.path.tcp.origin[30]
    assert moved == pytest.approx(2000 * c.error_before[30], abs=0.01)
    assert pixels(page) != drawn


def test_a_finding_jumps_to_its_pose(shown: tuple[Page, list[str]]) -> None:
    page, _ = shown
    page.evaluate("sceneView.go(3)")
    page.locator(".found button", has_text="onerror").click()
    assert page.locator("[data-do=walk]").input_value() == "40"
    assert "pose 40" in page.locator(".where").inner_text()


def test_joints_and_lamps_follow(shown: tuple[Page, list[str]], run: Run) -> None:
    page, _ = shown
    c, _ = run
    page.evaluate("sceneView.go(20)")
    q = np.degrees(c.path.q[20])
    said = [row.split("°")[0].split()[-1] for row in page.locator(".joints tr").all_inner_texts()]
    assert [float(v) for v in said] == pytest.approx(q.tolist(), abs=0.051)
    lamps = page.locator(".lamp").evaluate_all("all => all.map(lamp => lamp.style.visibility)")
    assert lamps == ["visible"] * 4 + ["hidden", "visible"]  # joint 5 has no gap


def test_both_sides_stand_beside_each_other(shown: tuple[Page, list[str]]) -> None:
    page, _ = shown
    page.get_by_label("both").check()
    assert page.locator(".titles span").all_inner_texts() == ["as the file stands", "with the program"]
    page.get_by_label("as the file stands").check()


def test_the_keyboard_is_enough(shown: tuple[Page, list[str]]) -> None:
    page, _ = shown
    page.evaluate("document.activeElement.blur(), sceneView.go(10)")
    page.keyboard.press("ArrowRight")
    assert page.evaluate("sceneView.at") == 11
    page.keyboard.press(" ")
    assert page.evaluate("sceneView.playing") is True
    for _ in range(100):
        page.wait_for_timeout(100)
        if page.evaluate("sceneView.at") > 11.2:
            break
    assert page.evaluate("sceneView.at") > 11.2
    page.keyboard.press(" ")
    assert page.evaluate("sceneView.playing") is False
    drawn = page.evaluate("sceneView.stage.camera.position.toArray()")
    page.locator(".scene canvas").focus()
    for key in ("ArrowLeft", "ArrowUp", "+"):
        page.keyboard.press(key)
    assert page.evaluate("sceneView.stage.camera.position.toArray()") != pytest.approx(drawn, abs=0.05)
    reached = set()
    for _ in range(30):
        page.keyboard.press("Tab")
        reached.add(page.evaluate("document.activeElement.dataset.do || document.activeElement.type"))
    assert {"play", "walk", "speed", "colour", "factor", "checkbox", "arm", "button"} <= reached


def test_the_path_takes_another_colour(shown: tuple[Page, list[str]]) -> None:
    page, _ = shown
    drawn = pixels(page)
    page.locator("[data-do=colour]").select_option("reversals")
    assert "joint that reversed last" in page.locator(".scene .legend").inner_text()
    assert pixels(page) != drawn


def test_it_fits_a_tablet(shown: tuple[Page, list[str]]) -> None:
    page, _ = shown
    page.set_viewport_size({"width": 768, "height": 1024})
    assert page.evaluate("document.documentElement.scrollWidth") <= 768
    box = page.locator("[data-do=play]").bounding_box()
    assert box is not None and box["y"] + box["height"] < 1024


def test_figures_below_are_drawn_when_they_are_looked_at(shown: tuple[Page, list[str]]) -> None:
    page, _ = shown
    page.locator("#joints").scroll_into_view_if_needed()
    page.wait_for_selector("#joints .main-svg", state="attached")


def test_nothing_complained_and_no_script_of_a_file_ran(shown: tuple[Page, list[str]]) -> None:
    """The last test of this file: all others have clicked about."""
    page, complaints = shown
    assert HOSTILE in page.locator(".where code").inner_text()
    assert page.evaluate("window.hit") is None and page.locator("img").count() == 0
    assert complaints == []
