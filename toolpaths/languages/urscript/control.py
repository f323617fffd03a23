"""URScript beside its moves: what is let pass, and whether the arm moves in what a condition or a thread runs.

Source: Universal Robots, The URScript Programming Language (modules interfaces and IO configuration, threads).
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from toolpaths.languages.urscript.scan import FUNCTIONS, UrNode
from toolpaths.reading.swallowed import Swallowing, behind_call, shown

CALL = re.compile(r"([A-Za-z_]\w*)\s*\(")
_PLAIN = (
    "set_flag set_gravity set_input_actions_to_default set_safety_mode_transition_hardness popup textmsg varmsg sleep "
    "sync assert enter_critical exit_critical reset_world_model rpc_call zero_ftsensor stopl stopj"
)
#: Functions of the controller that neither move the arm nor set how it moves: as the page shows them -> pattern.
REMARKS: dict[str, str] = {name: name for name in _PLAIN.split()} | {
    "set_*_digital_out": r"set_(?:\w+_)?digital_out",
    "set_*_analog_out": r"set_(?:\w+_)?analog_out",
    "set_standard_*": r"set_standard_\w+",
    "set_configurable_*": r"set_configurable_\w+",
    "set_tool_*": r"set_tool_\w+",
    "set_gp_*": r"set_gp_\w+",
    "set_runstate_*": r"set_runstate_\w+",
    "set_analog_*": r"set_analog_\w+",
    "set_euromap*": r"set_euromap\w*_\w+",
    "set_baselight*": r"set_baselight\w*",
    "modbus_* (not modbus_get_*)": r"modbus_(?!get)\w+",
    "tool_modbus_*": r"tool_modbus_\w+",
    "socket_* (not those that read)": r"socket_(?!read|get)\w+",
    "rtde_*": r"rtde_\w+",
    "step_count_*": r"step_count_\w+",
    "write_output_*_register": r"write_output_\w+_register",
    "write_port_*": r"write_port_\w+",
    "request_*": r"request_\w+",
}
HARMLESS = re.compile("|".join(REMARKS.values()))
#: Of these the ones that another language has no need of.
QUIET = re.compile(
    r"set_gravity|set_safety_mode_transition_hardness|textmsg|varmsg|sync|assert|enter_critical|exit_critical|"
    r"reset_world_model|step_count_\w+|zero_ftsensor|stopl|stopj"
)
MOTION = re.compile(
    r"\b(?:move[a-z]+|servo[a-z]+|speed[jl]|force_mode|set_tcp|conveyor\w*|track_conveyor\w*|freedrive\w*|teach_mode|"
    r"path_offset\w*|run|position_deviation\w*)\b"
)
ASSIGN = re.compile(r"(?:(?:global|local)\s+)?([A-Za-z_]\w*)\s*=(?!=)\s*")
#: What a remark must not hold.
SWALLOWING = Swallowing(re.compile(rf"{MOTION.pattern}\s*\(|\brun\s+\w+\s*\("))
_ITEM = re.compile(r"([A-Za-z_]\w*)\s*\[[^\[\]]*\]\s*=(?!=)")
#: Ends a function or the program.
LEAVES = re.compile(r"halt$|return\b")
#: A thread is started, is ended.
RUN = re.compile(r"(?:(?:global\s+|local\s+)?([A-Za-z_]\w*)\s*=\s*)?run\s+([A-Za-z_]\w*)\s*\(\s*\)")
LABEL = re.compile(r"(?:kill|join)\s+[A-Za-z_]\w*$")
#: Functions that a skipped block may reach; beyond that it is refused unread.
_MOST_CALLED = 100


def swallowed(text: str) -> str:
    """What is wrong with a statement that is kept as a remark, and holds another one; empty: nothing."""
    if problem := SWALLOWING.problem(text):
        return problem
    return f"{shown(text)!r} is more than one statement" if behind_call(text).strip("; ") else ""


def moving(node: UrNode, functions: dict[str, UrNode], seen: set[str] | None = None) -> UrNode | None:
    """The first statement inside that moves the arm or sets how it moves, also in functions that are called."""
    seen = set() if seen is None else seen
    for inner in node.body:
        steers = not inner.word and (MOTION.search(inner.text) or inner.text in ("halt", "return"))
        found = inner if steers else moving_call(inner, functions, seen)
        if found is None and inner.word:
            found = moving(inner, functions, seen)
        if found is not None:
            return found
    return None


def moving_call(node: UrNode, functions: dict[str, UrNode], seen: set[str] | None = None) -> UrNode | None:
    """The node itself, where its own line (a statement, a condition) calls a function that moves the arm."""
    seen = set() if seen is None else seen
    for name in () if node.word in FUNCTIONS else CALL.findall(node.text):
        if name in functions and name not in seen:
            seen.add(name)
            if len(seen) > _MOST_CALLED or moving(functions[name], functions, seen):
                return node
    return None


def assigned(node: UrNode, functions: dict[str, UrNode], seen: set[str] | None = None) -> Iterator[tuple[str, int]]:
    """Names that a statement or a block sets, also in functions that it calls, with their lines."""
    seen = set() if seen is None else seen
    if not node.word and (m := ASSIGN.match(node.text) or _ITEM.match(node.text)):
        yield m[1], node.line
    yield from called(node, functions, seen)
    for inner in node.body:
        yield from assigned(inner, functions, seen)


def called(node: UrNode, functions: dict[str, UrNode], seen: set[str]) -> Iterator[tuple[str, int]]:
    """Names that functions set which the line of ``node`` calls."""
    for name in () if node.word in FUNCTIONS else CALL.findall(node.text):
        if name in functions and name not in seen:
            seen.add(name)
            yield from assigned(functions[name], functions, seen)
