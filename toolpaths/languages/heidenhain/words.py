"""The words of HEIDENHAIN Klartext: M functions and blocks that are settings, kept as remarks, or refused.

Sources: iTNC 530, TNC 620 and TNC 640 conversational programming (M functions, path functions, special functions).
"""

from __future__ import annotations

import re

#: M functions that change how a path is followed, not where: smoothing (90, 112, 124), contour steps, open and outer
#: corners (97, 98, 197), replacement tools (101, 102, 107, 108), feed at arcs and of rotary axes (109 to 113, 116,
#: 117), look-ahead (120), handwheel and monitoring (118, 141, 142, 150), axes that swivel (138), lift-off (148, 149),
#: display (94).
M_SETTINGS = frozenset((90, 94, 97, 98, 101, 102, 107, 108, 109, 110, 111, 112, 113, 116, 117, 118, 120, 124, 138, 141,
                        142, 148, 149, 150, 197))  # fmt: skip
#: Letters that belong to an M function behind it, not to the block.
M_WORDS: dict[int, str] = {
    94: "A B C", 101: "BT", 103: "F", 112: "T A", 118: "X Y Z A B C MB VT", 120: "LA", 124: "T", 128: "F", 138: "A B C",
    140: "MB MAX F FMAX", 197: "DL",
}  # fmt: skip
M_REFUSED: dict[int, str] = {
    104: "it goes back to an earlier datum",
    114: "it corrects for a tilted tool while the machine runs; post M128 or PLANE",
    115: "it ends M114; post M128 or PLANE",
    130: "points of the untilted system while the plane is tilted; post PLANE RESET before it",
    132: "kinematics of the machine",
    143: "it deletes the basic rotation of the preset",
    144: "kinematics of the machine; post M128 or PLANE",
    145: "kinematics of the machine; post M128 or PLANE",
}
_RADIUS = "it belongs to cutter compensation (RL, RR); let CAM compensate"
_FREE = "free contour programming; post L and C"
_PROBE = "probing: it acts while the machine runs"
#: First words of blocks that are refused, and why.
REFUSED: dict[str, str] = {
    "APPR": _RADIUS,
    "DEP": _RADIUS,
    **dict.fromkeys(("FPOL", "FL", "FLT", "FC", "FCT", "FSELECT"), _FREE),
    "TCH": _PROBE,
    "SPL": "a spline; post lines",
    "PATTERN": "a pattern of the control; post each place",
    "POLARKIN": "polar kinematics",
    "SEL": "a file that is chosen while the machine runs; post in one file",
    "CONTOUR": "a contour cycle; post its moves",
    "VECTOR": "an unknown block",
}
#: Kept as remarks.
REMARKS = frozenset(("BLK", "STOP", "OPEN", "CLOSE", "WRITE", "READ", "DECLARE", "INFORMATION", "AFC"))
#: Cycles of the 200s and others that are refused where they are defined, by the first numbers that fit.
CYCLES_REFUSED: dict[int, str] = (
    dict.fromkeys((2, 17, 18, 206, 207, 209), "tapping: the spindle turns with the feed")
    | dict.fromkeys((202, 204), "boring with an oriented spindle")
    | dict.fromkeys((8,), "it mirrors the coordinates; post without it")
    | dict.fromkeys((12,), "a program called by a cycle; put it into the file")
    | dict.fromkeys((208, 241), "a cycle that depends on the tool in the table; post its moves")
    | dict.fromkeys((11, 26), "it scales the coordinates; post without it")
)
#: What ends those of them that may be on, in their later lines.
CYCLES_OFF = {
    8: re.compile(""),
    11: re.compile(r"SCL\s*\+?1(?:[.,]0*)?"),
    26: re.compile(r"(?:[XYZ]\s*\+?1(?:[.,]0*)?\s*)+"),
}
#: Cycles that are settings: kept as remarks (dwell, orientation, tolerance, graphics and monitoring of builders).
CYCLES_PASSED = frozenset((9, 13, 32, 392, 332))
#: FN n that are refused, and how many parameters those set that set more than one.
FUNCTIONS_REFUSED: dict[int, str] = dict.fromkeys((17, 25, 32), "it writes into the control; post without it")
FUNCTIONS_SET: dict[int, int] = {23: 3, 24: 3}
