"""Executes a URScript program as far as everything is constant, and collects the moves.

What sensors, loops or threads decide is refused by line where it could change a move. Source: Universal Robots, The
URScript Programming Language (module motion, parameters and their defaults).
"""

from __future__ import annotations

import re

import numpy as np

from toolpaths.errors import ReadError
from toolpaths.interpreting.robot_moves import ARC, JOINTS, LINE, NOWHERE, PTP, Span
from toolpaths.interpreting.robot_track import RobotTrack
from toolpaths.interpreting.values import Runtime
from toolpaths.languages.urscript import control
from toolpaths.languages.urscript.control import CALL, HARMLESS, LABEL, MOTION, RUN, moving
from toolpaths.languages.urscript.expressions import LARGEST, UrExpression, UrPose, Value
from toolpaths.languages.urscript.scan import FUNCTIONS, UrNode
from toolpaths.languages.urscript.tools import UrTools
from toolpaths.reading.source_text import comment_word
from toolpaths.rotation import matrix_from_ur, quaternion_from_matrix
from toolpaths.toolpath import CUT, RAPID, Floats

#: Parameters in their order; the pose or joints come first.
PARAMETERS = {
    "movej": ("", "a", "v", "t", "r"),
    "movel": ("", "a", "v", "t", "r"),
    "movep": ("", "a", "v", "r"),
    "movec": ("", "", "a", "v", "r", "mode"),
}
_DEFAULTS = {"a": 1.2, "v": 0.25, "t": 0.0, "r": 0.0, "mode": 0.0}
_N = r"(-?(?:\d++\.?\d*+|\.\d++)(?:[eE][-+]?\d++)?)"
_FAST = re.compile(
    r"(movel|movep)\((?:pose_trans\(([A-Za-z_]\w*), ?)?(p\[" + r"\s*+,\s*+".join([_N] * 6) + r"\])(\)?)((?:,[^()]*)?)\)"
)
_TOO_OFTEN = "functions call each other more often than the file is long"


def _quaternions(numbers: Floats) -> Floats:
    """Of rotation vectors rad (N, 4), the last unused."""
    known = np.isfinite(numbers[:, 0])
    out = np.full((len(numbers), 4), np.nan)
    out[known] = quaternion_from_matrix(matrix_from_ur(numbers[known, :3]))
    return out


