"""A reader of HTML pages for tests."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from typing import Any

from compensator.report.html.page import plotly_js, three_js

VOID = {"meta", "br", "img", "link", "hr", "input"}


class Walk(HTMLParser):
    """Tags that open and close in order; text outside scripts and styles; every attribute."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.tags: list[str] = []
        self.words: list[str] = []
        self.attributes: list[tuple[str, str, str]] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [(tag, name, value or "") for name, value in attrs]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open and self.open[-1] == tag, f"</{tag}> closes {self.open[-3:]}"
        self.open.pop()

    def handle_data(self, data: str) -> None:
        if self.open[-1:] not in (["script"], ["style"]):
            self.words.append(data)

    @property
    def said(self) -> str:
        return re.sub(r"\s+", " ", " ".join(self.words))


def figures_in(text: str) -> dict[str, Any]:
    """The figures of a page; a number that is not finite is refused."""
    return data_in(text, "figures")


def data_in(text: str, name: str) -> dict[str, Any]:
    """What a page carries under a name: "figures", "scene"."""
    found = re.search(rf'<script type="application/json" id="{name}">(.*?)</script>', text, re.DOTALL)
    assert found is not None
    return json.loads(found[1], parse_constant=_refused)  # type: ignore[no-any-return]


def _refused(constant: str) -> None:
    raise ValueError(f"{constant} in a figure")


def own(text: str) -> str:
    """The page without plotly.js and three.js."""
    library = plotly_js(figures_in(text))
    assert text.count(library) == 1
    return text.replace(library, "").replace(three_js(), "")
