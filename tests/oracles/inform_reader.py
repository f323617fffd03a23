"""A second reader of INFORM jobs, from Yaskawa's manuals, not from our writer.

Sources: DX100 Data Transmission (HW0482494) and NX100 (HW0481924), 4.1 job data format: /JOB //NAME //POS ///NPOS
///TOOL ///POSTYPE ///RECTAN ///RCONF //INST ///DATE ///COMM ///ATTR ////FRAME ///GROUP1; 4.3 position data (turned
about Rz, then Ry, then Rx); DX200 INFORM Language (MOVJ, MOVL, CALL, PAUSE, comments). Runs a job and those that it
calls, and gives every move with the state of its position. It refuses what a controller would: a wrong number of
positions, positions that no move uses or two do, V outside 0.1 to 1500.0 mm/s or finer than 0.1, PL outside 0 to 8,
names and comments over 32 characters, jobs over 9,999 lines.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tests.oracles.controller_files import about_axes, crlf_text

MM, DEGREE = r"-?\d+\.\d{3}", r"-?\d+\.\d{4}"


@dataclass
class Position:
    xyz: list
    angles: list
    tool: int
    rconf: list


@dataclass
class Move:
    word: str
    position: Position
    speed: float
    level: int | None


@dataclass
class Run:
    moves: list = field(default_factory=list)
    pauses: list = field(default_factory=list)
    comments: list = field(default_factory=list)
    names: list = field(default_factory=list)


def read(path: Path) -> Run:
    """Runs the job of ``path``; jobs that it calls are looked up by their //NAME."""
    jobs = {name_of(p): p for p in sorted(path.parent.glob("*" + path.suffix))}
    run = Run()
    execute(path, jobs, run, 0)
    return run


def lines_of(path: Path) -> list[str]:
    lines = crlf_text(path).split("\n")
    assert lines.pop() == ""
    return lines


def name_of(path: Path) -> str:
    lines = lines_of(path)
    assert lines[0] == "/JOB"
    m = re.fullmatch(r"//NAME ([A-Z0-9_-]{1,32})", lines[1])
    assert m, lines[1]
    return m[1]


def execute(path: Path, jobs: dict, run: Run, depth: int) -> None:
    lines = lines_of(path)
    run.names.append(name_of(path))
    assert lines[2] == "//POS" and depth < 8
    split = lines.index("//INST")
    positions = table(lines[3:split])
    body = instructions(lines[split + 1 :])
    used: list[str] = []
    for line in body:
        if line.startswith("'"):
            assert len(line) <= 33, line
            run.comments.append(line[1:])
        elif line == "PAUSE":
            run.pauses.append(len(run.moves))
        elif m := re.fullmatch(r"CALL JOB:(\S+)", line):
            execute(jobs[m[1]], jobs, run, depth + 1)
        else:
            run.moves.append(move(line, positions, used))
    assert sorted(used) == sorted(positions), "a position that no move uses, or two do"


def table(lines: list[str]) -> dict[str, Position]:
    count = re.fullmatch(r"///NPOS (\d+),0,0,0,0,0", lines[0])
    out: dict[str, Position] = {}
    tool, kind, rconf = -1, "", []
    for line in lines[1:]:
        if m := re.fullmatch(r"///TOOL (\d{1,2})", line):
            tool = int(m[1])
            assert tool <= 63
        elif m := re.fullmatch(r"///POSTYPE (ROBOT)", line):
            kind = m[1]
        elif line == "///RECTAN":
            assert kind == "ROBOT"
        elif m := re.fullmatch(r"///RCONF ([01](?:,[01]){5}(?:,0){18})", line):
            rconf = [int(k) for k in m[1].split(",")]
        else:
            m = re.fullmatch(rf"(C\d{{5}})=({MM}),({MM}),({MM}),({DEGREE}),({DEGREE}),({DEGREE})", line)
            assert m and m[1] == f"C{len(out):05d}" and tool >= 0 and rconf, line
            assert all(not re.fullmatch(r"-0\.0+", m[i]) for i in range(2, 8)), line
            values = [float(m[i]) for i in range(2, 8)]
            assert all(abs(v) <= 180.0 for v in values[3:])
            out[m[1]] = Position(values[:3], values[3:], tool, rconf)
    assert len(out) == int(count[1]), "NPOS"
    return out


def instructions(lines: list[str]) -> list[str]:
    assert re.fullmatch(r"///DATE \d{4}/\d\d/\d\d \d\d:\d\d", lines[0]), lines[0]
    assert re.fullmatch(r"///COMM .{1,32}", lines[1]), lines[1]
    assert lines[2:6] == ["///ATTR SC,RW,RJ", "////FRAME ROBOT", "///GROUP1 RB1", "NOP"]
    assert lines[-1] == "END" and len(lines) - 6 <= 9999
    return lines[6:-1]


def move(line: str, positions: dict[str, Position], used: list[str]) -> Move:
    m = re.fullmatch(r"(MOVJ|MOVL) (C\d{5}) (VJ|V)=(\d+\.\d+)(?: PL=([0-8]))?", line)
    assert m and (m[1] == "MOVJ") == (m[3] == "VJ"), f"not INFORM: {line!r}"
    speed = float(m[4])
    if m[1] == "MOVJ":
        assert 0.01 <= speed <= 100.0 and re.fullmatch(r"\d+\.\d\d", m[4])
    else:
        assert 0.1 <= speed <= 1500.0 and re.fullmatch(r"\d+\.\d", m[4])
    used.append(m[2])
    return Move(m[1], positions[m[2]], speed, None if m[5] is None else int(m[5]))


@dataclass
class Dialect:
    """How a job is put together, whoever wrote it: its pseudo instructions in their order, position lines, moves."""

    words: list
    positions: dict
    moves: list


def dialect(path: Path) -> Dialect:
    """A job of any post: what has to hold in all of them is checked, what they may choose is not."""
    lines = path.read_bytes().decode("ascii").replace("\r\n", "\n").split("\n")
    assert lines.pop() == "" and lines[0] == "/JOB" and lines[-1] == "END"
    words = [line.split()[0] for line in lines if line.startswith("/")]
    found = [re.fullmatch(r"(C\d{5})=(.*)", line) for line in lines]
    positions = {m[1]: [float(v) for v in m[2].split(",")] for m in found if m}
    assert list(positions) == [f"C{k:05d}" for k in range(len(positions))]
    assert all(len(v) == 6 for v in positions.values())
    count = next(re.fullmatch(r"///NPOS (\d+),0,0,0,0,0", line) for line in lines if line.startswith("///NPOS"))
    assert int(count[1]) == len(positions)
    assert lines[lines.index("NOP") - 1].startswith("///GROUP1 RB1")
    used: list[str] = []
    moves = [move(line, positions, used) for line in lines[lines.index("NOP") :] if line.startswith("MOV")]
    assert sorted(used) == sorted(positions)
    return Dialect(words, positions, moves)


def pose(position: Position) -> np.ndarray:
    """(4, 4) mm: the frame turned in the order Rz, Ry, Rx about its own axes."""
    x, y, z = about_axes(*position.angles)
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = z @ y @ x, position.xyz
    return out
