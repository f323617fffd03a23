"""Tables of a cell file about the run: bounds of the solve, sampling, the written program."""

from __future__ import annotations

import re
from typing import Annotated, Literal

from pydantic import Field, Strict, field_validator, model_validator

from compensator.toml_table import Number, TomlTable

#: What a line of [program.events] may hold for a number of the word, such as {S}; other braces are the language's own.
PLACEHOLDER = re.compile(r"\{([A-Za-z]+)\}")
PLACEHOLDERS = ("S", "T", "P")
_MOVE = re.compile(r"\s*(?:(?:move(?:[ljcp]|absj)|s?(?:lin|ptp|circ)(?:_rel)?|mov[jlcs])\b|[jlc]\s+p\[)", re.I)


class SolveTable(TomlTable):
    """Bounds and freedoms of the solve: mm, deg.

    ``fade``: how far from the part, along a rapid, a correction fades in and out.
    ``min_*``: how near a singularity a pose may come; ``min_singular_value`` (translations divided by half
    the reach) holds for arms without a spherical wrist, angles and distance (mm) for the others.
    ``feed``: what happens where a joint would be too fast: the feed stays as programmed, or is lowered to the limit.
    ``turn``: about the tool axis, where it is open: one for the whole path; or chosen along it for accuracy. None: one,
    and where none serves, whatever reaches the path.
    ``lean``: of the tool axis from that of the toolpath, at most, chosen along the path with the turn; it asks for
    ``turn = "path"``.
    """

    max_correction: Number = Field(default=5.0, gt=0, le=100)
    free_tool_axis: Annotated[bool, Strict()] = True
    complementary_stiffness: Annotated[bool, Strict()] = True
    fade: Number = Field(default=20.0, gt=0, le=1000)
    min_wrist_angle: Number = Field(default=2.0, gt=0, lt=90)
    min_elbow_angle: Number = Field(default=2.0, gt=0, lt=90)
    min_shoulder: Number = Field(default=20.0, gt=0, le=1000)
    min_singular_value: Number = Field(default=0.02, gt=0, lt=1)
    max_joint_step: Number = Field(default=30.0, gt=0, le=180)
    feed: Literal["programmed", "limit"] = "programmed"
    turn: Literal["constant", "path"] | None = None
    lean: Number = Field(default=0.0, ge=0, le=30)

    @model_validator(mode="after")
    def _lean_is_chosen_with_the_turn(self) -> SolveTable:
        if self.lean > 0 and self.turn == "constant":
            raise ValueError('lean is chosen along the path together with the turn: set turn = "path", or take it away')
        return self

    @property
    def along_path(self) -> str:
        """The key by which the turn or the lean is chosen along the path; empty: the turn is one for all of it."""
        if self.lean > 0:
            return f"solve.lean = {self.lean:g}"
        return 'solve.turn = "path"' if self.turn == "path" else ""


class SamplingTable(TomlTable):
    """How arcs and long moves become points: mm and deg."""

    chord: Number = Field(default=0.01, gt=0, le=10)
    angle: Number = Field(default=0.1, gt=0, le=10)
    spacing: Number = Field(default=10.0, gt=0, le=1000)


class ProgramTable(TomlTable):
    """What the written program is called, its speed in the air and where the toolpath gives none (mm/min).

    ``name``: else the name of its file. ``events``: word of the toolpath (M3, M8, ...) -> lines of the program for it.
    """

    name: str | None = None
    rapid_feed: Number = Field(default=30000.0, gt=0, le=300000)
    default_feed: Number = Field(default=1000.0, gt=0, le=300000)
    events: dict[str, tuple[str, ...]] = Field(default_factory=dict)

    @field_validator("events", mode="after")
    @classmethod
    def _words_and_lines(cls, events: dict[str, tuple[str, ...]]) -> dict[str, tuple[str, ...]]:
        out: dict[str, tuple[str, ...]] = {}
        for key, lines in events.items():
            word = re.sub(r"^([MG])0+(?=\d)", r"\1", key.strip().upper())
            if not re.fullmatch(r"\$?[A-Z]\w*", word):
                raise ValueError(f"{key!r} is no word of a toolpath; such as M3, M6, M8, G4, or CLAMP of APT")
            if word in out:
                raise ValueError(f"{key!r} stands twice: it is {word}")
            for line in lines:
                _check_line(word, line)
            out[word] = lines
        return out


def _check_line(word: str, line: str) -> None:
    """Refuse what is no line of a program.

    Raises:
        ValueError: names word, line and what was expected.
    """
    where = f"{word}: {line!r}"
    if not line.strip() or not (line.isascii() and line.isprintable()):
        raise ValueError(f"{where}: one line of printable ASCII is expected; give several as a list")
    if strange := [p for p in PLACEHOLDER.findall(line) if p not in PLACEHOLDERS]:
        known = ", ".join(f"{{{p}}}" for p in PLACEHOLDERS)
        raise ValueError(f"{where}: {{{strange[0]}}} is not known; a line may have {known}")
    if _MOVE.match(line):
        raise ValueError(f"{where}: a move is not known to the solve; call a routine of the controller that does it")
