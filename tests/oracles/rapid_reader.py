"""A second reader of RAPID, from ABB's grammar (3HAC16581, 3HAC16585 "RAPID kernel"), not from our writer.

It executes main() of a set of modules and gives every move with all its data resolved. It refuses whatever a
controller would: undeclared and doubled names, names over 32 characters, aggregates of the wrong shape,
quaternions that are not normalised, line ends that are not CR LF.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tests.oracles.controller_files import crlf_text

# RAPID reference, data types zonedata and speeddata: what the controller knows without a declaration.
FINE = [True, 0, 0, 0, 0, 0, 0]
PREDEFINED = {
    "fine": FINE,
    "z0": [False, 0.3, 0.3, 0.3, 0.03, 0.3, 0.03],
    "z1": [False, 1, 1, 1, 0.1, 1, 0.1],
    "z5": [False, 5, 8, 8, 0.8, 8, 0.8],
}
SHAPES = {
    "tooldata": ["bool", ["p", "q"], ["n", "p", "q", "n", "n", "n"]],
    "wobjdata": ["bool", "bool", "str", ["p", "q"], ["p", "q"]],
    "speeddata": ["n"] * 4,
    "zonedata": ["bool"] + ["n"] * 6,
    "robtarget": ["p", "q", ["n"] * 4, ["n"] * 6],
    "jointtarget": [["n"] * 6, ["n"] * 6],
}
TOKEN = re.compile(
    r"""(?P<space>[ \t]+)|(?P<comment>![^\n]*)|(?P<line>\n)|(?P<string>"[^"\n]*")
    |(?P<number>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|(?P<name>[A-Za-z][A-Za-z0-9_]*)
    |(?P<mark>:=|[\[\],;()\\])""",
    re.X,
)


@dataclass
class Move:
    word: str
    target: list
    speed: list
    zone: list
    tool: list
    wobj: list


@dataclass
class Module:
    name: str
    data: dict = field(default_factory=dict)
    local: dict = field(default_factory=dict)
    routines: dict = field(default_factory=dict)


def read(path: Path) -> tuple[list[Move], list[str]]:
    """Moves of main() in order, and what else ran; of the modules that the .pgf lists, if there is one."""
    listing = path.with_suffix(".pgf")
    names = [path.name]
    if listing.exists():
        names = re.findall(r"<Module>(.*?)</Module>", crlf_text(listing))
        assert names[0] == path.name
    modules = [Parser(crlf_text(path.parent / name)).module() for name in names]
    shared: dict = {}
    for module in modules:
        for table in (module.data, module.routines, {module.name: None}):
            for name in table:
                assert name.lower() not in shared, f"{name} is declared twice"
                shared[name.lower()] = (module, name)
    return Run(modules, shared).main()


class Parser:
    def __init__(self, text: str) -> None:
        head = re.match(r"%%%\n(?:  \w+:\w+\n)+%%%\n", text)
        rest, self.tokens, at = text[head.end() if head else 0 :], [], 0
        while at < len(rest):
            m = TOKEN.match(rest, at)
            assert m, f"not RAPID: {rest[at : at + 40]!r}"
            if m.lastgroup not in ("space", "comment", "line"):
                self.tokens.append((m.lastgroup, m[0]))
            at = m.end()
        self.at = 0

    def peek(self) -> str:
        return self.tokens[self.at][1] if self.at < len(self.tokens) else ""

    def take(self, expected: str | None = None) -> str:
        text = self.tokens[self.at][1]
        self.at += 1
        assert expected is None or text.upper() == expected.upper(), f"{text!r}, expected {expected!r}"
        return text

    def name(self) -> str:
        kind, text = self.tokens[self.at]
        assert kind == "name" and len(text) <= 32, f"{text!r} is no name"
        return self.take()

    def module(self) -> Module:
        self.take("MODULE")
        module = Module(self.name())
        while self.peek().upper() != "ENDMODULE":
            if self.peek().upper() == "PROC":
                self.routine(module)
            else:
                self.declaration(module)
        self.take("ENDMODULE")
        assert self.at == len(self.tokens), "text after ENDMODULE"
        return module

    def declaration(self, module: Module) -> None:
        scope = self.take() if self.peek().upper() in ("LOCAL", "TASK") else ""
        storage = self.take().upper()
        assert storage in ("CONST", "PERS", "VAR"), storage
        kind, name = self.name(), self.name()
        self.take(":=")
        value = self.value()
        self.take(";")
        check_shape(kind, value)
        if kind in ("tooldata", "wobjdata"):
            assert storage == "PERS", f"{kind} has to be PERS"
        table = module.local if scope.upper() == "LOCAL" else module.data
        assert name not in module.local and name not in module.data, f"{name} is declared twice"
        table[name] = (kind, value)

    def value(self):
        kind, text = self.tokens[self.at]
        if text == "[":
            self.take()
            out = [self.value()]
            while self.peek() == ",":
                self.take()
                out.append(self.value())
            self.take("]")
            return out
        self.take()
        if kind == "number":
            return float(text)
        if kind == "string":
            return text
        if text.upper() in ("TRUE", "FALSE"):
            return text.upper() == "TRUE"
        assert kind == "name", text
        return ("name", text)

    def routine(self, module: Module) -> None:
        self.take("PROC")
        name = self.name()
        self.take("(")
        self.take(")")
        steps = []
        while self.peek().upper() != "ENDPROC":
            steps.append(self.instruction())
        self.take("ENDPROC")
        assert name not in module.routines
        module.routines[name] = steps

    def instruction(self):
        word, arguments, options = self.name(), [], {}
        while self.peek() != ";":
            if self.peek() == ",":
                self.take()
            while self.peek() == "\\":
                self.take()
                option = self.name()
                if self.peek() == ":=":
                    self.take()
                    options[(len(arguments), option.lower())] = self.value()
                else:
                    options[(len(arguments), option.lower())] = True
            if self.peek() not in (";", ","):
                arguments.append(self.value())
        self.take(";")
        return word, arguments, options


def check_shape(kind: str, value) -> None:
    assert kind in SHAPES, kind
    fits(SHAPES[kind], value, kind)


def fits(shape, value, where: str) -> None:
    if isinstance(shape, list):
        assert isinstance(value, list) and len(value) == len(shape), f"{where}: {value}"
        for s, v in zip(shape, value, strict=True):
            fits(s, v, where)
    elif shape == "p":
        fits(["n"] * 3, value, where)
    elif shape == "q":
        fits(["n"] * 4, value, where)
        assert abs(np.linalg.norm(value) - 1.0) < 5e-8, f"{where}: quaternion {value} is not normalised"
    else:
        assert type(value) is {"n": float, "bool": bool, "str": str}[shape], f"{where}: {value}"


class Run:
    def __init__(self, modules: list[Module], shared: dict) -> None:
        self.modules, self.shared, self.moves, self.other = modules, shared, [], []

    def main(self) -> tuple[list[Move], list[str]]:
        module, name = self.shared["main"]
        self.call(module, name, 0)
        return self.moves, self.other

    def call(self, module: Module, name: str, depth: int) -> None:
        assert depth < 5
        for word, arguments, options in module.routines[name]:
            if word in ("MoveL", "MoveAbsJ"):
                self.moves.append(self.move(module, word, arguments, options))
            elif word in ("ConfL", "ConfJ", "SingArea", "Stop"):
                self.other.append(" ".join([word, *(o for _, o in options)]))
            else:
                assert not arguments and not options, word
                self.call(*self.shared[word.lower()], depth + 1)

    def move(self, module: Module, word: str, arguments: list, options: dict) -> Move:
        target, speed, zone, tool = arguments
        check_shape("robtarget" if word == "MoveL" else "jointtarget", target)
        speed = list(self.look_up(module, speed, "speeddata"))
        if (2, "v") in options:
            speed[0] = options.pop((2, "v"))
        wobj = self.look_up(module, options.pop((4, "wobj")), "wobjdata")
        assert not options, options
        return Move(
            word, target, speed, self.look_up(module, zone, "zonedata"),
            self.look_up(module, tool, "tooldata"), wobj,
        )  # fmt: skip

    def look_up(self, module: Module, what, kind: str):
        assert isinstance(what, tuple), what
        name = what[1]
        if name in module.local:
            found = module.local[name]
        elif name.lower() in self.shared:
            owner, real = self.shared[name.lower()]
            found = owner.data[real]
        else:
            return PREDEFINED[name]
        assert found[0] == kind, f"{name} is {found[0]}, not {kind}"
        return found[1]
