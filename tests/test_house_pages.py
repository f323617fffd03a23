"""The pages that describe the house are true: every path stands, every class is listed."""

from __future__ import annotations

import re
from pathlib import Path

from docs import make_glossary

ROOT = Path(__file__).parents[1]
HOUSE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")


def test_every_path_of_the_page_stands() -> None:
    named = [p for p in re.findall(r"`((?:compensator|stiffness|toolpaths|tests)/[\w/.]*)`", HOUSE)]
    assert len(named) > 30
    assert [p for p in named if "NAME" not in p and not (ROOT / p).exists()] == []


def test_every_folder_of_the_picture_stands() -> None:
    from docs.make_architecture_picture import FOLDERS, WAY_OF_A_POSE, WAY_OF_A_READING

    assert [name for name in FOLDERS if not (ROOT / name).exists()] == []
    assert {*WAY_OF_A_POSE, *WAY_OF_A_READING} <= set(FOLDERS)


def test_the_glossary_lists_every_class() -> None:
    page = make_glossary.PAGE.read_text(encoding="utf-8")
    assert page == make_glossary.page(make_glossary.terms())
    assert all(what for _, _, what in make_glossary.classes())


def test_a_term_stands_once() -> None:
    terms = re.findall(r"^\| ([^|`]+?) \|", make_glossary.terms(), re.MULTILINE)
    named = [t for t in terms if t not in {"term", "---"}]
    assert len(named) > 50 and len(named) == len(set(named))
