"""Fanuc .ls in the contract suites."""

from __future__ import annotations

from tests.contracts.sample import FilterSample, ReadSample, Sample, WrittenSample
from tests.oracles.tp_programs import ARC, SOURCE, plain, pose, program

#: Line between two moves: words of the refusal, which names this line.
REFUSED = [
    ("L PR[1] 20mm/sec FINE", "not known before"),
    ("L P[R[1]] 20mm/sec FINE", "not known before"),
    ("L P[1] R[2:v]mm/sec FINE", "the speed R[2:v] is not known before"),
    ("L P[1] 20mm/sec CNT R[1]", "not known before"),
    ("L P[1] 20mm/sec CNT101", "CNT101 is above 100"),
    ("L P[1] 20mm/sec FINE Offset,PR[1]", "option 'Offset"),
    ("L P[1] 20mm/sec FINE Tool_Offset,PR[1]", "option"),
    ("L P[1] 20mm/sec FINE Skip,LBL[1]", "option"),
    ("L P[1] 20mm/sec FINE INC", "option"),
    ("L P[1] 20mm/sec FINE Wjnt", "option"),
    ("A P[1] 20mm/sec FINE", "not known before"),
    ("L P[9] 20mm/sec FINE", "P[9] is not in /POS"),
    ("L P[1] 0mm/sec FINE", "not above 0"),
    ("L P[1] P[2] 20mm/sec FINE", "two positions behind C"),
    ("C P[1] 20mm/sec FINE", "two positions behind C"),
    ("C P[3] P[1] 20mm/sec FINE", "joint angles"),
    ("L P[1] 1.2.3mm/sec FINE", "not a number"),
    ("  JMP LBL[1]", "'JMP LBL[1]' is not read"),
    ("  IF R[1]=1,JMP LBL[1]", "an IF decides about 'JMP LBL[1]'"),
    ("  IF (R[1:a,b]=1) THEN", "an IF (line 6) decides about 'L P[2] 20mm/sec FINE'"),
    ("  IF DI[1]=ON,UFRAME_NUM=2", "an IF decides about 'UFRAME_NUM=2'"),
    ("  ENDIF", "'ENDIF' is not read"),
    ("  FOR R[1]=1 TO 5", "is not read"),
    ("  SELECT R[1]=1,CALL A", "is not read"),
    ("  WAIT DI[1]=ON TIMEOUT,LBL[1]", "is not read"),
    ("J P[1] 50% FINE Skip,LBL[1]", "option 'Skip"),
    ("J PR[1] 50% FINE Skip,LBL[1]", "not known before"),
    ("J PR[1:home] 50% FINE", "starts where 'J PR[1:home] 50% FINE' (line 6) leads"),
    ("J P[1] 50% FINE Offset,PR[1]", "starts where 'J P[1] 50% FINE Offset,PR[1]' (line 6) leads"),
    ("L P[1] R[2]mm/sec FINE TB .10sec,CALL A", "the speed R[2] is not known"),
    ("L P[1] 20mm/sec FINE TB .10sec,JMP LBL[1]", "option 'TB"),
    ("  RUN OTHER", "is not read"),
    ("  UFRAME[1]=PR[4]", "PR[4] is not known"),
    ("  $MCR.$GENOVERRIDE=5", "not read"),
    ("  UFRAME_NUM=R[1]", "is not read"),
    ("  UFRAME_NUM=5", "UFRAME_NUM is 5"),
    ("  UTOOL[1]=PR[1]", "PR[1] is not known"),
    ("  PR[1,1]=1.2.3", "not a number"),
]
#: Lines that the next move is refused for.
LATER = {
    "  UFRAME_NUM=5", "  IF (R[1:a,b]=1) THEN", "J PR[1:home] 50% FINE", "J P[1] 50% FINE Offset,PR[1]",
}  # fmt: skip
MISTAKES: list[tuple[str | bytes, str]] = [
    ("", "empty"),
    (b"\x00\x01", "binary"),
    ("G0 X1\nG1 Y2 F100\n", "no /PROG: not a Fanuc program"),
    (plain("L P[1] 5mm/sec FINE").replace("/END\n", ""), "no /END"),
    ("<<<<<<< a\n/PROG\n", "merge-conflict"),
    (plain("L P[1] 5mm/sec FINE") * 2, "two programs in one file"),
    (plain("  UFRAME_NUM=1"), "no move"),
    (plain("L P[1] 5mm/sec FINE").replace("CONFIG : 'N", "CONFIG : 'X"), "CONFIG 'X U T'"),
    (plain("L P[1] 5mm/sec FINE").replace("  100.000", "********"), "never taught"),
    (plain("L P[1] 5mm/sec FINE") + pose(5, 1), "text behind /END"),
    (program(["L P[1] 5mm/sec FINE"], pose(1, 2) * 2), "P[1] stands twice"),
    (program(["L P[1] 5mm/sec FINE"], pose(1, 2) + "what is this\n"), "'what is this' is no position"),
    (
        program(["L P[1] 5mm/sec FINE", "L P[2] 5mm/sec FINE"], pose(1, 2) + pose(2, 1, uf="3", ut="F")),
        "UFRAME_NUM is 1",
    ),
    (program(["L P[1] 5mm/sec FINE"], pose(1, 2e6)), "beyond 1000 m"),
    (program(["L P[1] 5mm/sec FINE"]).replace(" ;", ""), "without ';'"),
    (
        plain("  UFRAME_NUM=1", "L P[1] 5mm/sec FINE", "  UFRAME_NUM=6", "J P[5] 5% FINE").replace(
            "/END", pose(5, 3, uf="6") + "/END"
        ),
        "frames 1 and 6 are not in the file",
    ),
    (program(["L P[1] 5mm/sec FINE"], "P[1]{\n" * 100_000), "is no position"),
    (program(["  PR[9,1]=" + " " * 200_000 + "x"]), "no move"),
    (program(["L P[1]" + " " * 200_000 + "5mm/sec ACC5" + " " * 200_000 + "x"]), "not known before"),
    (program(["  !compensated by" + " " * 200_000 + "x"]), "no move"),
]

