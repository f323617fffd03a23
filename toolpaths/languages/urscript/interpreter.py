"""Executes a URScript program as far as everything is constant, and collects the moves.

What sensors, loops or threads decide is refused by line where it could change a move. Source: Universal Robots, The
URScript Programming Language.
"""

from __future__ import annotations

import re

from toolpaths.errors import ReadError
from toolpaths.interpreting.values import Runtime
from toolpaths.languages.urscript import control
from toolpaths.languages.urscript.control import CALL, HARMLESS, LABEL, MOTION, QUIET, RUN, moving
from toolpaths.languages.urscript.expressions import UrExpression, UrPose, Value
from toolpaths.languages.urscript.moves import FAST, PARAMETERS, UrMover
from toolpaths.languages.urscript.scan import FUNCTIONS, UrNode
from toolpaths.reading.source_text import comment_word

_TOO_OFTEN = "functions call each other more often than the file is long"


class UrInterpreter:
    """Execution of a program, statement by statement."""

    def __init__(self, text: str, source: str) -> None:
        self.text, self.source = text, source
        self.values: dict[str, Value | Runtime] = {}
        self.functions: dict[str, UrNode] = {}
        self.threads: dict[str, UrNode] = {}
        self.mover = UrMover(text, source, self.values)
        self.track = self.mover.track
        self.left = 10_000 + 20 * text.count("\n")
        self.kept: list[dict[str, Value | Runtime | None]] = []  # of every function that runs: what it hides

    def file(self, root: UrNode) -> None:
        """What stands outside of functions; a single function that nobody calls is run, as the controller does."""
        defined = [n for n in root.body if n.word == "def"]
        if len(defined) == 1 and all(n.word in FUNCTIONS for n in root.body):
            self.functions = {n.name: n for n in root.body if n.word == "def"}
            self.block(defined[0].body)
            return
        self.block(root.body)

    def block(self, body: list[UrNode]) -> bool:
        """Runs statements; True where a return or halt ended them."""
        for node in body:
            self.left -= 1
            if self.left < 0:
                raise ReadError(self.source, node.line, _TOO_OFTEN, "Unroll the calls.")
            if node.word == "def":
                self._define(node, body)
            elif node.word:
                self._skip(node)
            elif control.LEAVES.match(node.text):
                self._refuse_swallowed(node, control.SWALLOWING.problem(node.text))
                self._side_effects(node)
                return True
            else:
                self._statement(node)
        return False

    def _define(self, node: UrNode, body: list[UrNode]) -> None:
        old = self.functions.get(node.name)
        if old is not None and old is not node and any(old is n for n in body):
            problem = f"def {node.name}() stands twice, first in line {old.line}"
            raise self._refused(node, problem, "Two programs in one file? Give one of them.")
        self.functions[node.name] = node

    def _refused(self, node: UrNode, problem: str, remedy: str) -> ReadError:
        return ReadError(self.source, node.line, problem, remedy)

    def _refuse_swallowed(self, node: UrNode, problem: str) -> None:
        if problem:
            raise self._refused(node, problem, control.SWALLOWING.remedy)

    def _skip(self, node: UrNode) -> None:
        """A loop, a condition or a thread: let pass where no move depends on it."""
        if node.word == "thread":
            self.threads[node.name] = node
            return
        if (inside := control.moving_call(node, self.functions) or moving(node, self.functions)) is not None:
            remedy = "Moves that a condition or a loop decides cannot be compensated: unroll them."
            if node.word == "while" and node.text.strip("() ") == "True":
                remedy = "Take the loop away; in PolyScope clear 'Program Loops Forever' and save again."
            problem = f"'{node.word} {node.text[:40]}' decides about {inside.text[:40]!r} (line {inside.line})"
            raise self._refused(node, problem, remedy)
        self._forget(node)
        self.track.event(comment_word(f"{node.word} {node.text}"), node.line)

    def _forget(self, node: UrNode) -> None:
        """What is assigned inside a block that may or may not run is not known behind it."""
        for name, line in control.assigned(node, self.functions):
            self._set(name, Runtime(f"set in line {line}, which may or may not run"))

    def _side_effects(self, node: UrNode) -> None:
        """Functions of the file that a statement calls inside something else: their moves would be lost."""
        if control.moving_call(node, self.functions) is not None:
            remedy = "Call it in a line of its own."
            raise self._refused(node, f"{node.text[:50]!r} calls a function that moves the arm", remedy)
        for name, line in control.called(node, self.functions, set()):
            self._set(name, Runtime(f"set in line {line}"))

    def _set(self, name: str, value: Value | Runtime) -> None:
        self.values[name] = value
        self.mover.forget()

    def _thread(self, node: UrNode, m: re.Match[str]) -> None:
        """``run name()``: a thread that only counts, waits or sets signals is let pass."""
        thread = self.threads.get(m[2])
        if thread is None:
            raise self._refused(node, f"the thread {m[2]} is not in the file", "Define it before it is run.")
        if (inside := moving(thread, self.functions)) is not None:
            problem = f"the thread {m[2]} moves the arm: {inside.text[:40]!r} (line {inside.line})"
            raise self._refused(node, problem, "Moves of threads cannot be compensated.")
        self._forget(thread)
        if m[1]:
            self._set(m[1], Runtime(f"a thread (line {node.line})"))
        self.track.event(comment_word(node.text), node.line)

    def _statement(self, node: UrNode) -> None:
        if (fast := FAST.fullmatch(node.text)) and bool(fast[2]) == bool(fast[10]):
            self.mover.fast(node, fast)
            return
        if node.text[0] == "$" or LABEL.match(node.text):  # $ 3 "Waypoint_1": a line of PolyScope's program tree
            self._refuse_swallowed(node, control.swallowed(node.text))
            return
        if m := RUN.fullmatch(node.text):
            self._thread(node, m)
            return
        if m := CALL.match(node.text):
            self._call(node, m[1], node.start + m.end())
            return
        if m := control.ASSIGN.match(node.text):
            value = UrExpression(self.text, node.start + m.end(), node.end, self.values).whole()
            if isinstance(value, Runtime):
                if MOTION.search(node.text):
                    problem = f"{node.text[:50]!r}: {value.reason}"
                    raise self._refused(node, problem, "Threads cannot be compensated.")
                value = Runtime(f"{value.reason} (line {node.line})")
                self._side_effects(node)
            if self.kept and node.text.startswith("local"):
                self.kept[-1].setdefault(m[1], self.values.get(m[1]))
            self._set(m[1], value)
            return
        remedy = "Expected a move, an assignment, or a call of a function of the file."
        raise self._refused(node, f"{node.text[:50]!r} is not read", remedy)

    def _call(self, node: UrNode, name: str, at: int) -> None:
        if name in self.functions:
            self._function(node, self.functions[name], at)
        elif HARMLESS.fullmatch(name):
            self._refuse_swallowed(node, control.swallowed(node.text))
            self._side_effects(node)
            self.track.event(comment_word(node.text), node.line, "" if QUIET.fullmatch(name) else name)
        elif name in PARAMETERS:
            self.mover.move(node, name, self.mover.arguments(node, at))
        elif name == "set_tcp":
            self._set_tcp(node, self.mover.arguments(node, at))
        elif name in ("set_payload", "set_target_payload"):
            self._set_payload(node, self.mover.arguments(node, at))
        else:
            remedy = "Expected movej, movel, movep, movec, set_tcp, set_payload or a function of the file."
            raise self._refused(node, f"{name}() is not read", remedy)

    def _function(self, node: UrNode, function: UrNode, at: int) -> None:
        found = UrExpression(self.text, at, node.end, self.values).arguments()
        given: list[Value | Runtime]
        if isinstance(found, Runtime):
            given = [found] * len(function.parameters)
            self._side_effects(UrNode(word="", text=self.text[at : node.end], line=node.line, start=at, end=node.end))
        else:
            given = [v for _, v in found]
        if len(given) != len(function.parameters) or len(self.kept) >= 30:
            problem = f"{function.name}() with {len(given)} arguments, or calling itself"
            raise self._refused(node, problem, f"Expected {len(function.parameters)} arguments and no recursion.")
        kept = {name: self.values.get(name) for name in function.parameters}
        for name, value in zip(function.parameters, given, strict=True):
            self._set(name, value)
        self.kept.append(kept)
        self.block(function.body)
        self.kept.pop()
        for name, old in kept.items():
            if old is None:
                self._set(name, Runtime(f"{name} has no value here"))
            else:
                self._set(name, old)

    def _set_tcp(self, node: UrNode, given: list[tuple[str, Value]]) -> None:
        pose = given[0][1] if given else None
        if not isinstance(pose, UrPose) or len(given) > 2:
            raise self._refused(node, "set_tcp of something else than a pose", "Expected set_tcp(p[...]).")
        self.mover.tools.tcp(pose)

    def _set_payload(self, node: UrNode, given: list[tuple[str, Value]]) -> None:
        mass = given[0][1] if given else None
        if isinstance(mass, bool) or not isinstance(mass, float):
            raise self._refused(node, "set_payload without a mass", "Expected set_payload(kg, [x, y, z]).")
        self.mover.tools.payload(mass, given[1][1] if len(given) > 1 else None)
