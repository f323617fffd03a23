"""The words of Fanuc TP programs, and what the reader does with each: for the pages and for tests."""

from __future__ import annotations

from toolpaths.interpreting.vocabulary import HONOURED, REFUSED, REMARK, Vocabulary
from toolpaths.languages.fanuc.called_program import REMARKS

_READ = "J P[n] |L P[n]|C P[n] P[n]|UFRAME_NUM=|UTOOL_NUM=|UFRAME[n]=PR[n]|UTOOL[n]=PR[n]|R[n]=|PR[n,i]=|CALL|END|ABORT"
_CANNOT = (
    "L PR[n]|A P[n]|JMP LBL[n]|FOR|SELECT|RUN|WAIT ... TIMEOUT,LBL[n]|$NAME=|Offset|Tool_Offset|Skip|INC|Wjnt|"
    "IF in front of a move"
)
VOCABULARY: dict[str, Vocabulary] = {
    "instructions": Vocabulary(
        {
            HONOURED: [word.strip() for word in _READ.split("|")],
            REMARK: [*REMARKS, "IF ... of what moves nothing", "J PR[n] where no cut follows", "!", "//", "--eg:"],
            REFUSED: _CANNOT.split("|"),
        }
    ),
    "options of a move": Vocabulary(
        {HONOURED: "FINE CNTn CDn CRn", REMARK: ["ACCn", "PTH", "BREAK", "EVn%", "TB, TA, DB with a call or an output"]}
    ),
}
