"""Reading 200,000 moves of every language and kind, against finding the file's numbers with one regular expression."""

from __future__ import annotations

import re
import statistics
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from benchmarks.table import Row
from benchmarks.timing import interleaved, ratio
from toolpaths.files import read_toolpath
from toolpaths.machine import Machine, RotaryAxis

MOVES, ROUNDS = 200_000, 1
GOAL = "10 s"
_NUMBER = re.compile(r"-?\d+\.?\d*")
_MACHINE = Machine(
    "head-table", (RotaryAxis("B", (0.0, 1.0, 0.0)), RotaryAxis("C", (0.0, 0.0, 1.0), (0.0, 0.0, 0.0))), 0.2
)
_NC = "G21 G90 G17\nG0 X0 Y0 Z5 {}\nF600\n"
_MPF = "G710 G90 G17\n{}\nG0 X0 Y0 Z5\nF600\n"
_H = "BEGIN PGM A MM\n{}\nL X+0 Y+0 Z+5 R0 FMAX\nL F600\n"
_CLS = "TOOL PATH/A,TOOL,B\nTLDATA/MILL,10,1,75,0,0\nMSYS/0,0,0,1,0,0,0,1,0\nFEDRAT/MMPM,250\nGOTO/0,0,0,0,0,1\n"
_MOD_POSE = "[[{x},{y},-1.25],[0,0.6,0.8,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
_PGX = '<Programs><Program name="m"><Locals><Local name="p" type="pointRx" /></Locals><Code><![CDATA[\nbegin\n'
_LS_POSE = (
    "P[{n}]{{\n   GP1:\n\tUF : 0, UT : 1,\t\tCONFIG : 'N U T, 0, 0, 0',\n"
    "\tX = {x}  mm,\tY = {y}  mm,\tZ = -1.250  mm,\n\tW = 180.000 deg,\tP = 0.500 deg,\tR = -10.000 deg\n}};\n"
)


@dataclass(frozen=True)
class Kind:
    """Equal moves: ``line`` with {n} its number, {x} and {y} a place, {odd} 1 or 0; ``more`` as often behind."""

    suffix: str
    head: str
    line: str
    end: str
    more: str = ""

    def text(self, moves: int) -> str:
        """The file."""
        rows = [_row(n) for n in range(1, moves + 1)]
        end = self.end.split("{more}")
        body = "".join(self.line.format(**row) for row in rows)
        more = "".join(self.more.format(**row) for row in rows)
        return self.head + body + end[0] + (more + end[1] if len(end) > 1 else "")


def _row(n: int) -> dict[str, object]:
    return {"n": n, "odd": n % 2, "x": f"{n % 1000 * 0.1:.4f}", "y": f"{n // 1000 * 0.1:.4f}"}


