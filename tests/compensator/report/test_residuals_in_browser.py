"""The page of diagnose in a browser: the arm stands as in every set-up, with the arrows of its readings."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

from tests.compensator.conftest import Sick
from tests.compensator.report.browser import opened

if TYPE_CHECKING:
    from playwright.sync_api import Page

Shown = tuple["Page", list[str]]


@pytest.fixture(scope="module")
def shown(loose: Sick) -> Iterator[Shown]:
    with opened((loose.folder / "report.html").as_uri()) as page:
        yield page


def canvas(page: Page) -> bytes:
    picture: bytes = page.locator(".scene canvas").screenshot()
    return picture


def test_every_set_up_is_a_posture_with_its_arrows(shown: Shown) -> None:
    page, complaints = shown
    page.evaluate("sceneView.go(0)")
    first, words = canvas(page), page.locator(".where").inner_text()
    page.locator("[data-do=walk]").fill("5")
    other = page.locator(".where").inner_text()
    numbers = [re.search(r"set-up (\d+)", text) for text in (words, other)]
    assert all(numbers) and words != other
    assert canvas(page) != first
    assert complaints == []


def test_arrows_are_enlarged_by_the_factor(shown: Shown) -> None:
    page, complaints = shown
    page.evaluate("sceneView.go(0)")
    page.locator("[data-do=factor]").fill("0")
    small = canvas(page)
    page.locator("[data-do=factor]").fill("1000")
    assert page.locator("[data-show=factor]").inner_text() == "2000"
    assert canvas(page) != small
    assert complaints == []


def test_after_what_was_added_the_arrows_are_short(shown: Shown) -> None:
    """m, over all set-ups: the gap that was added explains what the model at hand left."""
    page, _ = shown
    before, after = (
        page.evaluate(f"Math.hypot(...sceneView.stage.residuals.sides['{side}'].size)") for side in ("before", "after")
    )
    assert 0 < after < 0.6 * before
