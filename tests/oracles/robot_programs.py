"""Small robot programs for reader and filter tests, written by hand from the vendors' manuals."""

from __future__ import annotations

_AXES = "[9E9,9E9,9E9,9E9,9E9,9E9]"


def target(x: float, y: float, z: float) -> str:
    """A robtarget with the tool down."""
    return f"[[{x},{y},{z}],[0,1,0,0],[0,0,0,0],{_AXES}]"


def module(body: str, data: str = "", rest: str = "") -> str:
    """A RAPID module: declarations, what main() does, other routines."""
    return f"MODULE M\n{data}PROC main()\n{body}\nENDPROC\n{rest}ENDMODULE\n"


def source(body: str, rest: str = "") -> str:
    """A KRL program, and other routines of its file."""
    return f"DEF PART()\n{body}\nEND\n{rest}"


def script(*lines: str, before: str = "") -> str:
    """A URScript program of one function, which is called; ``before`` stands in front of it."""
    return f"{before}def part():\n" + "".join(f"  {line}\n" for line in lines) + "end\npart()\n"


# tool and work object are those of tests/compensator/small_job.py
HALF = "0.976296007119933,0,0.216439613938103,0"  # 25 deg about y
TURN = "0.984807753012208,0,0,0.173648177666930"  # 20 deg about z
TOOL = f"[TRUE,[[30,-20,240],[{HALF}]],[30,[10,0,110],[1,0,0,0],0,0,0]]"
WORK = f'[FALSE,TRUE,"",[[1500,-150,800],[{TURN}]],[[0,0,0],[1,0,0,0]]]'
TAIL = "spindle\\WObj:=table;"
RAPID = f"""%%%
  VERSION:1
  LANGUAGE:ENGLISH
%%%
MODULE PART
  PERS tooldata spindle:={TOOL};
  PERS wobjdata table:={WORK};
  CONST robtarget p10:={target(100, 60, -2)}; ! corner
  LOCAL CONST robtarget safe := {target(0, 0, 80)};
  ! mill the L
  PROC main()
    MoveJ safe,v1000,z10,{TAIL}
    MoveL {target(0, 0, -2)},v100,fine,{TAIL} ! plunge
    MoveL {target("100.00", 0, -2)},v20,z1,{TAIL}
    MoveL p10,v20,z1,{TAIL}
    MoveC {target(120, 40, -2)},{target(100, 20, -2)},v20,z1,{TAIL}
    MoveL Offs(p10,0,0,82),v1000,z10,{TAIL}
    MoveJ safe,v1000,z10,{TAIL}
    cut2;
  ENDPROC
  PROC cut2()
    MoveL {target(0, 30, -2)},v100,fine,{TAIL}
    MoveL p10, v20\\V:=30,
      z1\\Z:=2, spindle\\WObj:=table;
  ENDPROC
ENDMODULE
"""
#: End points of RAPID, mm, and whether they cut.
RAPID_ENDS = [
    (0, 0, 80, 0), (0, 0, -2, 1), (100, 0, -2, 1), (100, 60, -2, 1), (100, 20, -2, 1), (100, 60, 80, 1), (0, 0, 80, 0),
    (0, 30, -2, 1), (100, 60, -2, 1),
]  # fmt: skip
RAPID_LINES = [12, 13, 14, 15, 16, 17, 18, 22, 23]

_E = "S 2,T 35,E1 0.0,E2 0.0,E3 0.0,E4 0.0,E5 0.0,E6 0.0"
KRL_DAT = f"""DEFDAT PART
DECL E6POS XP1={{X 0,Y 0,Z -2,A 0.0,B 0.0,C 180.0,{_E}}} ; first
DECL E6POS XP2={{X 100.000,Y 0.000,Z -2.000,A 0.0,B 0.0,C 180.0,{_E}}}
DECL FDAT FP1={{TOOL_NO 3,BASE_NO 4,IPO_FRAME #BASE}}
DECL LDAT LCPDAT1={{VEL 2.0,ACC 100.0,APO_DIST 100.0}}
ENDDAT
"""
KRL = """&ACCESS RVP
&REL 1
DEF PART( )
;FOLD INI
BAS (#INITMOV,0)
;ENDFOLD (INI)
TOOL_DATA[3]={X 30,Y -20,Z 240,A 0,B 25,C 0}
BASE_DATA[4]={FRAME: X 1500,Y -150,Z 800,A 20,B 0,C 0}
PTP HOME
;FOLD LIN P1 CONT Vel=0.2 m/s CPDAT1 Tool[3]:Spindle Base[4]:Part;%{PE}%R 8.3.24
$BWDSTART=FALSE
LDAT_ACT=LCPDAT1
FDAT_ACT=FP1
BAS(#CP_PARAMS,0.2)
LIN XP1 C_DIS
;ENDFOLD
LIN XP2 C_DIS
LIN {X 100.00,Y 60.00,Z -2.00,A 0.0,B 0.0,C 180.0} C_DIS ; corner
CIRC {X 120,Y 40,Z -2,A 0,B 0,C 180},{X 100,Y 20,Z -2,A 0,B 0,C 180} C_DIS
LIN XP1:{X 0,Y 0,Z -40,A 0,B 0,C 0}
LIN_REL {Z 20}
PTP XP2
LIN XP1
PTP HOME
END
"""
KRL_ENDS = [
    (0, 0, -2, 1), (100, 0, -2, 1), (100, 60, -2, 1), (100, 20, -2, 1), (0, 0, 38, 1), (0, 0, 58, 1), (100, 0, -2, 0),
    (0, 0, -2, 1),
]  # fmt: skip
KRL_LINES = [15, 17, 18, 19, 20, 21, 22, 23]
