"""A second reader of VAL3 applications, from Staubli's manuals, not from our writer.

Sources: VAL3 Reference Manual 5.3 (D28062804A): 2 applications and programs (an application has start() and
stop(); names of 15 characters), 8 arm positions (joint, trsf with rx ry rz about moving axes, tool, frame, point,
config), 9 movement control (movej, movel, mdesc: accel, vel, decel, tmax, rmax, blend, leave, reach); VAL3 XML
Format, s7: Project/3, Program/2, Data/2. Runs start() and gives every move with its data resolved. Refuses what a
controller would: programs and files that the project does not list, unknown data, an index outside the array,
names that are too long, words that it does not know.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from tests.oracles.controller_files import about_axes

SPACE = "{http://www.staubli.com/robotics/VAL3/%s}%s"
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,14}")
FIELDS = {
    "frame": ({"x", "y", "z", "rx", "ry", "rz", "fatherId"}, set()),
    "tool": ({"x", "y", "z", "rx", "ry", "rz", "fatherId"}, set()),
    "pointRx": ({"x", "y", "z", "rx", "ry", "rz", "fatherId"}, {"shoulder", "elbow", "wrist"}),
    "jointRx": ({f"j{i}" for i in range(1, 7)}, set()),
    "mdesc": ({"accel", "vel", "decel", "tmax", "rmax", "blend", "leave", "reach"}, set()),
}
WORDS = {
    "blend": {"off", "joint", "Cartesian"},
    "shoulder": {"righty", "lefty", "ssame", "sfree"},
    "elbow": {"epositive", "enegative", "esame", "efree"},
    "wrist": {"wpositive", "wnegative", "wsame", "wfree"},
}


@dataclass
class Move:
    word: str
    target: dict
    tool: dict
    mdesc: dict


@dataclass
class Application:
    programs: dict = field(default_factory=dict)
    data: dict = field(default_factory=dict)
    moves: list = field(default_factory=list)
    said: list = field(default_factory=list)
    moving: bool = False  # moves are queued: the program runs ahead of the arm until waitEndMove()


def read(project: Path) -> Application:
    """Loads the application of a .pjx and runs start()."""
    app = Application()
    root = document(project, "Project/3", "Project")
    parameters = root.find(SPACE % ("Project/3", "Parameters"))
    assert parameters.get("millimeterUnit") == "true" and parameters.get("version").startswith("s7.")
    for entry in root.iter(SPACE % ("Project/3", "Program")):
        load_program(app, project.with_name(entry.get("file")))
    for entry in root.iter(SPACE % ("Project/3", "Data")):
        load_data(app, project.with_name(entry.get("file")))
    assert {"start", "stop"} <= set(app.programs), "an application has start() and stop()"
    run(app, "start", 0)
    assert not app.moving, "start() ends before the arm does"
    return app


def document(path: Path, kind: str, tag: str) -> ElementTree.Element:
    raw = path.read_bytes()
    assert raw.count(b"\r\n") == raw.count(b"\n"), "line ends"
    root = ElementTree.fromstring(raw)
    assert root.tag == SPACE % (kind, tag), root.tag
    return root


def legal(name: str) -> str:
    assert NAME.fullmatch(name), f"{name!r} is no VAL3 name"
    return name


def load_program(app: Application, path: Path) -> None:
    (program,) = document(path, "Program/2", "Programs")
    name = legal(program.get("name"))
    assert name == path.stem and name not in app.programs
    lines = [line.strip() for line in program.find(SPACE % ("Program/2", "Code")).text.split("\n") if line.strip()]
    assert lines[0] == "begin" and lines[-1] == "end", "a program is begin ... end"
    app.programs[name] = lines[1:-1]


def load_data(app: Application, path: Path) -> None:
    for entry in document(path, "Data/2", "Database").iter(SPACE % ("Data/2", "Data")):
        name, kind = legal(entry.get("name")), entry.get("type")
        assert name not in app.data and kind in FIELDS
        values = [element(value, i, kind) for i, value in enumerate(entry)]
        assert len(values) == int(entry.get("size")) and 1 <= len(values) <= 9999
        app.data[name] = (kind, values)


def element(value: ElementTree.Element, index: int, kind: str) -> dict:
    fields = dict(value.attrib)
    assert int(fields.pop("key")) == index
    needed, optional = FIELDS[kind]
    assert needed <= set(fields) <= needed | optional, f"{kind}: {sorted(fields)}"
    out: dict = {}
    for key, text in fields.items():
        if key in WORDS:
            assert text in WORDS[key], text
            out[key] = text
        else:
            out[key] = text if key == "fatherId" else number(text)
    return out


def number(text: str) -> float:
    assert re.fullmatch(r"-?\d+(\.\d+)?", text) and text != "-0", text
    return float(text)


def run(app: Application, name: str, depth: int) -> None:
    assert name in app.programs and depth < 10, name
    for line in app.programs[name]:
        if line.startswith("//"):
            continue
        if m := re.fullmatch(r"(?:userPage|cls|get|waitEndMove|resetMotion)\(\)", line):
            app.moving &= m[0] != "waitEndMove()"
            assert not app.moving, "a message while the arm is still on its way"
        elif m := re.fullmatch(r"call (\w+)\(\)", line):
            run(app, m[1], depth + 1)
        elif m := re.fullmatch(r"(movej|movel)\((\w+)\[(\d+)\],(\w+)\[(\d+)\],(\w+)\[(\d+)\]\)", line):
            target = at(app, m[2], m[3], "jointRx" if m[1] == "movej" else "pointRx")
            app.moving = True
            app.moves.append(Move(m[1], target, at(app, m[4], m[5], "tool"), at(app, m[6], m[7], "mdesc")))
        elif m := re.fullmatch(r'putln\("([^"\\]{0,128})"\)', line):
            app.said.append((len(app.moves), m[1]))
        else:
            raise AssertionError(f"not VAL3: {line!r}")


MOVE = re.compile(r"(?:\w+=)?(move[jlc])\((.*)\)")


def moves_of(path: Path) -> list[tuple[str, tuple[str, ...]]]:
    """Of a VAL3 program of any post: the moves as word and what their arguments are called, such as ("movel", ("p[]",
    "t[]", "m")) where the first two are elements of arrays."""
    (program,) = document(path, "Program/2", "Programs")
    assert program.get("access") == "public" and legal(program.get("name"))
    lines = [line.strip() for line in program.find(SPACE % ("Program/2", "Code")).text.split("\n") if line.strip()]
    assert lines[0] == "begin" and lines[-1] == "end"
    found = [MOVE.fullmatch(line) for line in lines]
    return [(m[1], tuple(re.sub(r"\[\d+\]", "[]", a.strip()) for a in m[2].split(","))) for m in found if m]


def at(app: Application, name: str, index: str, kind: str) -> dict:
    found, values = app.data[name]
    assert found == kind and int(index) < len(values), f"{name}[{index}] as {kind}"
    return values[int(index)]


def pose(app: Application, value: dict) -> np.ndarray:
    """(4, 4) of a frame, tool or point in the father's frame: translation, then rx, ry, rz about moving axes."""
    x, y, z = about_axes(value["rx"], value["ry"], value["rz"])
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = x @ y @ z, [value["x"], value["y"], value["z"]]
    return out


def in_world(app: Application, value: dict) -> np.ndarray:
    """(4, 4) of a point through its father frames to world."""
    father = value["fatherId"]
    if father == "world[0]":
        return pose(app, value)
    m = re.fullmatch(r"(\w+)\[(\d+)\]", father)
    return in_world(app, at(app, m[1], m[2], "frame")) @ pose(app, value)
