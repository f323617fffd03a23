"""Programs of several files: a main one and one per operation, as Fusion 360's posts for KRL and RAPID write them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import toolpaths.interpreting.interpreter as interpreter
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.toolpath import CUT, RAPID, Toolpath

KRL_MAIN = """&ACCESS RVO
DEF JOB()
;FOLD INI
    GLOBAL INTERRUPT DECL 3 WHEN $STOPMESS==TRUE DO IR_STOPM ( )
    INTERRUPT ON 3
    BAS (#INITMOV,0 )
;ENDFOLD (INI)
$VEL_AXIS[1] = 25
$IPO_MODE = #BASE
$APO.CDIS = 2
$ADVANCE = 3
$BASE = {X 1500,Y -150,Z 800,A 0,B 0,C 0}

; Load Tool
;TOOL_CHANGE(3)
BAS(#TOOL,3)
$TOOL = TOOL_DATA[3]

sFace()
sPocket()

END
"""
KRL_MAIN_DAT = """&ACCESS RVO
DEFDAT JOB
    EXT  BAS (BAS_COMMAND  :IN,REAL  :IN )
  EXT sFace()
  EXT sPocket()
ENDDAT
"""
FACE = """&ACCESS RVO
DEF sFace()
;FOLD sFace
PTP {A1 5,A2 -80,A3 100,A4 75,A5 -60,A6 -65,E1 0,E2 0,E3 0,E4 0,E5 0,E6 0}
$VEL.CP=0.02
LIN {X 0.000,Y 0.000,Z 5.000,A 0.000,B 0.000,C 180.000} C_DIS
LIN XP1 C_DIS
;ENDFOLD
END
"""
POCKET = """&ACCESS RVO
DEF sPocket()
PTP {X 0.000,Y 40.000,Z 5.000,A 0.000,B 0.000,C 180.000,E1 0,E2 0,E3 0,E4 0,E5 0,E6 0,S'B110',T'B110010'}
LIN XP1 C_DIS
END
"""


def dat(name: str, point: str) -> str:
    return f"&ACCESS RVO\nDEFDAT {name}\nDECL E6POS XP1={point}\nENDDAT\n"


POINT = "{{X {},Y {},Z -2,A 0,B 0,C 180}}"
KRL_FILES = {
    "JOB.src": KRL_MAIN, "JOB.dat": KRL_MAIN_DAT, "sFace.src": FACE, "sFace.dat": dat("sFace", POINT.format(100, 0)),
    "sPocket.src": POCKET, "sPocket.dat": dat("sPocket", POINT.format(30, 40)),
}  # fmt: skip

TARGET = "[[{},{},{}],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
HEAD = "%%%\n  VERSION:1\n  LANGUAGE:ENGLISH\n%%%\n\n"
MAIN = f"""{HEAD}MODULE mAUTODESK

  PERS speeddata v18:=[18,500,5000,1000];

  PROC main()
    ! Acceleration and jerk/ramp (percentage)
    AccSet 20,20;
    ConfL\\Off;
    MoveJ pHome,v1000,fine,tADSK3\\WObj:=wADSK1;
    pFace;
    pPocket;
    MoveAbsJ jHome,v1000,fine,tADSK3;
    Stop;
  ENDPROC
ENDMODULE
"""


def operation(name: str, target: str, first: str, last: str) -> str:
    tail = "z1,tADSK3\\WObj:=wADSK1;\n"
    moves = f"    MoveJ {first},v1000,{tail}    MoveL p1,v18,{tail}    MoveL {last},v18,{tail}"
    own = f"  LOCAL CONST robtarget p1:={target};\n"
    return f"{HEAD}MODULE m{name}\n{own}  PROC p{name}()\n{moves}  ENDPROC\nENDMODULE\n"


RAPID_FILES = {
    "mAutodesk.mod": MAIN,
    "mFace.mod": operation("Face", *(TARGET.format(*p) for p in ((0, 0, -2), (0, 0, 50), (90, 0, -2)))),
    "mPocket.mod": operation("Pocket", *(TARGET.format(*p) for p in ((0, 40, -2), (0, 40, 50), (30, 40, -2)))),
    "Cell.sys": f"""MODULE Cell(SYSMODULE)
  PERS tooldata tADSK3:=[TRUE,[[30,-20,240],[1,0,0,0]],[30,[10,0,110],[1,0,0,0],0,0,0]];
  PERS wobjdata wADSK1:=[FALSE,TRUE,"",[[1500,-150,800],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
  CONST robtarget pHome:={TARGET.format(0, 0, 300)};
  CONST jointtarget jHome:=[[0,10,20,0,60,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
ENDMODULE
""",
    "JOB.pgf": '<?xml version="1.0" encoding="ISO-8859-1"?>\n<Program>\n  <Module>mAutodesk.mod</Module>\n'
    "  <Module>mFace.mod</Module>\n  <Module>mPocket.mod</Module>\n  <Module>Cell.sys</Module>\n</Program>\n",
}


def put(folder: Path, files: dict[str, str]) -> Path:
    folder.mkdir(exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text)
    return folder


def ends(path: Toolpath) -> list[tuple[float, ...]]:
    return [tuple(p) for p in (path.position * 1e3).round(6).tolist()]


def named(folder: Path, files: dict[str, str], suffix: str) -> list[Path]:
    return [folder / name for name in files if name.endswith(suffix)]


@pytest.mark.parametrize("way", ["main", "folder", "files"])
def test_krl(tmp_path: Path, way: str) -> None:
    """Each operation has its own XP1; lines and files are those that the moves stand in."""
    put(tmp_path, KRL_FILES)
    every = named(tmp_path, KRL_FILES, ".src")[::-1]
    given = {"main": [tmp_path / "JOB.src"], "folder": [tmp_path], "files": every}[way]
    path = read_toolpath(given[0], others=given[1:] or None)
    assert ends(path)[1:] == [(0, 0, 5), (100, 0, -2), (0, 40, 5), (30, 40, -2)]
    np.testing.assert_allclose(path.setting.joints[0], np.radians([5, -80, 100, 75, -60, -65]))
    assert path.kind.tolist() == [RAPID, CUT, CUT, RAPID, CUT] and path.tool.tolist() == [3] * 5
    np.testing.assert_allclose(path.feed[[1, 2, 4]], 0.02)  # set in the first operation, in force in the second
    where = [path.where(k).removeprefix(f"{tmp_path}/") for k in range(len(path))]
    assert where == ["sFace.src:4", "sFace.src:6", "sFace.src:7", "sPocket.src:3", "sPocket.src:4"]
    assert [Path(s).name for s in path.sources] == ["JOB.src", "sFace.src", "sPocket.src"]
    assert path.setting.configuration.tolist()[3] == 0b001  # S 'B110' is S 6


@pytest.mark.parametrize("way", ["main", "folder", "files", "list"])
def test_rapid(tmp_path: Path, way: str) -> None:
    """Tools, frames and homes stand in another module; each operation has a LOCAL p1 of its own."""
    put(tmp_path, RAPID_FILES)
    if way != "list":
        (tmp_path / "JOB.pgf").unlink()
    every = [*named(tmp_path, RAPID_FILES, ".sys"), *named(tmp_path, RAPID_FILES, ".mod")]
    ways = {"main": [tmp_path / "mAutodesk.mod"], "folder": [tmp_path], "list": [tmp_path / "JOB.pgf"]}
    given = ways.get(way, every)
    path = read_toolpath(given[0], others=given[1:] or None)
    cuts = [(0, 0, -2), (90, 0, -2)], [(0, 40, -2), (30, 40, -2)]
    assert ends(path)[:-1] == [(0, 0, 300), (0, 0, 50), *cuts[0], (0, 40, 50), *cuts[1]]
    np.testing.assert_allclose(path.setting.joints[7], np.radians([0, 10, 20, 0, 60, 0]))
    np.testing.assert_allclose(path.setting.workobject.origin, [1.5, -0.15, 0.8])
    tools = path.setting.tools
    assert len(tools) == 1 and tools[1].mass == 30.0  # one tool in all modules
    np.testing.assert_allclose(path.feed[path.kind == CUT], 0.018)
    assert path.where(2).endswith("mFace.mod:10") and path.where(6).endswith("mPocket.mod:11")


def test_what_is_in_no_file_passes_where_it_does_not_cut(tmp_path: Path) -> None:
    put(tmp_path, {name: text for name, text in RAPID_FILES.items() if name != "Cell.sys"})
    path = read_toolpath(tmp_path / "mAutodesk.mod")
    assert len(path) == 6 and path.setting.joints == {} and path.setting.workobject is None
    told = {e.word: Path(path.sources[e.file]).name for e in path.events if "Home" in e.word}
    assert told == {"MoveJ pHome": "mAutodesk.mod", "MoveAbsJ jHome": "mAutodesk.mod"}
    cut = RAPID_FILES["mPocket.mod"].replace("MoveL p1", "MoveL pSafe")
    (tmp_path / "mPocket.mod").write_text(cut)
    with pytest.raises(ReadError, match=r"mPocket\.mod:10: MoveL: known only at run time: pSafe, which is"):
        read_toolpath(tmp_path / "mAutodesk.mod")


def test_a_cut_from_where_only_the_controller_knows_is_refused(tmp_path: Path) -> None:
    """The way to its end is not known: nothing may be put into it."""
    lost = RAPID_FILES["mPocket.mod"].replace(f"MoveJ {TARGET.format(0, 40, 50)}", "MoveJ pElsewhere")
    put(tmp_path, RAPID_FILES | {"mPocket.mod": lost})
    with pytest.raises(ReadError, match=r"mPocket\.mod:10: MoveL: where this cut begins is not known.*pElsewhere"):
        read_toolpath(tmp_path / "mAutodesk.mod")
    (tmp_path / "K.src").write_text(POCKET.replace("sPocket", "K").replace("LIN XP1", "LIN XP1\nPTP XH\nLIN XP1"))
    (tmp_path / "K.dat").write_text(dat("K", POINT.format(1, 2)))
    with pytest.raises(ReadError, match=r"K\.src:6: this move starts where PTP XH \(line 5\) leads, .*in a file"):
        read_toolpath(tmp_path / "K.src")


def test_names_that_could_mean_two_things_are_refused(tmp_path: Path) -> None:
    put(tmp_path, RAPID_FILES)
    (tmp_path / "JOB.pgf").unlink()
    (tmp_path / "old.mod").write_text(RAPID_FILES["Cell.sys"].replace("Cell(SYSMODULE)", "Old"))
    with pytest.raises(ReadError, match=r"phome is declared in several files: Cell\.sys, old\.mod.*Name the files"):
        read_toolpath(tmp_path / "mAutodesk.mod")
    every = [tmp_path / name for name in RAPID_FILES if name != "JOB.pgf"]
    assert len(read_toolpath(every[0], others=every[1:])) == 8
    other = RAPID_FILES["mAutodesk.mod"].replace("mAUTODESK", "mOther")  # another program in the folder
    (tmp_path / "old.mod").write_text(other)
    assert len(read_toolpath(tmp_path / "mAutodesk.mod")) == 8
    with pytest.raises(ReadError, match=r"several files have PROC main\(\): mAutodesk\.mod, old\.mod"):
        read_toolpath(tmp_path)


@pytest.mark.parametrize(
    ("files", "words"),
    [
        (["JOB.src", "sFace.src", "lone.src"], r"no file calls these: JOB\.src, lone\.src"),
        (["JOB.src", "part.nc"], r"part\.nc: gcode beside krl"),
        (["part.nc", "more.nc"], r"more\.nc: 2 files, and programs in gcode are one file"),
        (["JOB.src", "."], "a folder among files"),
        (["JOB.pgf"], r"JOB\.pgf:3: mAutodesk\.mod is not beside this list"),
    ],
)  # fmt: skip
def test_files_that_are_no_program(tmp_path: Path, files: list[str], words: str) -> None:
    put(tmp_path, KRL_FILES | {"lone.src": FACE, "part.nc": "G0 X0 Y0 Z0\n", "more.nc": "G0 X0\n"})
    put(tmp_path, {"JOB.pgf": RAPID_FILES["JOB.pgf"]})
    with pytest.raises(ReadError, match=words):
        read_toolpath(tmp_path / files[0], others=[tmp_path / name for name in files[1:]] or None)


def test_a_file_that_is_called_and_refused_is_named(tmp_path: Path) -> None:
    put(tmp_path, KRL_FILES | {"sPocket.src": POCKET.replace("LIN XP1 C_DIS", "LOOP\nENDLOOP")})
    with pytest.raises(ReadError, match=r"sPocket\.src:4: LOOP") as caught:
        read_toolpath(tmp_path / "JOB.src")
    assert caught.value.line == 4
    put(tmp_path, {"sPocket.src": POCKET.replace("DEF sPocket", "DEF sOther")})
    with pytest.raises(ReadError, match=r"sPocket\.src:2: SPOCKET\(\) is called, and this file begins with DEF SOTHER"):
        read_toolpath(tmp_path / "JOB.src")


@pytest.mark.parametrize("moves", [40, 4000])
def test_what_is_called_may_be_long(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moves: int) -> None:
    """How much a program may run follows from all of its files, not from its main one alone."""
    monkeypatch.setattr(interpreter, "_LEAST_STEPS", 0)
    more = "".join(LINE.format(k) for k in range(moves))
    main = FEW.format("".join(LINE.format(k) for k in range(2)) + "part_run;\n")
    called = f"MODULE part_001\nPROC part_run()\n{more}ENDPROC\nENDMODULE\n"
    path = read_toolpath(put(tmp_path, {"part.mod": main, "part_001.mod": called}))
    assert len(path) == 2 + moves


LINE = "MoveL [[{},0,5],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\n"
FEW = "MODULE part\nPROC main()\n{}ENDPROC\nENDMODULE\n"
