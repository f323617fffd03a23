"""Instructions of RAPID that are no moves: which do not matter to the poses, which cannot be followed.

Source: ABB 3HAC050917 "RAPID Instructions, Functions and Data types".
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from toolpaths.interpreting.program_text import CHOICE, COMMENT, PLAIN, Statement
from toolpaths.interpreting.values import Runtime
from toolpaths.languages.rapid.expressions import RapidExpression
from toolpaths.languages.rapid.names import RapidNames

#: Instructions that are remarks.
WORDS = (
    "ConfJ ConfL SingArea AccSet VelSet TPWrite TPErase TPReadFK WaitTime WaitDI WaitDO WaitAI WaitGI WaitUntil "
    "WaitRob SetDO SetAO SetGO Set Reset PulseDO InvertDO Stop Break ActUnit DeactUnit GripLoad CirPathMode ClkReset "
    "ClkStart ClkStop ErrWrite Write Open Close MotionSup SoftDeact PathAccLim WorldAccLim WaitWObj Incr Decr "
    "PDispOff EOffsOff IDelete"
)
HARMLESS = frozenset(WORDS.lower().split())
#: Of these the ones that are about how the arm moves, or talk to the operator: another language has its own.
_QUIET = (
    "ConfJ ConfL SingArea AccSet VelSet TPWrite TPErase TPReadFK GripLoad CirPathMode ClkReset ClkStart ClkStop "
    "ErrWrite Write Open Close MotionSup PathAccLim WorldAccLim Incr Decr PDispOff EOffsOff IDelete"
)
QUIET = frozenset(_QUIET.lower().split())
#: Of these the ones that set an argument.
SETTING = frozenset(("incr", "decr", "tpreadfk"))
STEERING = re.compile(
    r"move|trigg|search|pdisp|eoffs|corr|softact|worldacc|storepath|restopath|startmove|stopmove|ind[ar]|egm|isignal|"
    r"sync|mtool|mech|conveyor|dropwobj", re.I,
)  # fmt: skip


_GIVEN = re.compile(r'"[^"]*+"|[,\\]?\s*+(?:\w+\s*:=\s*)?([A-Za-z]\w*+)\s*+(?=[,\\.{]|$)|.', re.S)
_NUMBERS = ("num", "dnum", "bool", "string", "byte")


def idle(body: Iterable[Statement]) -> bool:
    """Whether statements neither move nor set anything."""
    return all(
        s.kind == COMMENT
        or (s.kind == PLAIN and s.word.lower() in HARMLESS - SETTING)
        or (s.kind == CHOICE and all(idle(branch.body) for branch in s.body))
        for s in body
    )


def without_poses(text: str, names: RapidNames) -> bool:
    """Whether arguments are numbers, texts and truths only: what else they are may be where the arm goes."""
    e = RapidExpression(text, names.look_up)
    while e.peek():
        while e.peek() in (",", "\\"):
            if e.take() == "\\":
                e.take()
                if e.peek() == ":=":
                    e.take()
        if name := e.peek():
            value = e.value()
            plain = isinstance(value, Runtime) and name[0].isalpha() and names.look_up(name)[0] in _NUMBERS
            if not plain and not isinstance(value, float | bool | str):
                return False
    return True


def given_names(text: str) -> list[str]:
    """Names that stand as arguments by themselves: the routine may set them."""
    return [m[1] for m in _GIVEN.finditer(text) if m[1]]
