"""Mistakes in the toolpath."""

from __future__ import annotations

from pathlib import Path

from tests.mistakes.inputs import PART, PATH
from tests.mistakes.mistake import Mistake, Spoil, both, edit, write
from toolpaths.writing.marker import MARKER

NC = "compensate part.nc --cell cell.toml -o part.mod"
CSV = "preview path.csv --cell cell.toml"


def nc(old: str, new: str) -> Spoil:
    return edit("part.nc", old, new)


def rows(old: str, new: str) -> Spoil:
    return edit("path.csv", old, new)


def scaled(folder: Path) -> None:
    """The csv in metres."""
    head, *lines = PATH.splitlines()
    cells = [line.split(",") for line in lines]
    small = [[*(f"{float(c) / 1000:g}" for c in row[:3]), *row[3:]] for row in cells]
    (folder / "path.csv").write_text("\n".join([head, *(",".join(row) for row in small)]) + "\n")


def slow(folder: Path) -> None:
    """Feeds in m/s."""
    (folder / "path.csv").write_text(PATH.replace(",300,", ",0.005,").replace(",1200,", ",0.02,"))


PRINT = ";FLAVOR:Marlin\nM82\nG28\nG1 Z15 F6000\nG1 X10 Y10 E0.5\nM84\n"

GCODE = (
    Mistake("the file is empty", NC, write("part.nc", "")),
    Mistake("a web page saved as .nc", NC, write("part.nc", "<!DOCTYPE html>\n<html><body>sign in</body></html>\n")),
    Mistake("a 3D print", NC, write("part.nc", PRINT)),
    Mistake("a binary file", NC, write("part.nc", b"PK\x03\x04\0\0\0\0")),
    Mistake("an APT file named .nc", NC, write("part.nc", "UNITS/MM\nGOTO/0,0,5\nFINI\n")),
    Mistake("decimal commas", NC, nc("X100 ", "X100,5 ")),
    Mistake("numbers with exponents", NC, nc("X100 ", "X1.0E+02 ")),
    Mistake("no units", NC, nc("G21 ", "")),
    Mistake("inches taken for mm", NC, nc("G21", "G20")),
    Mistake("tool radius left to the controller", NC, nc("G1 Z-2", "G41 D1\nG1 Z-2")),
    Mistake("variables", NC, nc("X100 ", "X#101 ")),
    Mistake("a rotary axis without its machine", NC, nc("X100 ", "X100 A30 ")),
    Mistake("a cut without feed", NC, write("part.nc", PART.replace(" F300", "").replace(" F1200", ""))),
    Mistake("the file is cut off", NC, write("part.nc", PART.partition("G0 Z50\nM30")[0])),
    Mistake("two programs in one file", NC, write("part.nc", PART + PART)),
    Mistake("an unsettled merge", NC, nc("Y60\n", "<<<<<<< mine\nY60\n=======\nY70\n>>>>>>> theirs\n")),
    Mistake("nothing cuts", NC, write("part.nc", PART.replace("G1 ", "G0 "))),
    Mistake("Z is never named", NC, write("part.nc", "G21 G90\nG0 X0 Y0\nG1 X50 F600\nM30\n")),
    Mistake(
        "a tool that the cell does not have",
        NC,
        both(nc("T1 M6", "T7 M6"), edit("cell.toml", "[tool]", "[tools.1]")),
    ),
    Mistake("a file that is compensated already", NC, nc("(PART)", f"(PART)\n({MARKER})")),
)
POSES = (
    Mistake("csv in metres", CSV, scaled),
    Mistake("feeds in m/s", CSV, slow),
    Mistake("no header", CSV, write("path.csv", PATH.partition("\n")[2])),
    Mistake("a column is missing", CSV, write("path.csv", PATH.replace("z_mm", "z"))),
    Mistake("semicolons", CSV, write("path.csv", PATH.replace(",", ";"))),
    Mistake("decimal commas in a row", CSV, rows("100,60,-2,", "100,60,-2,5,")),
    Mistake("a cell is no number", CSV, rows("100,60,-2,", "100,sixty,-2,")),
    Mistake("not a number", CSV, rows("100,60,-2,", "100,nan,-2,")),
    Mistake("a tool axis of length 2", CSV, rows("100,0,-2,0,0,1", "100,0,-2,0,0,2")),
    Mistake("a tool axis that points into the work", CSV, write("path.csv", PATH.replace(",0,0,1,", ",0,0,-1,"))),
    Mistake("a feed of 0", CSV, rows("0,0,1,300", "0,0,1,0")),
    Mistake("a kind of move that does not exist", CSV, rows("300,cut", "300,mill")),
    Mistake("the header twice", CSV, write("path.csv", PATH + PATH)),
)
