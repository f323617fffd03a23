"""A second reader of URScript, from Universal Robots' script manual, not from our writer. It defines the functions of
a file, runs what stands behind them, and gives every move with the TCP in the base frame."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tests.oracles.controller_files import at_commas

NUMBER = r"-?\d+(?:\.\d+)?"
#: The manual's parameters, in their order, with their defaults.
PARAMETERS = {
    "movej": {"q": None, "a": 1.4, "v": 1.05, "t": 0.0, "r": 0.0},
    "movel": {"pose": None, "a": 1.2, "v": 0.25, "t": 0.0, "r": 0.0},
    "set_tcp": {"pose": None},
    "set_payload": {"m": None, "cog": None},
    "popup": {"s": None, "title": "Popup", "warning": False, "error": False, "blocking": False},
    "pose_trans": {"p_from": None, "p_from_to": None},
}
KEYWORDS = {"def", "end", "if", "else", "while", "thread", "True", "False", "and", "or", "not", "global", "return"}


@dataclass
class Move:
    word: str
    target: np.ndarray
    a: float
    v: float
    r: float
    tcp: np.ndarray
    payload: tuple


@dataclass
class Run:
    values: dict = field(default_factory=dict)
    tcp: np.ndarray | None = None
    payload: tuple = ()
    moves: list = field(default_factory=list)
    popups: list = field(default_factory=list)


def read(path: Path) -> Run:
    raw = path.read_bytes()
    assert b"\r" not in raw and raw.endswith(b"\n")
    lines = [line.split("#")[0].rstrip() for line in raw.decode("ascii").splitlines()]
    functions: dict[str, list[str]] = {}
    name, run = "", Run()
    for line in (line for line in lines if line):
        if m := re.fullmatch(r"def ([A-Za-z]\w*)\(\):", line):
            assert not name and m[1] not in functions and m[1] not in {*PARAMETERS, *KEYWORDS}
            name = m[1]
            functions[name] = []
        elif line == "end":
            assert name
            name = ""
        elif name:
            functions[name].append(line.strip())
        else:
            called = re.fullmatch(r"(\w+)\(\)", line)
            assert called, line
            for statement in functions[called[1]]:
                execute(statement, run)
    assert not name, "a function without end"
    return run


def execute(line: str, run: Run) -> None:
    if m := re.fullmatch(r"([A-Za-z_]\w*) = (.*)", line):
        assert m[1] not in KEYWORDS
        run.values[m[1]] = evaluate(m[2], run)
        return
    m = re.fullmatch(r"(\w+)\((.*)\)", line)
    assert m and m[1] in PARAMETERS and m[1] != "pose_trans", f"not URScript: {line!r}"
    given = arguments(m[1], m[2], run)
    if m[1] == "set_tcp":
        run.tcp = given["pose"]
    elif m[1] == "set_payload":
        run.payload = (given["m"], tuple(given["cog"]))
        assert given["m"] > 0 and len(given["cog"]) == 3
    elif m[1] == "popup":
        assert given["blocking"] is True
        run.popups.append(given["s"])
    else:
        target = given["q"] if m[1] == "movej" else given["pose"]
        shape = (6,) if m[1] == "movej" else (4, 4)
        assert np.shape(target) == shape and given["a"] > 0 and given["v"] > 0 and given["r"] >= 0
        run.moves.append(Move(m[1], target, given["a"], given["v"], given["r"], run.tcp, run.payload))


def arguments(word: str, text: str, run: Run) -> dict:
    values, names = dict(PARAMETERS[word]), list(PARAMETERS[word])
    for i, part in enumerate(at_commas(text, "[(])")):
        m = re.fullmatch(r"([a-z]+) ?= ?(.*)", part)
        name, value = (m[1], m[2]) if m else (names[i], part)
        assert name in values, f"{word} has no {name}"
        values[name] = evaluate(value, run)
    assert None not in [v for v in values.values() if not isinstance(v, np.ndarray)]
    return values


def evaluate(text: str, run: Run):
    if re.fullmatch(NUMBER, text):
        return float(text)
    if text in ("True", "False"):
        return text == "True"
    if m := re.fullmatch(r'"([^"]*)"', text):
        return m[1]
    if m := re.fullmatch(r"(p?)\[(.*)\]", text):
        numbers = np.array([evaluate(part, run) for part in at_commas(m[2], "[(])")])
        return matrix(numbers) if m[1] else numbers
    if m := re.fullmatch(r"pose_trans\((.*)\)", text):
        given = arguments("pose_trans", m[1], run)
        return given["p_from"] @ given["p_from_to"]
    return run.values[text]


def matrix(p: np.ndarray) -> np.ndarray:
    assert len(p) == 6
    out = np.eye(4)
    out[:3, :3] = Rotation.from_rotvec(p[3:]).as_matrix()
    out[:3, 3] = p[:3]
    return out
