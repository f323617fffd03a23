"""One suite over all readers of toolpath files: shapes, mistakes, and that only clear refusals escape."""

from __future__ import annotations

import re
import subprocess
import sys
import tracemalloc
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from toolpaths.errors import ReadError, ToolpathError
from toolpaths.files import read_toolpath
from toolpaths.languages.table import READ

SUFFIXES = {language.name: language.reads for language in READ}
READERS = {suffix: name for name, group in SUFFIXES.items() for suffix in group}

SAMPLES = {  # the same four poses in every language; the cuts are those at Z 0, at 600 mm/min
    "gcode": "G21 G90\nG0 X0 Y0 Z5\nG1 X10 Z0 F600\nY-4\nG0 Z5\nM30\n",
    "apt": "UNITS/MM\nRAPID\nGOTO/0,0,5\nFEDRAT/600,MMPM\nGOTO/10,0,0\nGOTO/10,-4,0\nRAPID\n"
    "GOTO/10,-4,5\nFINI\n",
    "csv": "x_mm,y_mm,z_mm,i,j,k,feed_mm_min,kind\n0,0,5,0,0,1,0,rapid\n10,0,0,0,0,1,600,cut\n"
    "10,-4,0,0,0,1,600,cut\n10,-4,5,0,0,1,0,rapid\n",
    "rapid": "MODULE M\nPROC main()\n"
    + "".join(
        f"{word} [[{xyz}],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]], {speed}, fine, tool0;\n"
        for word, xyz, speed in [
            ("MoveJ", "0,0,5", "v100"), ("MoveL", "10,0,0", "v10"), ("MoveL", "10,-4,0", "v10"),
            ("MoveJ", "10,-4,5", "v100"),
        ]
    )
    + "ENDPROC\nENDMODULE\n",
    "krl": "DEF PART()\n$VEL.CP=0.01\nPTP {X 0,Y 0,Z 5,A 0,B 0,C 180}\nLIN {X 10,Y 0,Z 0,A 0,B 0,C 180}\n"
    "LIN {X 10,Y -4,Z 0,A 0,B 0,C 180}\nPTP {X 10,Y -4,Z 5,A 0,B 0,C 180}\nEND\n",
    "fanuc": "/PROG  PART\n/ATTR\n/MN\n   1:J P[5] 20% FINE ;\n   2:L P[2] 10mm/sec FINE ;\n"
    "   3:L P[3] 10mm/sec CNT100 ;\n   4:L P[15] max_speed FINE ;\n/POS\n"
    + "".join(
        f"P[{n}]{{\n   GP1:\n\tUF : 0, UT : 1,\t\tCONFIG : 'N U T, 0, 0, 0',\n"
        f"\tX = {x}.000  mm,\tY = {y}.000  mm,\tZ = {z}.000  mm,\n"
        "\tW = 180.000 deg,\tP = 0.000 deg,\tR = 0.000 deg\n};\n"
        for n, x, y, z in [(5, 0, 0, 5), (2, 10, 0, 0), (3, 10, -4, 0), (15, 10, -4, 5)]
    )
    + "/END\n",
    "urscript": "def part():\n  v_rapid = 1\n  w = 3.141592653589793\n  movej(p[0, 0, 0.005, w, 0, 0])\n"
    "  movel(p[0.01, 0, 0, w, 0, 0], v=0.01)\n  movel(p[0.01, -0.004, 0, w, 0, 0], v=0.01)\n"
    "  movel(p[0.01, -0.004, 0.005, w, 0, 0], v=v_rapid)\nend\n",
}
EVERY = [(name, suffix) for name, group in SUFFIXES.items() for suffix in group]
PIECES = {
    "gcode": "G0 G1 G2 G3 G17 G18 G20 G21 G90 G91 G28 G53 X1 Y-2.5 Z I3 J0 K1 R9 F100 T1 M6 M30 % ( ) ; #1 E1"
    " O1 N5 H1 P2",
    "apt": "GOTO/ 1,2,3 ,0,0,1 CIRCLE/0,0,0,0,0,1,1,1,1,1,1 FEDRAT/ MMPM , 5 RAPID $ $$"
    " MSYS/0,0,0,1,0,0,0,1,0 UNITS/MM FINI TOOL END-OF-PATH LOAD/TOOL, 1E999 nan SPINDL/",
    "csv": 'x_mm,y_mm,z_mm,i,j,k ,kind ,feed_mm_min 1,2,3,0,0,1 , cut " nan 1e999 qw',
    "rapid": "MODULE M PROC main() MoveL MoveJ MoveC MoveAbsJ [[1,2,3],[0,1,0,0],[0,0,0,0],[9E9]] , v10 fine tool0 ; "
    "CONST robtarget a := Offs( RelTool( ) \\WObj:= 1e999 IF TRUE THEN ENDIF FOR i FROM 1 TO 9 DO ENDFOR ENDPROC "
    "ENDMODULE ! %%% a(1,2) * - / PERS tooldata",
    "krl": "DEF PART() LIN PTP CIRC {X 1,Y 2,Z 3,A 0,B 0,C 180} , C_DIS $VEL.CP= $TOOL= $BASE=$NULLFRAME E6POS P : "
    "( ) 1.0E999 ; &ACCESS IF TRUE THEN ENDIF FOR I=1 TO 9 ENDFOR LIN_REL {Z 5} END ;FOLD DECL REAL R[3]",
    "fanuc": "/PROG /MN 1: L P[1] 20mm/sec FINE ; J P[2] CNT100 /POS P[1]{ GP1: UF : 0, UT : 1, "
    "CONFIG : 'N U T, 0, 0, 0', X = 1.0 mm, }; /END UFRAME_NUM=1 PR[9,1]=(-1.0) ********",
    "urscript": "def a(): end movel( p[0,0,0,0,0,1] , v=0.1 ) movec( set_tcp( pose_trans( while x: if 1: "
    "v = 2 * ( # 1e999 a()",
}
FRAGMENTS = {name: [*text.split(), "\n", "9" * 400] for name, text in PIECES.items()}


