"""The words of KRL, and what the reader does with each: for the pages and for tests."""

from __future__ import annotations

from toolpaths.interpreting.vocabulary import HONOURED, REFUSED, REMARK, Vocabulary
from toolpaths.languages.krl.remarks import REMARKS
from toolpaths.languages.krl.scan import REFUSED_BLOCKS

VOCABULARY: dict[str, Vocabulary] = {
    "statements": Vocabulary(
        {
            HONOURED: """PTP LIN CIRC SPTP SLIN SCIRC LIN_REL $BASE= $TOOL= $VEL= $VEL.CP= $APO.CDIS= C_DIS C_VEL C_ORI
                C_PTP BAS FOR IF SWITCH RETURN DEF DEFFCT DECL GLOBAL CONST STRUC ENUM""",
            REMARK: [*REMARKS.split(), "$OUT=", "$ANOUT=", ";", "&"],
            REFUSED: [*REFUSED_BLOCKS, "PTP_REL", "CA", "$POS_CORR", "$VEL_EXT", "$TECH", "$ON_PATH"],
        }
    )
}
