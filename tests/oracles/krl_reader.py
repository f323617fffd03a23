"""A second reader of KRL, from KUKA's manuals (KR C2 Expert Programming, KSS 8.3), not from our writer.

It executes a program and the files that it calls, and gives every move with the state it runs in: speed,
approximation distance, tool, base. It refuses names over 24 characters, a file that is not called like its
program, unknown words, and line ends that are not CR LF.
"""

from __future__ import annotations

import copy
import re
from dataclasses import dataclass, field
from pathlib import Path

from tests.oracles.controller_files import at_commas, crlf_text

NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
KNOWN = r"BAS\(#\w+,\d+\)|INTERRUPT ON 3|GLOBAL INTERRUPT DECL 3 WHEN \$STOPMESS==TRUE DO \w+\(\)"
COMPONENTS = {
    "FRAME": ("X", "Y", "Z", "A", "B", "C"),
    "POS": ("X", "Y", "Z", "A", "B", "C", "S", "T"),
    "AXIS": ("A1", "A2", "A3", "A4", "A5", "A6"),
    "INERTIA": ("X", "Y", "Z"),
    "LOAD": ("M", "CM", "J"),
}


@dataclass
class State:
    values: dict = field(default_factory=dict)
    moves: list = field(default_factory=list)
    halts: int = 0


@dataclass
class Move:
    word: str
    target: dict
    approximate: str
    state: dict


def read(path: Path) -> State:
    """Runs the program of ``path``."""
    state = State()
    run(path, state, 0)
    return state


def run(path: Path, state: State, depth: int) -> None:
    lines = crlf_text(path).split("\n")
    assert lines[-1] == "" and max(map(len, lines)) <= 256
    assert depth < 5
    body = [line.strip() for line in lines[:-1]]
    while body[0].startswith("&"):
        body.pop(0)
    name = re.fullmatch(r"DEF ([A-Za-z$_][\w$]*) ?\( ?\)", body[0])
    assert name and len(name[1]) <= 24 and name[1].lower() == path.stem.lower(), body[0]
    assert body[-1] == "END"
    for line in body[1:-1]:
        execute(line, path, state, depth)


def execute(line: str, path: Path, state: State, depth: int) -> None:
    if not line or line.startswith(";"):
        return
    if m := re.fullmatch(r"(PTP|LIN) (\{.*\})((?: C_\w+)?)", line):
        target = aggregate(m[2], "AXIS" if m[1] == "PTP" else "POS")
        state.moves.append(Move(m[1], target, m[3].strip(), copy.copy(state.values)))
    elif m := re.fullmatch(r"(\$[A-Z_]+(?:\.[A-Z]+)?)=(.*)", line):
        state.values[m[1]] = assigned(m[1], m[2])
    elif line == "HALT":
        state.halts += 1
    elif m := re.fullmatch(r"(\w+)\(\)", line):
        run(path.with_name(m[1] + path.suffix), state, depth + 1)
    else:
        assert re.fullmatch(KNOWN, line), f"not KRL: {line!r}"


def assigned(name: str, text: str):
    if name in ("$BASE", "$TOOL"):
        return aggregate(text, "FRAME")
    if name == "$LOAD":
        return aggregate(text, "LOAD")
    if text.startswith("#"):
        return text
    assert re.fullmatch(NUMBER, text), text
    assert name in ("$VEL.CP", "$APO.CDIS", "$APO.CORI", "$ADVANCE"), name
    return float(text)


def aggregate(text: str, kind: str) -> dict:
    assert text[0] == "{" and text[-1] == "}", text
    inner = text[1:-1].strip()
    if m := re.match(r"(\w+): *", inner):
        assert m[1] == kind, f"{m[1]}, expected {kind}"
        inner = inner[m.end() :]
    out: dict = {}
    for part in at_commas(inner, "{}"):
        m = re.fullmatch(r"(\w+) (.*)", part)
        assert m and m[1] in COMPONENTS[kind] and m[1] not in out, part
        if m[2].startswith("{"):
            out[m[1]] = aggregate(m[2], {"CM": "FRAME", "J": "INERTIA"}[m[1]])
        else:
            assert re.fullmatch(NUMBER if m[1] not in ("S", "T") else r"\d+", m[2]), part
            out[m[1]] = float(m[2])
    return out
