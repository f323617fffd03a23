"""Small TP programs of Fanuc for reader and filter tests, in the form that controllers print."""

from __future__ import annotations

POSE = """P[{n}]{{
   GP1:
	UF : {uf}, UT : {ut},		CONFIG : '{config}',
	X = {x:9.3f}  mm,	Y = {y:9.3f}  mm,	Z = {z:9.3f}  mm,
	W = {w:9.3f} deg,	P = {p:9.3f} deg,	R = {r:9.3f} deg{more}
}};
"""
JOINTS = """P[3:"home"]{
   GP1:
	UF : 1, UT : 2,
	J1=     0.000 deg,	J2=    30.000 deg,	J3=   -20.000 deg,
	J4=    10.000 deg,	J5=   -90.000 deg,	J6=     5.000 deg
};
"""


def pose(n: int, x: float, y: float = 0.0, z: float = 0.0, uf="1", ut="2", w=-180.0, more="") -> str:
    return POSE.format(n=n, uf=uf, ut=ut, config="N U T, 0, 0, 0", x=x, y=y, z=z, w=w, p=0.0, r=30.0, more=more)


def record(n: int, x: float, y: float, z: float = 0.0, name: str = "") -> str:
    """A position that is tilted and has a turn number."""
    text = POSE.format(n=n, uf=1, ut=2, config="N U T, 0, 0, 1", x=x, y=y, z=z, w=-180, p=1.5, r=30.25, more="")
    return text.replace(f"P[{n}]", f'P[{n}:"{name}"]') if name else text


def program(lines: list[str], records: str = "") -> str:
    body = "".join(f"{i:4d}:{line} ;\n" for i, line in enumerate(lines, 1))
    return f'/PROG  TEST\n/ATTR\nCOMMENT = "x";\n/MN\n{body}/POS\n{records}/END\n'


def plain(*lines: str) -> str:
    """A program of these lines with the positions 1, 2 and 4, and joint angles as 3."""
    return program(list(lines), pose(1, 100) + pose(2, 200, 50) + JOINTS + pose(4, 300, 0))


#: A joint move, straight moves, and a position that two of them use.
SOURCE = program(
    [
        "  !face ,mill",
        "J P[1] 20% FINE",
        "L P[1] 20mm/sec CNT10",
        "L P[2:edge] 20mm/sec CNT100",
        "  DO[1]=ON",
        "L P[3] 7cm/min FINE ACC50",
        "L P[2:edge] 20mm/sec CNT100",
        "L P[5] 5mm/sec FINE",
    ],
    "".join(
        [record(1, 100, 0), record(2, 200, 0, name="edge"), record(3, 200, 50), record(4, 0, 0), record(5, 100, 50)]
    ),
)
ARC = program(
    ["L P[1] 20mm/sec FINE", "C P[2]\n    :  P[3:end] 20mm/sec CNT50", "L P[4] 9mm/sec FINE"],
    "".join([record(1, 0, 0), record(2, 10, 10), record(3, 20, 0), record(4, 30, 0)]),
)