def write(tmp_path: Path, suffix: str, data: str | bytes) -> Path:
    file = tmp_path / f"part{suffix}"
    file.write_bytes(data if isinstance(data, bytes) else data.encode())
    return file


def test_every_reader_has_a_sample_and_a_module() -> None:
    assert set(SAMPLES) == set(SUFFIXES) == set(FRAGMENTS) == set(READERS.values())
    for name in SUFFIXES:
        assert callable(import_module(f"toolpaths.languages.{name}.reader").read)


@pytest.mark.parametrize(("name", "suffix"), EVERY)
@pytest.mark.parametrize("dress", ["plain", "crlf", "bom", "upper"])
def test_same_poses_from_every_language(tmp_path: Path, name: str, suffix: str, dress: str) -> None:
    text = SAMPLES[name].replace("\n", "\r\n") if dress == "crlf" else SAMPLES[name]
    data = text.encode("utf-8-sig" if dress == "bom" else "utf-8")
    file = write(tmp_path, suffix.upper() if dress == "upper" else suffix, data)
    path = read_toolpath(str(file))
    expected = np.array([[0, 0, 5], [10, 0, 0], [10, -4, 0], [10, -4, 5]]) * 1e-3
    np.testing.assert_allclose(path.position, expected, rtol=0, atol=1e-15)
    np.testing.assert_allclose(path.axis, [[0, 0, 1]] * 4, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(path.kind, [0, 1, 1, 0])
    air = {"rapid": 0.1}.get(name, np.nan)  # a MoveJ of RAPID has a speed in mm/s
    np.testing.assert_allclose(path.feed, [air, 0.01, 0.01, air], rtol=1e-14)
    np.testing.assert_array_equal(path.row, [0, 1, 2, 3])
    assert [text.split("\n")[n - 1].count("5") for n in path.line] == [1, 0, 0, 1]
    assert (path.source, path.language) == (str(file), name)
    kinds = {
        "position": "f8",
        "axis": "f8",
        "feed": "f8",
        "kind": "u1",
        "tool": "i4",
        "line": "i4",
        "row": "f8",
    }
    for field, dtype in kinds.items():
        value = getattr(path, field)
        assert value.dtype == np.dtype(dtype) and len(value) == 4 and not value.flags.writeable, field


@pytest.mark.parametrize(("name", "suffix"), [(n, s[0]) for n, s in SUFFIXES.items()])
@pytest.mark.parametrize(
    ("data", "word"),
    [
        (b"", "empty"),
        (b" \r\n\t\n", "empty"),
        (b"\x7fELF\x02\x01\x00\x00", "binary"),
        ("G0 X1\n".encode("utf-16"), "UTF-16"),
        (b"GOTO/1,2\x01,3\n", "not a text file"),
        (b"<<<<<<< ours\nG1\n=======\nG2\n>>>>>>> theirs\n", "merge-conflict"),
        (b"%PDF-1.7\nxref\n", ""),
        (b"<html><body>Not found</body></html>\n", ""),
    ],
)
def test_mistakes_of_a_person(tmp_path: Path, name: str, suffix: str, data: bytes, word: str) -> None:
    file = write(tmp_path, suffix, data)
    with pytest.raises(ReadError) as caught:
        read_toolpath(file)
    assert word in str(caught.value) and str(caught.value).startswith(str(file))


@pytest.mark.parametrize("name", SUFFIXES)
def test_missing_file_and_folder(tmp_path: Path, name: str) -> None:
    suffix = SUFFIXES[name][0]
    with pytest.raises(ReadError, match="no such file"):
        read_toolpath(tmp_path / f"none{suffix}")
    (tmp_path / f"folder{suffix}").mkdir()
    with pytest.raises(ReadError, match="folder"):
        read_toolpath(tmp_path / f"folder{suffix}")


def test_unknown_suffix_lists_the_known(tmp_path: Path) -> None:
    for suffix in (".stl", ""):
        with pytest.raises(ReadError) as caught:
            read_toolpath(write(tmp_path, suffix, "G0"))
        assert all(known in str(caught.value) for known in READERS)


def test_senseless_chord(tmp_path: Path) -> None:
    for chord in (0.0, -1e-5, float("nan"), 2.0):
        with pytest.raises(ValueError, match="chord"):
            read_toolpath(write(tmp_path, ".nc", SAMPLES["gcode"]), chord=chord)


@pytest.mark.parametrize("name", [n for n in SUFFIXES if n != "csv"])
def test_every_cut_off_file_is_refused_or_whole(tmp_path: Path, name: str) -> None:
    """Cut at any byte: refused; or only the end word is missing and the poses are those of the lines left."""
    text = SAMPLES[name]
    whole = read_toolpath(write(tmp_path, SUFFIXES[name][0], text))
    for end in range(len(text) - 1):
        file = write(tmp_path, SUFFIXES[name][0], text[:end])
        try:
            path = read_toolpath(file)
        except ReadError:
            continue
        assert text[end - 1] == "\n" or text[end:].strip("\n") == "" or "M30" in text[:end]
        np.testing.assert_array_equal(path.position, whole.position[: len(path)])


FULL = "CIRC {X 0,Y 1800000,Z 0},{X 900000,Y 900000,Z 0}\nCIRC {X 0,Y 1800000,Z 0},{X 0,Y 0,Z 0}\n"
HUGE = {  # circles of a radius of 900 m: what they make of a small file, and from which chord on it is too much
    "gcode": ("G21 G90 G17\nG0 X0 Y0 Z5\n" + "G2 X0 Y0 I900000 P100 F100\n" * 30 + "M30\n", 1e-5),
    "krl": ("DEF P()\n$VEL.CP=0.1\nPTP {X 0,Y 0,Z 0,A 0,B 0,C 180}\n" + FULL * 8 + "END\n", 1e-8),
}


@pytest.mark.parametrize("name", HUGE)
def test_arcs_do_not_fill_the_memory(tmp_path: Path, name: str) -> None:
    text, chord = HUGE[name]
    file = write(tmp_path, SUFFIXES[name][0], text)
    assert len(text) < 1024
    tracemalloc.start()
    try:
        with pytest.raises(ReadError, match=r"arcs make \d{7,} poses"):
            read_toolpath(file, chord=chord)
        assert tracemalloc.get_traced_memory()[1] < 5e6
    finally:
        tracemalloc.stop()
    assert 30 < len(read_toolpath(file, chord=0.9)) < 1e6


def attempt(file: Path) -> None:
    try:
        path = read_toolpath(file)
    except ToolpathError as refusal:
        assert str(file) in str(refusal)
        return
    assert len(path) > 0 and np.isfinite(path.position).all()
    np.testing.assert_allclose(np.linalg.norm(path.axis, axis=1), 1, atol=1e-12)
    assert (path.feed[path.kind == 1] > 0).all() or np.isnan(path.feed).any()
    assert (np.diff(path.row) > 0).all() and all(0 <= e.pose <= len(path) for e in path.events)


@pytest.mark.parametrize("name", SUFFIXES)
@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_only_refusals_escape(tmp_path: Path, name: str, data: st.DataObject) -> None:
    suffix = SUFFIXES[name][0]
    attempt(write(tmp_path, suffix, data.draw(st.binary(max_size=80))))
    attempt(write(tmp_path, suffix, data.draw(st.text(max_size=80)).encode("utf-8", "replace")))
    pieces = data.draw(st.lists(st.sampled_from(FRAGMENTS[name]), max_size=40))
    attempt(write(tmp_path, suffix, data.draw(st.sampled_from(["", " ", "\n"])).join(pieces)))
    lines = SAMPLES[name].split("\n")
    at = data.draw(st.integers(0, len(lines) - 1))
    lines[at] = lines[at] + data.draw(st.sampled_from(["", " ", ","])) + "".join(pieces[:3])
    attempt(write(tmp_path, suffix, "\n".join(lines)))


def imported(code: str) -> set[str]:
    """Modules that are there after ``code``, in a Python of its own."""
    root = Path(__file__).parents[2]
    command = [sys.executable, "-c", f"import sys; {code}; print(*sys.modules)"]
    return set(subprocess.run(command, cwd=root, timeout=60, check=True, capture_output=True, text=True).stdout.split())


def test_the_table_is_light() -> None:
    """The command line reads it to show its help."""
    assert "numpy" not in imported("import toolpaths.languages.table")


def test_languages_are_imported_only_when_used(tmp_path: Path) -> None:
    def folders(modules: set[str]) -> set[str]:
        return {m.split(".")[2] for m in modules if m.startswith("toolpaths.languages.")} - {"table"}

    assert folders(imported("import toolpaths.files")) == set()
    for name, group in SUFFIXES.items():
        file = write(tmp_path, group[0], SAMPLES[name])
        found = imported(f"from toolpaths.files import read_toolpath; read_toolpath({str(file)!r})")
        assert folders(found) == {name} and "scipy" not in found
        assert not [m for m in found if m.endswith((".writer", ".filter")) and m.startswith("toolpaths.languages")]


PAGE = Path(__file__).parents[2] / "docs" / "toolpaths-in.md"
EXAMPLES = re.findall(
    r"^```(\w+) (?:(\d+) poses|refused in line (\d+))\n(.*?)^```$", PAGE.read_text(), re.M | re.S
)


@pytest.mark.parametrize(("suffix", "poses", "line", "text"), EXAMPLES)
def test_examples_of_the_page(tmp_path: Path, suffix: str, poses: str, line: str, text: str) -> None:
    file = write(tmp_path, f".{suffix}", text)
    if poses:
        assert len(read_toolpath(file)) == int(poses)
        return
    with pytest.raises(ReadError) as caught:
        read_toolpath(file)
    assert caught.value.line == int(line)


def test_the_page_has_examples_of_every_language() -> None:
    assert PAGE.read_text().count("\n```") == 2 * len(EXAMPLES)
    assert {READERS[f".{suffix}"] for suffix, *_ in EXAMPLES} == set(SUFFIXES)
    assert all(suffix in PAGE.read_text() for suffix in READERS)
