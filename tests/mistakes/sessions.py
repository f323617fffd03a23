"""Mistakes in a measurement session."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path

from tests.mistakes.mistake import Mistake, Spoil, edit

EVALUATE = "evaluate session.toml --model model.toml"
IDENTIFY = "identify session.toml --effects joint-stiffness -o out.toml"
Row = dict[str, str]


def session(old: str, new: str) -> Spoil:
    return edit("session.toml", old, new)


def each_row(change: Callable[[int, Row], Row | None]) -> Spoil:
    """The samples with every row changed; None takes it out."""

    def spoil(folder: Path) -> None:
        with (folder / "samples.csv").open(newline="") as stream:
            rows = list(csv.DictReader(stream))
        changed = [row for row in (change(k, dict(row)) for k, row in enumerate(rows)) if row is not None]
        with (folder / "samples.csv").open("w", newline="") as stream:
            writer = csv.DictWriter(stream, list(changed[0]), lineterminator="\n")
            writer.writeheader()
            writer.writerows(changed)

    return spoil


def cell(row: int, column: str, text: str) -> Spoil:
    """One cell, its row counted from 0."""
    return each_row(lambda k, given: given | ({column: text} if k == row else {}))


def wrench(scale: float) -> Spoil:
    columns = ("fx", "fy", "fz", "mx", "my", "mz")
    return each_row(lambda k, row: row | {c: repr(float(row[c]) * scale) for c in columns})


def without(column: str) -> Spoil:
    return each_row(lambda k, row: {name: text for name, text in row.items() if name != column})


def semicolons(folder: Path) -> None:
    (folder / "samples.csv").write_text((folder / "samples.csv").read_text().replace(",", ";"))


def only_header(folder: Path) -> None:
    text = (folder / "samples.csv").read_text()
    (folder / "samples.csv").write_text(text.partition("\n")[0] + "\n")


HEADERS = (
    Mistake("the samples are not there", IDENTIFY, session("samples.csv", "sample.csv")),
    Mistake("angles in degrees called radians", IDENTIFY, session('angle = "deg"', 'angle = "rad"')),
    Mistake("millimetres called metres", IDENTIFY, session('length = "mm"', 'length = "m"')),
    Mistake("no noise of the tracker", IDENTIFY, session("tracker = 0.02\n", "")),
    Mistake("the noise of the tracker in um", IDENTIFY, session("tracker = 0.02", "tracker = 20.0")),
    Mistake("a word for gravity", IDENTIFY, session('gravity = "uncompensated"', 'gravity = "down"')),
    Mistake("a table is misspelt", IDENTIFY, session("[wrench]", "[wrnech]")),
    Mistake("a reflector on a link that the robot has not", IDENTIFY, session("link = 3", "link = 9")),
    Mistake("a session of another robot than the model", "evaluate ur10/session.toml --model model.toml"),
    Mistake("gravity as the model does not have it", EVALUATE, session('"uncompensated"', '"calibrated-out"')),
    Mistake("sessions of two robots", "identify session.toml ur10/session.toml -o out.toml"),
    Mistake("one session twice", "identify other/session.toml other/session.toml -o out.toml"),
    Mistake("a copy of a session beside it", "identify other/session.toml copy/session.toml -o out.toml"),
    Mistake("a tool without mass", EVALUATE, session("mass = 5.0\n", "")),
)
ROWS = (
    Mistake("the wrench in kN", EVALUATE, wrench(1e-3)),
    Mistake("the wrench with the wrong sign", EVALUATE, wrench(-1.0)),
    Mistake("semicolons", IDENTIFY, semicolons),
    Mistake("only a header", IDENTIFY, only_header),
    Mistake("a column is missing", IDENTIFY, without("z")),
    Mistake("a column of joint 7", IDENTIFY, each_row(lambda k, row: row | {"q7": "0"})),
    Mistake("an empty cell", IDENTIFY, cell(3, "x", "")),
    Mistake("a decimal comma", IDENTIFY, cell(3, "x", "-1629,67")),
    Mistake("a word for a number", IDENTIFY, cell(3, "x", "lost")),
    Mistake("a reflector that the session does not have", IDENTIFY, cell(3, "reflector", "top")),
    Mistake("a set-up without its reference", IDENTIFY, each_row(lambda k, row: None if k < 3 else row)),
    Mistake("a row twice", IDENTIFY, each_row(lambda k, row: row | ({"reflector": "tcp"} if k == 1 else {}))),
    Mistake("an angle beyond the limits", IDENTIFY, cell(3, "q2", "200")),
    Mistake("two angles in one set-up", IDENTIFY, cell(1, "q2", "1")),
)
