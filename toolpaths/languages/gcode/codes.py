"""G: the G words that are read, by name. A word is ten times its number, so that G91.1 is 911."""

from __future__ import annotations

from enum import IntEnum


class G(IntEnum):
    """A G word."""

    RAPID = 0
    LINE = 10
    ARC_CLOCKWISE = 20
    ARC_COUNTERCLOCKWISE = 30
    DWELL = 40
    SMOOTHING_LEVEL = 50  # G5 P; without P it is a spline
    SMOOTHING = 51  # G5.1 Q
    LOOK_AHEAD = 80
    EXACT_STOP_HERE = 90
    OFFSETS_SET = 100  # G10 L2 with zeros
    POLAR_INTERPOLATION_OFF = 131
    POLAR_COORDINATES_OFF = 150
    PLANE_XY = 170
    PLANE_ZX = 180
    PLANE_YZ = 190
    INCH = 200
    MM = 210
    HOME = 280
    OTHER_HOME = 300
    CUTTER_COMPENSATION_OFF = 400
    CUTTER_LEFT = 410
    CUTTER_LEFT_BY_DIAMETER = 411  # G41.1 D: the diameter stands in the file
    CUTTER_RIGHT = 420
    CUTTER_RIGHT_BY_DIAMETER = 421
    TOOL_LENGTH = 430
    TIP_CONTROL = 434  # with rotary words or tool vectors
    TIP_CONTROL_VECTORS = 435
    TOOL_LENGTH_OFF = 490
    SCALING_OFF = 500
    MIRROR_OFF = 501
    LOCAL_ORIGIN = 520
    MACHINE_PLACE = 530
    TOOL_INTO_PLANE = 531
    SYSTEM_1 = 540
    SYSTEM_MORE = 541  # G54.1 P
    SYSTEM_2 = 550
    SYSTEM_3 = 560
    SYSTEM_4 = 570
    SYSTEM_5 = 580
    SYSTEM_6 = 590
    SYSTEM_7 = 591
    SYSTEM_8 = 592
    SYSTEM_9 = 593
    EXACT_PATH = 610
    EXACT_STOP = 611
    BLENDING = 640
    MODAL_MACRO_OFF = 670
    TILTED_PLANE = 682
    ROTATION_OFF = 690
    CHIP_BREAKING = 730
    CYCLE_OFF = 800
    DRILLING = 810
    DRILLING_WITH_DWELL = 820
    PECKING = 830
    TAPPING = 840
    BORING = 850
    BORING_WITH_STOP = 860
    BORING_WITH_DWELL = 890
    ABSOLUTE = 900
    ABSOLUTE_CENTRE = 901
    RELATIVE = 910
    RELATIVE_CENTRE = 911
    SHIFT = 920
    SHIFT_FORGOTTEN = 921
    SHIFT_SET_ASIDE = 922
    SHIFT_RESTORED = 923
    INVERSE_TIME = 930
    PER_MINUTE = 940
    PER_TURN = 950
    SPINDLE_IN_TURNS = 970
    RETURN_TO_START = 980
    RETURN_TO_R = 990
    ACCURACY = 1870

    @property
    def word(self) -> str:
        """As programs have it: ``G91.1``."""
        return f"G{self / 10:g}"


ARCS = frozenset((G.ARC_CLOCKWISE, G.ARC_COUNTERCLOCKWISE))
#: Cycles that do something with the spindle, or wait, at the bottom: they are read, but not put in other words.
SPINDLE_CYCLES = frozenset((G.TAPPING, G.BORING_WITH_STOP, G.BORING_WITH_DWELL))
CYCLES = frozenset((G.CHIP_BREAKING, G.DRILLING, G.DRILLING_WITH_DWELL, G.PECKING, G.BORING)) | SPINDLE_CYCLES
MOTIONS = frozenset((G.RAPID, G.LINE, *ARCS, *CYCLES))
FEED_MODES = frozenset((G.INVERSE_TIME, G.PER_MINUTE, G.PER_TURN))
TIP_CONTROLS = frozenset((G.TIP_CONTROL, G.TIP_CONTROL_VECTORS))
RETRACTS = frozenset((G.HOME, G.OTHER_HOME, G.MACHINE_PLACE))
SHIFTS = frozenset((G.LOCAL_ORIGIN, G.SHIFT, G.SHIFT_FORGOTTEN, G.SHIFT_SET_ASIDE, G.SHIFT_RESTORED))
SYSTEMS = frozenset(
    (G.SYSTEM_1, G.SYSTEM_2, G.SYSTEM_3, G.SYSTEM_4, G.SYSTEM_5, G.SYSTEM_6, G.SYSTEM_7, G.SYSTEM_8, G.SYSTEM_9)
) | {G.SYSTEM_MORE}
#: They count in their block only.
SINGLE = RETRACTS | SHIFTS | {G.DWELL, G.OFFSETS_SET, G.TILTED_PLANE, G.TOOL_INTO_PLANE}
BY_DIAMETER = frozenset((G.CUTTER_LEFT_BY_DIAMETER, G.CUTTER_RIGHT_BY_DIAMETER))
COMPENSATIONS = frozenset((G.CUTTER_COMPENSATION_OFF, G.CUTTER_LEFT, G.CUTTER_RIGHT)) | BY_DIAMETER
RETURNS = frozenset((G.RETURN_TO_START, G.RETURN_TO_R))

