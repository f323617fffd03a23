"""A second reader of Fanuc .ls files, from programs that controllers printed and from the makers' posts, not from
our writer. It runs a program with the programs that it calls, and refuses whatever a controller would: numbers and
names out of range, frames that do not match, positions that are not there, speeds that cannot be said."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

from tests.oracles.controller_files import crlf_text

REAL = r"-?\d*\.\d+"
ATTRIBUTES = [
    "OWNER", "COMMENT", "PROG_SIZE", "CREATE", "MODIFIED", "FILE_NAME", "VERSION", "LINE_COUNT", "MEMORY_SIZE",
    "PROTECT", "TCD", "DEFAULT_GROUP", "CONTROL_CODE",
]  # fmt: skip


@dataclass
class Move:
    word: str
    position: dict
    speed: str
    value: float
    termination: str
    frame: list
    tool: list
    program: str


@dataclass
class State:
    registers: dict = field(default_factory=dict)
    frames: dict = field(default_factory=dict)
    tools: dict = field(default_factory=dict)
    frame: int = 0
    tool: int = 0
    moves: list = field(default_factory=list)
    remarks: list = field(default_factory=list)
    pauses: int = 0


def read(path: Path) -> State:
    """Runs the program of ``path``."""
    state = State()
    run(path, state, 0)
    return state


def run(path: Path, state: State, depth: int) -> None:
    head, mn, pos, tail = re.split(r"^/(?:MN|POS|END)\n", crlf_text(path), flags=re.M)
    assert tail == "" and depth < 10
    name = re.match(r"/PROG  (\w+)\n/ATTR\n", head)
    assert name and name[1] == path.stem.upper() and len(name[1]) <= 30 and name[1][0].isalpha()
    lines = mn.splitlines()
    assert len(lines) <= 9999
    check_head(head, len(lines))
    positions = read_positions(pos)
    for i, line in enumerate(lines, 1):
        found = re.fullmatch(r" *(\d+):(.*?) ;", line)
        assert found and int(found[1]) == i, line
        execute(found[2], positions, path, state, depth)


def check_head(head: str, lines: int) -> None:
    found = re.findall(r"^(\w+)\s*[=:]", head, re.M)
    assert [a for a in found if a != "STACK_SIZE"] == ATTRIBUTES, found
    assert f"LINE_COUNT\t= {lines};" in head
    comment = re.search(r'COMMENT\t\t= "(.*)";', head)
    assert comment and len(comment[1]) <= 16
    assert "DEFAULT_GROUP\t= 1,*,*,*,*;" in head, "no other group may move"


def read_positions(text: str) -> dict:
    out: dict = {}
    for number, body in re.findall(r"^P\[(\d+)\]\{\n(.*?)\n\};\n", text, re.M | re.S):
        assert int(number) == len(out) + 1, f"P[{number}]"
        assert body.count("GP") == 1 and body.startswith("   GP1:\n")
        values = {"UF": re.search(r"UF : (\d+)", body)[1], "UT": re.search(r"UT : (\d+)", body)[1]}
        for key, value, unit in re.findall(rf"(X|Y|Z|W|P|R|J\d) ?= *({REAL})  ?(mm|deg)", body):
            assert key not in values and unit == ("mm" if key in "XYZ" else "deg")
            values[key] = float(value)
        config = re.search(r"CONFIG : '([NF]) ([UD]) ([TB]), (-?\d), (-?\d), (-?\d)',", body)
        assert bool(config) == ("X" in values) and len(values) == 8
        if config:
            values |= {"letters": "".join(config.groups()[:3]), "turns": tuple(int(t) for t in config.groups()[3:])}
        out[int(number)] = values
    assert len(out) == text.count("P[")
    return out


def execute(line: str, positions: dict, path: Path, state: State, depth: int) -> None:
    if m := re.fullmatch(r"  !(.*)", line):
        assert len(m[1]) <= 32 and ";" not in m[1]
        state.remarks.append(m[1])
    elif m := re.fullmatch(r"([JL]) P\[(\d+)\] (\S+?)(%|mm/sec|cm/min|inch/min) (FINE|CNT\d+)", line):
        move(m, positions[int(m[2])], path, state)
    elif m := re.fullmatch(r"  PR\[(\d+)\]=LPOS", line):
        state.registers[int(m[1])] = [None] * 6
    elif m := re.fullmatch(rf"  PR\[(\d+),([1-6])\]=({REAL}|\(-{REAL}\))", line):
        state.registers[int(m[1])][int(m[2]) - 1] = float(m[3].strip("()"))
    elif m := re.fullmatch(r"  (UFRAME|UTOOL)\[(\d+)\]=PR\[(\d+)\]", line):
        values = state.registers[int(m[3])]
        assert None not in values
        (state.frames if m[1] == "UFRAME" else state.tools)[int(m[2])] = list(values)
    elif m := re.fullmatch(r"  (UFRAME|UTOOL)_NUM=(\d+)", line):
        setattr(state, "frame" if m[1] == "UFRAME" else "tool", int(m[2]))
    elif m := re.fullmatch(r"  CALL (\w+)", line):
        called = next(p for p in path.parent.iterdir() if p.suffix == path.suffix and p.stem.upper() == m[1])
        run(called, state, depth + 1)
    elif line == "  PAUSE":
        state.pauses += 1
    else:
        raise AssertionError(f"not TP: {line!r}")


def move(m: re.Match[str], position: dict, path: Path, state: State) -> None:
    assert (int(position["UF"]), int(position["UT"])) == (state.frame, state.tool), "frames do not match"
    assert 1 <= state.frame <= 9 and 1 <= state.tool <= 10
    value = float(m[3])
    if m[4] == "%":
        assert m[1] == "J" and 1 <= value <= 100 and "." not in m[3]
    else:
        most, scale = {"mm/sec": (2000, 1.0), "cm/min": (12000, 10 / 60), "inch/min": (4724, 25.4 / 60)}[m[4]]
        assert m[1] == "L" and 0 < value <= most and ("." in m[3]) == (m[4] == "inch/min")
        value *= scale
    assert m[5] == "FINE" or int(m[5][3:]) <= 100
    frame, tool = state.frames[state.frame], state.tools[state.tool]
    state.moves.append(Move(m[1], position, m[3] + m[4], value, m[5], frame, tool, path.stem))