class UrInterpreter:
    """Execution of a program, statement by statement."""

    def __init__(self, text: str, source: str) -> None:
        self.text, self.source = text, source
        self.track = RobotTrack(source, "urscript", _quaternions)
        self.values: dict[str, Value | Runtime] = {}
        self.functions: dict[str, UrNode] = {}
        self.threads: dict[str, UrNode] = {}
        self.tools = UrTools(self.track)
        self.left = 10_000 + 20 * text.count("\n")
        self.kept: list[dict[str, Value | Runtime | None]] = []  # of every function that runs: what it hides
        self._tails: dict[tuple[str, str], dict[str, float]] = {}
        self._frames: dict[str, Floats] = {}

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
        self._tails.clear()
        self._frames.clear()

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
        if (fast := _FAST.fullmatch(node.text)) and bool(fast[2]) == bool(fast[10]):
            self._fast(node, fast)
            return
        if node.text[0] == "$" or LABEL.match(node.text):  # $ 3 "Waypoint_1": a line of PolyScope's program tree
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
            self._side_effects(node)
            self.track.event(comment_word(node.text), node.line)
        elif name in PARAMETERS:
            self._move(node, name, self._arguments(node, at))
        elif name == "set_tcp":
            self._set_tcp(node, self._arguments(node, at))
        elif name in ("set_payload", "set_target_payload"):
            self._set_payload(node, self._arguments(node, at))
        else:
            remedy = "Expected movej, movel, movep, movec, set_tcp, set_payload or a function of the file."
            raise self._refused(node, f"{name}() is not read", remedy)

    def _arguments(self, node: UrNode, at: int) -> list[tuple[str, Value]]:
        expression = UrExpression(self.text, at, node.end, self.values)
        out = expression.arguments()
        if isinstance(out, Runtime):
            remedy = "Give numbers, or names that are set to numbers before."
            raise self._refused(node, f"{node.text[:50]!r}: {out.reason}", remedy)
        if self.text[expression.at : node.end].strip():
            raise self._refused(node, f"text behind {node.text[:30]!r}", "Give each statement its own line.")
        return out

    def _function(self, node: UrNode, function: UrNode, at: int) -> None:
        found = UrExpression(self.text, at, node.end, self.values).arguments()
        given: list[Value | Runtime]
        if isinstance(found, Runtime):
            given = [found] * len(function.parameters)
            self._side_effects(UrNode("", self.text[at : node.end], node.line, at, node.end))
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
        self.tools.tcp(pose)

    def _set_payload(self, node: UrNode, given: list[tuple[str, Value]]) -> None:
        mass = given[0][1] if given else None
        if isinstance(mass, bool) or not isinstance(mass, float):
            raise self._refused(node, "set_payload without a mass", "Expected set_payload(kg, [x, y, z]).")
        self.tools.payload(mass, given[1][1] if len(given) > 1 else None)

    def _fast(self, node: UrNode, m: re.Match[str]) -> None:
        """A line to a pose whose six numbers stand in it: most of every program."""
        frame = self._frame(node, m[2]) if m[2] else None
        key = (m[1], m[11])
        options = self._tails.get(key)
        if options is None:
            given = [("", 0.0), *self._tail(node, m)]
            options = self._tails[key] = self._options(node, m[1], given)
        numbers = tuple(map(float, m.group(4, 5, 6, 7, 8, 9)))
        if not -LARGEST <= min(numbers) <= max(numbers) <= LARGEST:
            raise self._refused(node, f"{node.text[:40]!r}: a number that is too large", "Correct the number.")
        span = (node.start + m.start(3), node.start + m.end(3))
        kind = RAPID if "rapid" in m[11].lower() else CUT
        self._append(node, LINE, kind, UrPose(numbers, *span, frame), None, options)

    def _tail(self, node: UrNode, m: re.Match[str]) -> list[tuple[str, Value]]:
        if not m[11]:
            return []
        return self._arguments(node, node.start + m.start(11) + 1)

    def _frame(self, node: UrNode, name: str) -> Floats:
        if name not in self._frames:
            value = self.values.get(name)
            if not isinstance(value, UrPose):
                why = value.reason if isinstance(value, Runtime) else "no pose"
                raise self._refused(node, f"the frame {name}: {why}", f"Set {name} to p[...] before.")
            self._frames[name] = value.matrix()
        return self._frames[name]

    def _options(self, node: UrNode, word: str, given: list[tuple[str, Value]]) -> dict[str, float]:
        """Named numbers of a move; feed 0 or less is refused."""
        names, out = PARAMETERS[word], dict(_DEFAULTS)
        for i, (name, value) in enumerate(given):
            key = name or (names[i] if i < len(names) else "?")
            if key == "" or (key in ("pose", "q", "pose_via", "pose_to") and isinstance(value, UrPose | list)):
                continue
            if key not in names or isinstance(value, bool) or not isinstance(value, float):
                raise self._refused(node, f"{word} with {key or name}", f"Expected {', '.join(n for n in names if n)}.")
            out[key] = value
        if not (out["v"] > 0.0 and out["r"] >= 0.0 and out["t"] >= 0.0):
            problem = f"v = {out['v']:g}, r = {out['r']:g}, t = {out['t']:g}"
            raise self._refused(node, problem, "Expected a speed above 0 and a blend radius of 0 or more.")
        return out

    def _move(self, node: UrNode, word: str, given: list[tuple[str, Value]]) -> None:
        targets = 2 if word == "movec" else 1
        options = self._options(node, word, given)
        if len(given) < targets or options["mode"] != 0.0:
            problem = f"{word} without its poses, or with an orientation that follows the arc (mode 1)"
            raise self._refused(node, problem, "Expected movec(via, to, ...) with mode 0.")
        to, via = given[targets - 1][1], given[0][1] if word == "movec" else None
        if word == "movec" and (not isinstance(via, UrPose) or not isinstance(to, UrPose)):
            raise self._refused(node, "movec through joint angles", "Give both points as p[...].")
        shape = ARC if word == "movec" else LINE if word != "movej" else PTP if isinstance(to, UrPose) else JOINTS
        kind = RAPID if word == "movej" or "rapid" in node.text.lower() else CUT
        self._append(node, shape, kind, to, via if isinstance(via, UrPose) else None, options)

    def _append(
        self, node: UrNode, shape: int, kind: np.uint8, to: Value, via: UrPose | None, options: dict[str, float]
    ) -> None:
        nan = float("nan")
        frame, span = None, NOWHERE
        pose: tuple[float, ...] = (nan,) * 6
        if isinstance(to, UrPose):
            frame, span = to.frame, (to.start, to.end, node.start, node.end)
            pose = (*(1e3 * v for v in to.numbers[:3]), *to.numbers[3:])
        elif isinstance(to, list) and len(to) == 6 and all(type(v) is float for v in to):
            self.track.joints[self.track.count] = np.array(to, dtype=np.float64)
        else:
            raise self._refused(node, f"{node.text[:40]!r}: no pose, no six joints", "Expected p[...] or [...].")
        feed = nan if options["t"] > 0.0 or kind == RAPID else options["v"] * 1e3
        through, via_span = self._via(frame, via)
        self.track.move(
            (*pose, 0.0, feed, options["r"] * 1e3, *through),
            (
                shape, int(kind), self.tools.number(), node.line, self.track.frame(_BASE if frame is None else frame),
                -1, node.start, node.end, *span, *via_span,
            ),
        )  # fmt: skip

    def _via(self, frame: Floats | None, via: UrPose | None) -> tuple[tuple[float, ...], Span]:
        """The via point in the frame of the end, mm, and its place."""
        if via is None:
            return (float("nan"),) * 3, NOWHERE
        inverse = np.linalg.inv(_BASE if frame is None else frame)
        point = (inverse @ via.matrix())[:3, 3] * 1e3
        return tuple(point.tolist()), (via.start, via.end, *NOWHERE[2:])


_BASE: Floats = np.eye(4)
