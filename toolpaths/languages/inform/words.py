"""Instructions of INFORM: what a reader does with each.

Sources: Yaskawa DX200 and YRC1000 INFORM Language (basic, control, arithmetic, move, shift, work instructions);
DX100 Data Transmission (HW0482494), 4.1 job data.
"""

from __future__ import annotations

import re

from toolpaths.interpreting.vocabulary import HONOURED, REFUSED, REMARK, SETTING, Vocabulary
from toolpaths.reading.swallowed import Swallowing

#: What a remark must not hold.
SWALLOWING = Swallowing(
    re.compile(r"(?<![\w#$-])(?:[A-Z+]*MOV[JLCS]|(?:E|EI)?IMOV[LC]?|CALL|JUMP|SFTON|SFTOF|SPEED|RET)(?![\w=])")
)
#: Head of a job.
HEAD = Vocabulary(
    {
        HONOURED: "/JOB //NAME //POS ///NPOS ///TOOL ///USER ///POSTYPE ///RECTAN ///RCONF ///PULSE //INST",
        SETTING: "///DATE ///COMM ///ATTR ////FRAME ///GROUP1 ///GROUP2 ///LVARS ///VAR ///FOLDERNAME",
    }
)
#: Remarks that act on nothing but the program itself.
_QUIET = "' * // MSG SET SETE GETE GETS INC DEC ADD SUB MUL DIV AND OR NOT XOR SIN COS ATAN SQRT CLS REFP"
QUIET = frozenset(_QUIET.split(" "))
#: Those whose line is text to its end.
TEXTS = frozenset(("'", "//"))
#: Instructions, by their first word.
WORDS = Vocabulary(
    {
        HONOURED: "MOVJ MOVL MOVC SPEED CALL RET NOP END",
        SETTING: "HPVELON HPVELOF CLEAR",
        REMARK: f"""{_QUIET} DOUT AOUT DIN AIN WAIT TIMER PAUSE PULSE SETTOOL SETREG GETREG ARCON ARCOF ARCSET
            WVON WVOF SVSPOT GUNCHG TOOLON TOOLOF CALLTOOL LASERON LASEROF ADVINIT ADVSTOP ABORT DIALOG TSYNC PSTART
            PWAIT""",
        REFUSED: """MOVS IMOV EIMOVL EIMOVC SMOVJ SMOVL SMOVC SMOVS +MOVJ +MOVL +MOVC +MOVS CVMOVJ CVMOVL CVMOVC
            CVMOVS SFTON SFTOF MSHIFT MFRAME MULMAT INVMAT CNVRT JUMP IF IFTHENEXP IFTHEN ELSEIF ELSE ENDIF WHILE
            WHILEEXP ENDWHILE FOR NEXT SWITCH CASE DEFAULT ENDSWITCH SYSTART SYEND""",
    }
)
