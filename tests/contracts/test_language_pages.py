"""One suite over the pages of the languages: examples are read, refused in that line, written as they stand there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.contracts.sample import Sample
from tests.contracts.samples import READ, SAMPLES, to_write
from tests.oracles.sample_programs import small
from tests.oracles.vendor_moves import READERS
from toolpaths.errors import ReadError
from toolpaths.files import read_back, read_toolpath, write_program
from toolpaths.languages import table

DOCS = Path(__file__).parents[2] / "docs"
TEXTS = {page.stem: page.read_text(encoding="utf-8") for page in DOCS.glob("*.md")}
#: The pages, and the one about all languages that are read.
NAMES = [*table.LANGUAGES, "toolpaths-in"]
BLOCK = re.compile(r"^```(\w+) ?([^\n]*)\n(.*?)^```$", re.M | re.S)
READS = re.compile(r"(\d+) poses")
REFUSES = re.compile(r"refused in line (\d+)(?:: (.*))?")


def blocks(told: re.Pattern[str]) -> list[tuple[str, str, re.Match[str], str]]:
    """Page, suffix, what is told of the block, its text."""
    return [
        (name, suffix, found, text)
        for name in NAMES
        for suffix, info, text in BLOCK.findall(TEXTS[name])
        if (found := told.fullmatch(info))
    ]


def written_blocks(name: str) -> list[str]:
    return [text for _, info, text in BLOCK.findall(TEXTS[name]) if info == "written"]


def shown_files(name: str) -> list[tuple[str, str]]:
    """What the example of the page writes."""
    return re.findall(r"<!-- (slot\.\w+) -->\n```\w+\n(.*?)```", TEXTS[name], re.S)


@pytest.mark.parametrize(("page", "suffix", "told", "text"), blocks(READS))
def test_read(tmp_path: Path, page: str, suffix: str, told: re.Match[str], text: str) -> None:
    file = tmp_path / f"part.{suffix}"
    file.write_text(text)
    assert len(read_toolpath(file)) == int(told[1])


@pytest.mark.parametrize(("page", "suffix", "told", "text"), blocks(REFUSES))
def test_refused(tmp_path: Path, page: str, suffix: str, told: re.Match[str], text: str) -> None:
    file = tmp_path / f"part.{suffix}"
    file.write_text(text)
    with pytest.raises(ReadError) as caught:
        read_toolpath(file)
    assert caught.value.line == int(told[1]) and (told[2] or "") in str(caught.value)


@pytest.mark.parametrize("name", [name for name in table.LANGUAGES if written_blocks(name)])
def test_written(tmp_path: Path, name: str) -> None:
    write_program(small(), file := to_write(tmp_path, name))
    assert all(text in file.read_text() for text in written_blocks(name))


@pytest.mark.parametrize("name", [name for name in table.LANGUAGES if shown_files(name)])
def test_the_example_writes_what_the_page_shows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.chdir(tmp_path)
    code = re.search(r"<!-- example -->\n```python\n(.*?)```", TEXTS[name], re.S)
    assert code
    exec(code[1], {})
    shown = shown_files(name)
    for file, text in shown:
        assert (tmp_path / file).read_text() == text
    main = tmp_path / f"slot{table.LANGUAGES[name].writes}"
    assert main.name == shown[0][0]
    assert len(READERS[name]([main])) == len(read_back(main).position) >= 3


@pytest.mark.parametrize("name", NAMES)
def test_every_block_is_run(name: str) -> None:
    """Those above, and those that the language has a test for."""
    found = [page for page, *_ in (*blocks(READS), *blocks(REFUSES))].count(name)
    shown = len(shown_files(name))
    more = len(written_blocks(name)) + shown + (shown > 0)
    sample = SAMPLES.get(name, Sample())
    assert TEXTS[name].count("\n```") == 2 * (found + more + sample.own_blocks)
    assert found >= sample.examples


@pytest.mark.parametrize("name", table.LANGUAGES)
def test_the_page_has_the_suffixes(name: str) -> None:
    language = table.LANGUAGES[name]
    for suffix in (*language.reads, language.writes):
        assert re.search(rf"{re.escape(suffix)}\b", TEXTS[name]) or not suffix, suffix
        assert suffix in TEXTS["toolpaths-in"] or suffix not in language.reads
        assert suffix in TEXTS["programs-out"] or suffix != language.writes


def test_the_page_of_what_is_read_has_examples_of_every_language() -> None:
    suffixes = {suffix: language.name for language in table.READ for suffix in language.reads}
    examples = [suffix for page, suffix, *_ in (*blocks(READS), *blocks(REFUSES)) if page == "toolpaths-in"]
    assert {suffixes[f".{suffix}"] for suffix in examples} == set(READ)
