"""Instructions of VAL3: what a reader does with each.

Source: Staubli VAL3 Reference Manual (D28062804A): 3 language (control of sequence), 6 tasks, 7 user interface,
9 movement control.
"""

from __future__ import annotations

from toolpaths.interpreting.vocabulary import HONOURED, REFUSED, REMARK, SETTING, Vocabulary

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
