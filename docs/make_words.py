"""Writes docs/languages-words.md: every word of every language that is read, and what its reader does with it.

    python -m docs.make_words
"""

from __future__ import annotations

from pathlib import Path

from toolpaths.interpreting.vocabulary import HONOURED, REFUSED, REMARK, SETTING, Vocabulary
from toolpaths.languages.table import READ, Language

PAGE = Path(__file__).parent / "languages-words.md"
MEANS = {
    HONOURED: "it makes or changes poses, feeds, tools, spindle or frames, or which words run",
    SETTING: "read, and it changes no place: how a controller follows the path, or what the cell gives",
    REMARK: "kept as an event in front of the next pose, in the words of the file; programs that are written have it "
    "as a comment, or as `[program.events]` says",
    REFUSED: "refused by line, with the reason and what to post instead. So is every word that is not in the table",
}


def table(vocabulary: Vocabulary) -> list[str]:
    """One row for each thing that is done."""
    rows = []
    for done in MEANS:
        if words := vocabulary.those(done):
            shown = " ".join(f"`{word}`".replace("|", "\\|") for word in words)
            rows.append(f"| {done} | {shown} |")
    return rows


def section(language: Language) -> list[str]:
    """The tables of one language."""
    suffixes = " ".join(f"`{suffix}`" for suffix in language.reads)
    out = [f"## {language.name}", "", f"{suffixes}: [{language.name}.md]({language.name}.md)", ""]
    for what, vocabulary in language.vocabulary.items():
        out += [f"| {what} | |", "| --- | --- |", *table(vocabulary), ""]
    return out


def page() -> str:
    """The whole page."""
    lead = "Made from the tables of the readers by `python -m docs.make_words`; a test compares. What is done:"
    head = ["# Words that are read", "", lead, ""]
    means = ["| | |", "| --- | --- |", *(f"| {done} | {what} |" for done, what in MEANS.items()), ""]
    return "\n".join([*head, *means, *(line for language in READ for line in section(language))]).rstrip() + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
