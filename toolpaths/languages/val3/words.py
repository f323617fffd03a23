"""Instructions of VAL3: what a reader does with each.

Source: Staubli VAL3 Reference Manual (D28062804A): 3 language (control of sequence), 6 tasks, 7 user interface,
9 movement control.
"""

from __future__ import annotations

import re

from toolpaths.interpreting.vocabulary import HONOURED, REFUSED, REMARK, SETTING, Vocabulary
from toolpaths.reading.swallowed import Swallowing, behind_call, shown, without_quotes

_MOVES = re.compile(r"(?<![\w.:])(?:mov[a-z]+|alter[A-Z]\w*|link)\s*\(|(?<![\w.:])(?:call|return)(?!\w)", re.IGNORECASE)
_SECOND = re.compile(r"(?!//|(?:and|or|xor|to|step|do)(?!\w))[A-Za-z_$]\w*", re.IGNORECASE)
_SET = re.compile(r"(?<![=<>!:])=(?!=)")
#: What a statement must not hold behind its first word.
SWALLOWING = Swallowing(_MOVES)


def second_statement(text: str, at: int) -> str:
    """What is wrong with a statement that holds another one behind the place ``at``; empty: nothing."""
    if problem := SWALLOWING.problem(text, at):
        return problem
    more = _SECOND.match(behind_call(text)) or len(_SET.findall(without_quotes(text))) > 1
    return f"{shown(text)!r} is more than one statement" if more else ""


#: Remarks that act on nothing outside of the controller.
_QUIET = "// cls put putln title gotoxy userPage get logMsg popUpMsg"
QUIET = frozenset(_QUIET.split(" "))
#: The word that closes each block.
OPENS = {"if": "endif", "while": "endwhile", "for": "endfor", "do": "until", "switch": "endswitch"}
#: Instructions, by their first word; with ``=``: assignments, to a field or to a name of the program.
WORDS = Vocabulary(
    {
        HONOURED: "movej movel movec appro call begin end return link .trsf= .tvel= .vel= .blend= .leave= .reach=",
        SETTING: """waitEndMove resetMotion restartMove stopMove autoConnectMove setMonitorSpeed setVelocity enablePower
            .accel= .decel= .rvel= .config=""",
        REMARK: f"""{_QUIET} = delay wait watch open close setMutex taskCreate taskKill taskSuspend taskResume
            taskStatus workingMode ioBusStatus aioSet dioSet if elseIf else endIf while endWhile for endFor do until
            switch case default break endSwitch""",
        REFUSED: """movejx movecx setFrame setLatch onError goto alter alterMovej alterMovel alterMovec alterBegin
            alterEnd""",
    }
)