RECORD = """P[{n}]{{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = {x}.000  mm,	Y = {y}.000  mm,	Z = {z}.000  mm,
	W = 180.000 deg,	P = 0.000 deg,	R = 0.000 deg
}};
"""
PLACES = [(5, 0, 0, 5), (2, 10, 0, 0), (3, 10, -4, 0), (15, 10, -4, 5)]

SAMPLE = Sample(
    read=ReadSample(
        text="/PROG  PART\n/ATTR\n/MN\n   1:J P[5] 20% FINE ;\n   2:L P[2] 10mm/sec FINE ;\n"
        "   3:L P[3] 10mm/sec CNT100 ;\n   4:L P[15] max_speed FINE ;\n/POS\n"
        + "".join(RECORD.format(n=n, x=x, y=y, z=z) for n, x, y, z in PLACES)
        + "/END\n",
        pieces="/PROG /MN /POS /END 1: L P[1] 20mm/sec FINE ; J P[2] CNT100 P[1]{ GP1: UF : 0, UT : 1, P[3] 5% C P[4] "
        "CONFIG : 'N U T, 0, 0, 0', X = 1.0 mm, }; UFRAME_NUM=1 PR[9,1]=(-1.0) UTOOL[2]=PR[9] 7cm/min - ********",
        whole=plain("J P[3] 5% FINE", "J P[4] 5% FINE", "C P[1]  P[2] 7cm/min CNT5", "L P[4] 5mm/sec FINE"),
        refused=tuple(
            (plain("L P[1] 20mm/sec FINE", line, "L P[2] 20mm/sec FINE"), 7 if line in LATER else 6, words)
            for line, words in REFUSED
        ),
        mistakes=tuple(MISTAKES),
    ),
    written=WrittenSample(
        feed=3e-5,
        rapid_speed=True,
        frame=2e-7,
        stands_or_passes=True,
        most_lines=36000,
        no_names=("1110_wall", "a-b", "a" * 31, "größe", "a b", "_a"),
        no_name="is no TP program name",
        longest=(30, 26),
        fastest="2000 mm/sec",
    ),
    filtered=FilterSample(
        source=SOURCE,
        marker=(5, ("    :  !compensated by ;", "    :  !toolpath-compensator ;")),
        # P[3], P[5]: two lines each; P[1] (of a joint move, too) and P[2] (used twice) are split: three name others
        lines=(7, 27),
        told=("a position that other moves use",),
        rotation=3e-7,
        arc=(ARC, "C P"),
        arc_told=("an arc became straight lines",),
        by_time=tuple(
            (
                SOURCE.replace("7cm/min FINE", f"{time} FINE"),
                3,
                "part.ls:10: a move by time cannot be divided",
                f" {time} FINE",
            )
            for time in ("1.5sec", "800msec", "3 sec")
        ),
        real={},
        lines_of_a_pose=2,
        elsewhere=("robodk/Program.LS", "Program.LS:53: CALL Subprog: Subprog.ls is not beside"),
    ),
    examples=4,
)
