"""The words of RAPID, and what the reader does with each: for the pages and for tests."""

from __future__ import annotations

from toolpaths.interpreting.vocabulary import HONOURED, REFUSED, REMARK, Vocabulary
from toolpaths.languages.rapid.calls import WORDS

VOCABULARY: dict[str, Vocabulary] = {
    "instructions": Vocabulary(
        {
            HONOURED: "MoveL MoveJ MoveC MoveAbsJ := FOR IF TEST RETURN EXIT MODULE PROC CONST PERS VAR LOCAL TASK",
            REMARK: [*WORDS.split(), "!"],
            REFUSED: """WHILE GOTO MoveLDO MoveJDO MoveCDO MoveExtJ TriggL TriggC TriggJ SearchL SearchC PDispOn
                PDispSet EOffsOn EOffsSet CorrCon CorrWrite SoftAct StorePath RestoPath StartMove StopMove IndAMove
                EGMRunPose SyncMoveOn DropWObj""",
        }
    )
}
