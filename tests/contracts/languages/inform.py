"""INFORM in the contract suites."""

from __future__ import annotations

from tests.contracts.sample import ReadSample, Sample, WrittenSample

RCONF = "1" + ",0" * 23
DOWN = "180.0000,0.0000,0.0000"
PLACES = ((0, 0, 50), (12.5, -3, 0), (40, -3, 0), (40, 17, 0), (60, 17, 4))


def job(*lines: str, places: tuple[tuple[float, float, float], ...] = PLACES, kind: str = "ROBOT") -> str:
    """A job with these positions, tool down; instructions begin in line ``len(places) + 15``."""
    rows = "".join(f"C{k:05d}={x:.3f},{y:.3f},{z:.3f},{DOWN}\n" for k, (x, y, z) in enumerate(places))
    head = f"/JOB\n//NAME PART\n//POS\n///NPOS {len(places)},0,0,0,0,0\n///TOOL 2\n///POSTYPE {kind}\n///RECTAN\n"
    middle = "//INST\n///DATE 2026/11/29 03:00\n///ATTR SC,RW,RJ\n////FRAME ROBOT\n///GROUP1 RB1\nNOP\n"
    return f"{head}///RCONF {RCONF}\n{rows}{middle}" + "".join(f"{line}\n" for line in lines) + "END\n"


GO, CUT = "MOVJ C00000 VJ=25.00", "MOVL C00001 V=10.0"
FIRST = len(PLACES) + 15
#: Line behind a rapid and a cut: words of the refusal, which names this line.
REFUSED = [
    ("MOVS C00002 V=10.0", "known only while the job runs"),
    ("IMOV P001 V=10.0", "known only while the job runs"),
    ("JUMP *BACK IF IN#(1)=ON", "known only while the job runs"),
    ("IFTHENEXP I000=1", "known only while the job runs"),
    ("SFTON P010", "known only while the job runs"),
    ("FOO 1", "this reader does not know it"),
    ("MOVL P001 V=10.0", "P001 is a position variable"),
    ("MOVL C00077 V=10.0", "C00077 is not in the job"),
    ("MOVL C00002 V=I012", "'V=I012' is not read"),
    ("MOVL C00002 V=0.0", "a speed of 0.0"),
    ("MOVL C00002 V=4500", "a speed of 4500. V takes 0.1 to 1500 mm/s; where the controller counts cm/min"),
    ("MOVL C00002 V=10.0 UNTIL IN#(1)=ON", "'UNTIL' is not read"),
    ("MOVL C00002 BC00002 V=10.0", "BC00002: an external axis"),
    ("MOVL V=10.0", "is not read"),
    ("CALL JOB:DRILL IF IN#(1)=ON", "a condition or an argument"),
    ("SPEED V=I000", "a speed that is no number"),
]  # fmt: skip
ARC = ("MOVC C00002 V=10.0", "MOVC C00003 V=10.0", "MOVC C00004 V=10.0")
R = 900_000
FAR = ((0, 0, 50), (R, 0, 0), (0, R, 0), (-R, 0, 0), (0, -R, 0), (R, 0, 0))
CIRCLE = tuple(f"MOVC C{k:05d} V=9.0" + (" FPT" if k == 3 else "") for k in range(1, 6))
WHOLE = job(
    "'A comment", GO, "DOUT OT#(5) ON", CUT, *ARC, "MOVL C00004 V=7.5 PL=0 CR=2.0", "SPEED V=5.0", "MOVL C00001",
    "CALL JOB:GRIP", "TIMER T=0.50", "PAUSE", GO,
)  # fmt: skip

#: Printed are 0.001 mm, 0.0001 deg and 0.1 mm/s, in the robot's frame.
SAMPLE = Sample(
    read=ReadSample(
        text=job(
            "MOVJ C00000 VJ=5.00", "MOVL C00001 V=10.0", "MOVL C00002 V=10.0", "MOVJ C00003 VJ=5.00 PL=0",
            places=((0, 0, 5), (10, 0, 0), (10, -4, 0), (10, -4, 5)),
        ),
        pieces="/JOB //POS //INST NOP END MOVL MOVJ MOVC C00001 C00002 V=10.0 PL=0 FPT C00003=1,2,3,4,5,6 CALL JOB:A ' "
        "///RCONF ///POSTYPE PULSE USER SPEED BC00001 ///TOOL 1 CR=2.0 1,2, -",
        whole=WHOLE,
        refused=(
            *((job(GO, CUT, line, "MOVL C00003 V=10.0"), FIRST + 2, words) for line, words in REFUSED),
            (job(GO, "MOVJ P001 VJ=25.00", CUT), FIRST + 2, "starts where 'MOVJ P001 VJ=25.00' (line 21) leads"),
            (job(GO, CUT, *ARC[:2], "MOVL C00004 V=9.0"), FIRST + 3, "2 MOVC that make no arc"),
            (job(GO, CUT, *ARC, "MOVC C00001 V=9.0"), FIRST + 5, "1 MOVC that make no arc"),
            (job(GO, CUT, kind="MASTER"), 6, "positions of type 'MASTER'"),
            (job(GO, CUT).replace("NPOS 5", "NPOS 7"), 4, "///NPOS says 7 positions, the job has 5"),
            (job(GO, CUT).replace("C00002", "C00001"), 11, "C00001 stands twice"),
            (job(GO, CUT).replace(f"-3.000,0.000,{DOWN}", "-3.000,0.000", 1), 10, "C00001 has 3 numbers"),
            (job(GO, CUT).replace("12.500", "2e9"), 10, "is not read in the head of a job"),
            (job(GO, CUT).replace("12.500", "2000000000"), 10, "too large"),
        ),
        mistakes=(
            ("G21\nG0 X1\n", "not an INFORM job"),
            ("\x1a\n", "not an INFORM job"),
            (job(), "no move"),
            (job(GO, CUT).replace("\nNOP", "").replace("\nEND", ""), "is not read in the head"),
            (job(GO, CUT) + "G1 X1\n", "text behind END"),
        ),
        spelled=(
            (job(f"{GO} PL=0 ACC=50 DEC=50", "MOVL C00001 BC00001 V=10.0 NWAIT").replace(
                "//INST", "///PULSE\nBC00001=0\n//INST"), (12.5, -3.0, 0.0)),
            (job("MOVJ P001 VJ=5.00", CUT, "MOVL C00002", kind="BASE"), (40.0, -3.0, 0.0)),
            (job(GO, CUT, kind="USER").replace("///POS", "///USER 3\n///POS"), (12.5, -3.0, 0.0)),
        ),
        huge=(job("MOVJ C00000 VJ=5.00", *CIRCLE, places=FAR), 1e-9),
    ),
    written=WrittenSample(
        position=0.88e-6,
        rotation=1.7e-6,
        feed=0.03,
        in_base=True,
        rapid_speed=True,
        stands_or_passes=True,
        most_lines=16000,
        no_names=("a.b", "a" * 33, "größe", "a b", "_a", "a+b"),
        no_name="is no INFORM name",
        longest=(32, 28),
    ),
    examples=2,
)
