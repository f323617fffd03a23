"""The words of SINUMERIK 840D programs: what sets nothing that counts here, what is kept as a remark, what is refused.

Source: SINUMERIK 840D sl / 828D / ONE, NC programming (Fundamentals, Job planning): G groups, lists of words.
"""

from __future__ import annotations

_SETTINGS = (
    "ACCLIMA BLSYNC BRISK BRISKA CFC CFIN CFTCP COARSEA COMPCAD COMPCURV COMPOF COMPON COMPPATH COMPSURF CP CPRECOF "
    "CPRECON CUT2D CUT2DD CUT2DF CUT2DFD CUT3DC CUT3DCC CUT3DCCD CUT3DF CUT3DFF CUT3DFS DELAYFSTOF DELAYFSTON "
    "DIAMOF DISPLOF DISPLON DRIVE DRIVEA DYNFINISH DYNNORM DYNPOS DYNPREC DYNROUGH DYNSEMIFIN FENDNORM FFWOF FFWON "
    "FIFOCTRL FINEA FNORM FTOCOF IPOENDA IPTRLOCK IPTRUNLOCK JERKLIMA KONT KONTC KONTT LFOF LFTXT LFWP NORM ORIAXES "
    "ORIC ORID ORISOF ORISON ORIVECT ORIPLANE OSB OSC OSD OSOF OSS OSSE OST PAROTOF RMI RMN RTLIOF RTLION SBLOF "
    "SBLON SOFT SOFTA SPATH STARTFIFO STOPFIFO STOPRE TOROTOF TOFRAMEOF TOWSTD UPATH WALIMOF WALIMON WALCS0"
)
#: How a controller follows the path: acceleration, jerk, smoothing, block compression, look-ahead, orientation between
#: two vectors, block display. They change no place that is programmed.
SETTINGS = frozenset(_SETTINGS.split())
_SETTING_VALUES = (
    "ACC ACCLIM ADIS ADISPOS ATOL CTOL DISC DISPR FA FGREF FL JERKLIM LIMS OTOL OVRA OVRRAP SCC SVC VELOLIM "
    "VELOLIMA SPOS SPOSA FD ISD"
)
#: The same, with a value: CTOL=0.01, ACC[X]=80.
SETTING_VALUES = frozenset(_SETTING_VALUES.split())
_EVENT_CALLS = (
    "MSG CYCLE832 WORKPIECE GROUP_BEGIN GROUP_END FGROUP WAITM WAITMC WAITE WAITP WAITS INIT START SETM CLEARM "
    "SETAL WRITE READ DELETE ISFILE CANCEL ENABLE DISABLE CLRINT CALLPATH SPCON SPCOF DRFOF EXTCLOSE EXTOPEN MMC "
    "CYCLE_HSC ORISOLH PRLOC LOCK UNLOCK"
)
#: Calls between moves that set nothing that moves depend on: kept as remarks.
EVENT_CALLS = frozenset(_EVENT_CALLS.split())
_RUNTIME = "it acts while the machine runs"
_REASONS = {
    "a spline or polynomial; post lines and arcs": "ASPLINE BSPLINE CSPLINE POLY POLYPATH ORICURVE",
    "an involute; post lines and arcs": "INVCW INVCCW",
    "it scales or mirrors the coordinates; post without it": "SCALE ASCALE MIRROR AMIRROR CSCALE CMIRROR",
    "it turns or scales the coordinates by what only the controller knows; post TRANS, ROT or CYCLE800":
        "ROTS AROTS CROTS TOFRAME TOFRAMEX TOFRAMEY TOFRAMEZ TOROT TOROTX TOROTY TOROTZ PAROT MEAFRAME NEWCONF",
    "a word of lathes; read are programs for a tool that mills or drills":
        "DIAMON DIAM90 DIAMCYCOF TRANSMIT TRACYL TRAANG TRACON THREAD",
    f"a synchronized action: {_RUNTIME}": "ID IDS WHEN WHENEVER FROM EVERY DO SETINT LIFTFAST",
    f"measuring: {_RUNTIME}": "MEAS MEAW MEASA MEAWA MEAC",
    "a move of the single axes; post lines and arcs": "PTP PTPG0 PTPWOC",
    "the way of the orientation; post vectors": "ORICONCW ORICONCCW ORICONTO ORICONIO ORIPATH ORIPATHS",
    "a tool holder that turns the tool; post TRAORI or CYCLE800": "TCARR TCOABS TCOFR TCOFRX TCOFRY TCOFRZ",
    "axes or spindles that are coupled": "COUPON COUPONC COUPDEF TRAILON LEADON EGON EGDEF PUNCHACC SON PON AXCTSWE",
    "an axis that is positioned on its own": "POS POSA POSP OSP1 OSCILL",
    f"a call by text: {_RUNTIME}": "EXECSTRING ISOCALL PCALL EXECTAB DEFINE",
    "it sets where an axis is; post without it": "PRESETON PRESETONS",
    "a contour by angles; post its points": "ANG",
    "a rounding of every corner; post RND= with each": "RNDM",
    "a feed of every corner; post FRC= with each": "FRCM",
    "it scales the feed; post F": "OVR",
    f"a jump by a table: {_RUNTIME}": "CASE",
    "an allowance on the contour; let CAM compute it": "OFFN",
    "an offset of the tool; let CAM compute it": "TOFFL TOFF TOFFR TOFFON",
    "an orientation by lead and tilt; post A3= B3= C3=": "LEAD TILT",
    "a transformation of the machine; post TRAORI": "TRAFOON",
    "the begin of a Klartext program; name the file .h": "BEGIN",
}
#: Words that are refused, and why.
REFUSED: dict[str, str] = {word: why for why, listed in _REASONS.items() for word in listed.split()}

#: G words that count as settings here, with those that choose what this reader does anyway.
G_SETTINGS = frozenset((9, 40, 60, 62, 64, 97, 290, 450, 451, 452, 460, 461, 462, 601, 602, 603, 621, 641, 642, 643,
                        644, 645, 971, 972, 973))  # fmt: skip
G_SYSTEMS = frozenset((500, 54, 55, 56, 57, *range(505, 600)))
_ISO = "a word of the ISO dialect"
#: G words that are refused, and why.
G_REFUSED: dict[int, str] = (
    dict.fromkeys((41, 42), "cutter compensation; let CAM compensate ('in computer')")
    | dict.fromkeys((33, 34, 35, 331, 332, 335, 336, 63), "threading or tapping: the spindle turns with the feed")
    | dict.fromkeys((147, 148, 247, 248, 340, 341, 347, 348), "a smooth approach; post its moves")
    | dict.fromkeys((96, 961, 962, 942, 952), "a cutting speed of lathes; post with G97")
    | dict.fromkeys((58, 59), "it shifts single axes; post TRANS")
    | dict.fromkeys((20, 21), f"{_ISO}; write G710 (mm) or G700 (inch)")
    | dict.fromkeys((43, 49, 80, 81, 82, 83, 98, 99), f"{_ISO}: is this G-code of another controller? Name it .nc")
    | dict.fromkeys((5, 7), "an oblique plunge; post its moves")
    | {
        28: f"{_ISO}; write G75 or SUPA",
        70: "lengths in inch, but F in the unit of the machine, which is not in the file; write G700 (both in inch)",
        291: "the ISO dialect; give that program as .nc",
    }
)
#: Letters that are words here.
LETTERS = frozenset("XYZABCIJKFSTDHPL")