KINDS = {
    "G-code lines": Kind("nc", _NC.format(""), "N{n} G1 X{x} Y{y} Z-1.25 F900.0\n", "M30\n"),
    "G-code arcs": Kind("nc", _NC.format(""), "G2 X{odd}0 R5\n", "M30\n"),
    "G-code tool vectors": Kind("nc", _NC.format("G43.4 I0 J0 K1"), "G1 X{x} Y{y} I0.{n} J0.1 K0.9\n", "M30\n"),
    "G-code holes": Kind("nc", _NC.format(""), "G98 G83 X{x} Y{y} Z-3 R1 Q2\n", "M30\n"),
    "G-code rotary": Kind("nc", _NC.format("B0 C0"), "G1 X{x} Y{y} B{odd} C{x}\n", "M30\n"),
    "SINUMERIK lines": Kind("mpf", _MPF.format(""), "N{n} G1 X{x} Y{y} Z-1.25 F900.0\n", "M30\n"),
    "SINUMERIK arcs": Kind("mpf", _MPF.format(""), "G2 X{odd}0 CR=5\n", "M30\n"),
    "SINUMERIK tool vectors": Kind(
        "mpf", _MPF.format("TRAORI"), "G1 X{x} Y{y} A3=0.{n} B3=0.1 C3=0.9\n", "M30\n"
    ),
    "Klartext lines": Kind("h", _H.format(""), "{n} L X{x} Y{y} Z-1.25 F900.0\n", "END PGM A MM\n"),
    "Klartext circles": Kind("h", _H.format(""), "CC X+5 Y+0\nC X+{odd}0 Y+0 DR-\n", "END PGM A MM\n"),
    "Klartext tool vectors": Kind(
        "h", _H.format("M128"), "LN X{x} Y{y} Z-1.25 TX+0.{n} TY+0.1 TZ+0.9\n", "END PGM A MM\n"
    ),
    "APT points": Kind("cls", _CLS, "GOTO/{x},{y},-1.25,0.0,0.6,0.8\n", "END-OF-PATH\n"),
    "APT circles": Kind("cls", _CLS, "CIRCLE/5,0,0,0,0,1,5\nGOTO/{odd}0,0,0\n", "END-OF-PATH\n"),
    "CSV": Kind("csv", "x_mm,y_mm,z_mm,i,j,k,feed_mm_min,kind\n", "{x},{y},0,0,0.6,0.8,60,cut\n", ""),
    "RAPID": Kind(
        "mod", "MODULE M\nPROC main()\n", f"MoveL {_MOD_POSE},v10,z1,tool0;\n", "ENDPROC\nENDMODULE\n"
    ),
    "RAPID, declared": Kind(
        "mod", "MODULE M\nPROC main()\n", "MoveL p{n},v10,z1,tool0;\n", "ENDPROC\n{more}ENDMODULE\n",
        f"CONST robtarget p{{n}}:={_MOD_POSE};\n",
    ),
    "KRL": Kind(
        "src", "DEF M()\n$VEL.CP=0.02\n", "LIN {{X {x},Y {y},Z -1.25,A 0,B 0.5,C 180}} C_DIS\n", "END\n"
    ),
    "Fanuc TP": Kind("ls", "/PROG  M\n/MN\n", "{n}:L P[{n}] 20mm/sec CNT5 ;\n", "/POS\n{more}/END\n", _LS_POSE),
    "URScript": Kind(
        "script", "def m():\n", "  movel(p[{x}e-3, {y}e-3, -0.001, 3.14, 0, 0], a=1.2, v=0.02, r=0.0001)\n", "end\n"
    ),
    "INFORM": Kind(
        "jbi", "/JOB\n//NAME M\n//POS\n///TOOL 1\n///POSTYPE ROBOT\n///RECTAN\n",
        "C{n:05d}={x},{y},-1.250,180.0000,0.5000,0.0000\n", "//INST\nNOP\n{more}END\n", "MOVL C{n:05d} V=20.0\n",
    ),
    "VAL3": Kind(
        "pgx", _PGX, "  p.trsf={{{x},{y},-1.25,180,0,0}}\n  movel(p,t,m)\n", "end\n]]></Code></Program></Programs>\n"
    ),
}  # fmt: skip


def run(moves: int = MOVES) -> Iterator[Row]:
    """Seconds of the process for each kind, and how often that is one pass of a regular expression."""
    with tempfile.TemporaryDirectory() as folder:
        for name, kind in KINDS.items():
            file = Path(folder) / f"m.{kind.suffix}"
            text = kind.text(moves)
            file.write_text(text)
            seconds = interleaved({"read": reading(file), "numbers": numbers(text)}, ROUNDS)
            what = f"{name}, {moves:,} moves"
            yield Row("reading", what, statistics.median(seconds["read"]), "s", GOAL)
            yield Row("reading", f"{name}, against its numbers", ratio(seconds["read"], seconds["numbers"]), "x")


def reading(file: Path) -> Callable[[], object]:
    """Reads the file."""
    return lambda: read_toolpath(file, chord=1e-4, machine=_MACHINE if file.suffix == ".nc" else None)


def numbers(text: str) -> Callable[[], object]:
    """Turns every number of a text into a float: what no reader in Python can do without."""
    return lambda: list(map(float, _NUMBER.findall(text)))
