"""Moves of URScript: target, speed and blend radius of each, its tool and the frame that it is given in.

Source: Universal Robots, The URScript Programming Language (module motion, parameters and their defaults).
"""

from __future__ import annotations

import re

import numpy as np

from toolpaths.errors import ReadError
from toolpaths.interpreting.robot_moves import ARC, JOINTS, LINE, NOWHERE, PTP, Span
from toolpaths.interpreting.robot_track import RobotTrack
from toolpaths.interpreting.values import Runtime
from toolpaths.languages.urscript.expressions import LARGEST, UrExpression, UrPose, Value
from toolpaths.languages.urscript.scan import UrNode
from toolpaths.languages.urscript.tools import UrTools
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
#: A line to a pose whose six numbers stand in it, with or without a frame: most of every program.
FAST = re.compile(
    r"(movel|movep)\((?:pose_trans\(([A-Za-z_]\w*), ?)?(p\[" + r"\s*+,\s*+".join([_N] * 6) + r"\])(\)?)((?:,[^()]*)?)\)"
)
_BASE: Floats = np.eye(4)


def _quaternions(numbers: Floats) -> Floats:
    """Of rotation vectors rad (N, 4), the last unused."""
    known = np.isfinite(numbers[:, 0])
    out = np.full((len(numbers), 4), np.nan)
    out[known] = quaternion_from_matrix(matrix_from_ur(numbers[known, :3]))
    return out


class UrMover:
    """Turns the moves of one run into moves of a track.

    Args:
        text: the whole file.
        source: the file as the user named it.
        values: what names stand for at the place that runs; they are the interpreter's.

    Attributes:
        tools: of set_tcp and set_payload.
    """

    def __init__(self, text: str, source: str, values: dict[str, Value | Runtime]) -> None:
        self.text, self.source, self.values = text, source, values
        self.track = RobotTrack(source, "urscript", _quaternions)
        self.tools = UrTools(self.track)
        self._tails: dict[tuple[str, str], dict[str, float]] = {}
        self._frames: dict[str, Floats] = {}

    def forget(self) -> None:
        """Names may mean something else from here on."""
        self._tails.clear()
        self._frames.clear()

    def _refused(self, node: UrNode, problem: str, remedy: str) -> ReadError:
        return ReadError(self.source, node.line, problem, remedy)

    def arguments(self, node: UrNode, at: int) -> list[tuple[str, Value]]:
        """Arguments of the call behind its bracket, all of them known.

        Raises:
            ReadError: one is not, or text follows the call.
        """
        expression = UrExpression(self.text, at, node.end, self.values)
        out = expression.arguments()
        if isinstance(out, Runtime):
            remedy = "Give numbers, or names that are set to numbers before."
            raise self._refused(node, f"{node.text[:50]!r}: {out.reason}", remedy)
        if self.text[expression.at : node.end].strip():
            raise self._refused(node, f"text behind {node.text[:30]!r}", "Give each statement its own line.")
        return out

    def fast(self, node: UrNode, m: re.Match[str]) -> None:
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
        self._append(node, shape=LINE, kind=kind, to=UrPose(numbers, *span, frame), via=None, options=options)

    def _tail(self, node: UrNode, m: re.Match[str]) -> list[tuple[str, Value]]:
        if not m[11]:
            return []
        return self.arguments(node, node.start + m.start(11) + 1)

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

    def move(self, node: UrNode, word: str, given: list[tuple[str, Value]]) -> None:
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
        self._append(node, shape=shape, kind=kind, to=to, via=via if isinstance(via, UrPose) else None, options=options)

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
