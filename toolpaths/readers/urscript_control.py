"""URScript beside its moves: what is let pass, and whether the arm moves in what a condition or a thread runs.

Source: Universal Robots, The URScript Programming Language (modules interfaces and IO configuration, threads).
"""

from __future__ import annotations

import re

from toolpaths.readers.urscript_scan import Node

CALL = re.compile(r"([A-Za-z_]\w*)\s*\(")
HARMLESS = re.compile(
    r"set_(?:\w+_)?(?:digital|analog)_out|set_(?:standard|configurable|tool|gp|runstate|analog|euromap\w*)_\w+|"
    r"set_flag|set_gravity|set_input_actions_to_default|set_safety_mode_transition_hardness|set_baselight\w*|"
    r"popup|textmsg|varmsg|sleep|sync|assert|enter_critical|exit_critical|reset_world_model|"
    r"modbus_(?!get)\w+|tool_modbus_\w+|rpc_call|socket_(?!read|get)\w+|rtde_\w+|step_count_\w+|"
    r"write_(?:output_\w+_register|port_\w+)|zero_ftsensor|stopl|stopj|request_\w+"
)
MOTION = re.compile(
    r"\b(?:move[a-z]+|servo[a-z]+|speed[jl]|force_mode|set_tcp|conveyor\w*|track_conveyor\w*|freedrive\w*|teach_mode|"
    r"path_offset\w*|run|position_deviation\w*)\b"
)
#: A thread is started, is ended.
RUN = re.compile(r"(?:(?:global\s+|local\s+)?([A-Za-z_]\w*)\s*=\s*)?run\s+([A-Za-z_]\w*)\s*\(\s*\)")
LABEL = re.compile(r"(?:kill|join)\s+[A-Za-z_]\w*$")
#: Functions that a skipped block may reach; beyond that it is refused unread.
_MOST_CALLED = 100


def moving(node: Node, functions: dict[str, Node], seen: set[str] | None = None) -> Node | None:
    """The first statement inside that moves the arm or sets how it moves, also in functions that are called."""
    seen = set() if seen is None else seen
    for inner in node.body:
        if inner.word:
            found = moving(inner, functions, seen)
        else:
            found = inner if MOTION.search(inner.text) or inner.text in ("halt", "return") else None
            for name in CALL.findall(inner.text):
                if found is None and name in functions and name not in seen:
                    seen.add(name)
                    deep = len(seen) > _MOST_CALLED
                    found = inner if deep or moving(functions[name], functions, seen) else None
        if found is not None:
            return found
    return None