#: Modal group, as messages name it -> its words; a block may hold one of each.
GROUPS: dict[str, frozenset[G]] = {
    "non-modal": SINGLE,
    "motion": MOTIONS,
    "cycle end": frozenset((G.CYCLE_OFF,)),  # a group of its own, as Fanuc has it: G0 G80 in one block is common
    "plane": frozenset((G.PLANE_XY, G.PLANE_ZX, G.PLANE_YZ)),
    "units": frozenset((G.INCH, G.MM)),
    "distance": frozenset((G.ABSOLUTE, G.RELATIVE)),
    "arc distance": frozenset((G.ABSOLUTE_CENTRE, G.RELATIVE_CENTRE)),
    "feed mode": FEED_MODES,
    "cutter compensation": COMPENSATIONS,
    "tool length": TIP_CONTROLS | {G.TOOL_LENGTH, G.TOOL_LENGTH_OFF},
    "work offset": SYSTEMS,
    "path control": frozenset((G.EXACT_PATH, G.EXACT_STOP, G.BLENDING)),
    "smoothing": frozenset((G.SMOOTHING, G.SMOOTHING_LEVEL, G.LOOK_AHEAD, G.ACCURACY)),
    "exact stop": frozenset((G.EXACT_STOP_HERE,)),
    "scaling": frozenset((G.SCALING_OFF,)),
    "mirror": frozenset((G.MIRROR_OFF,)),
    "polar coordinates": frozenset((G.POLAR_COORDINATES_OFF,)),
    "polar interpolation": frozenset((G.POLAR_INTERPOLATION_OFF,)),
    "modal macro": frozenset((G.MODAL_MACRO_OFF,)),
    "rotation": frozenset((G.ROTATION_OFF,)),
    "spindle mode": frozenset((G.SPINDLE_IN_TURNS,)),
    "cycle return": RETURNS,
}
GROUP = {g: name for name, words in GROUPS.items() for g in words}

#: Let pass on purpose: they choose what this reader does anyway (G10 L2 with zeros, G13.1, G15, G50, G50.1, G67, G97),
#: what the cell file gives (G43 H: tool length), or how a machine rounds corners (G5 P, G5.1 Q, G8 P, G9, G61, ...).
SETTINGS = frozenset(
    (
        G.OFFSETS_SET, G.POLAR_INTERPOLATION_OFF, G.POLAR_COORDINATES_OFF, G.SCALING_OFF, G.MIRROR_OFF,
        G.MODAL_MACRO_OFF, G.SPINDLE_IN_TURNS, G.TOOL_LENGTH, G.TOOL_LENGTH_OFF, G.SMOOTHING_LEVEL, G.SMOOTHING,
        G.LOOK_AHEAD, G.EXACT_STOP_HERE, G.EXACT_PATH, G.EXACT_STOP, G.BLENDING, G.ACCURACY,
    )
)  # fmt: skip
#: Of them those that stand without coordinates.
LONE = frozenset((G.SMOOTHING_LEVEL, G.LOOK_AHEAD, G.POLAR_INTERPOLATION_OFF, G.MIRROR_OFF, G.ACCURACY))


def _tenths(words: str) -> tuple[int, ...]:
    return tuple(round(10 * float(word[1:])) for word in words.split())


#: G words that are refused (ten times their number), and why.
REFUSED: dict[int, str] = {
    key: why
    for words, why in (
        (
            "G74 G76 G87 G88",
            "a canned cycle other than G73, G81 to G86, G89; post with expanded cycles",
        ),
        ("G5.2 G5.3", "a spline; post arcs or lines"),
        ("G65 G66 G66.1", "a macro call"),
        ("G68 G51 G51.1 G16 G68.1", "it turns, scales or bends the coordinates; post without it"),
        ("G68.3 G68.4 G53.6", "a tilted work plane of another kind than G68.2 with G53.1; post with that, or APT/CL"),
        ("G43.1 G43.2 G44", "a tool length that this reader does not know; post with G43 H"),
        ("G38.2 G38.3 G38.4 G38.5 G31", "probing"),
        ("G7", "diameter mode of lathes"),
        ("G70", "inch on some controls, a turning cycle on others; write G20 for inch"),
        ("G71", "mm on some controls, a turning cycle on others; write G21 for mm"),
        ("G33 G33.1 G32", "threading"),
        ("G96", "constant surface speed of lathes; post with G97"),
    )
    for key in _tenths(words)
}
