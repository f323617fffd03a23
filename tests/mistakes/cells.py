"""Mistakes in a cell, and in the model and the wrench table that it names."""

from __future__ import annotations

from pathlib import Path

from tests.mistakes.inputs import CELL, MODEL
from tests.mistakes.mistake import Mistake, Spoil, both, edit, write

RUN = "compensate part.nc --cell cell.toml -o part.mod"
PREVIEW = "preview part.nc --cell cell.toml"
TABLE = "preview path.csv --cell table.toml"
WRENCH = "[-120.0, 80.0, -60.0, 0.0, 0.0, 0.0]"
UNKNOWN = "[true, true, false, true, true, true]"
HEAD = "index,fx,fy,fz,mx,my,mz\n"


def cell(old: str, new: str = "") -> Spoil:
    return edit("cell.toml", old, new)


def added(lines: str) -> Spoil:
    """More lines at the end of the cell."""
    return write("cell.toml", f"{CELL}\n{lines}\n")


def without(table: str) -> Spoil:
    """The cell without a table."""
    before, _, after = CELL.partition(f"[{table}]\n")
    return write("cell.toml", before + (after[after.index("\n[") :] if "\n[" in after else ""))


def model(old: str, new: str) -> Spoil:
    return edit("model.toml", old, new)


def remove(name: str) -> Spoil:
    def spoil(folder: Path) -> None:
        (folder / name).unlink()

    return spoil


FILES = (
    Mistake("the cell is empty", RUN, write("cell.toml", "")),
    Mistake("the cell has a byte order mark", PREVIEW, write("cell.toml", b"\xef\xbb\xbf" + CELL.encode())),
    Mistake("the cell is UTF-16", RUN, write("cell.toml", CELL.encode("utf-16"))),
    Mistake("an umlaut in Windows-1252", RUN, write("cell.toml", CELL.encode() + "# Fräser\n".encode("cp1252"))),
    Mistake("the cell is JSON", RUN, write("cell.toml", '{"schema": "cell/1"}\n')),
    Mistake("typographic quotes", RUN, cell('"arm.toml"', "\u201carm.toml\u201d")),
    Mistake("a name without quotes", RUN, cell('"arm.toml"', "arm.toml")),
    Mistake("a path with backslashes", RUN, cell('"arm.toml"', '"C:\\robots\\arm.toml"')),
    Mistake("a bracket is missing", RUN, cell("[tool]", "[tool")),
    Mistake("a key twice", RUN, cell('model = "model.toml"', 'model = "model.toml"\nmodel = "m.toml"')),
    Mistake("a decimal comma", RUN, added("[solve]\nmax_correction = 2,5")),
    Mistake("decimal commas in a list", RUN, cell("[0.0, 0.0, 250.0]", "[0,0, 0,0, 250,0]")),
)
KEYS = (
    Mistake("a key is misspelt", RUN, added("[solve]\nmax_corection = 2.0")),
    Mistake("another schema", RUN, cell("cell/1", "cell/2")),
    Mistake("no [process]", RUN, without("process")),
    Mistake("no [tool]", RUN, without("tool")),
    Mistake("no [workobject]", RUN, without("workobject")),
    Mistake("no model", RUN, cell('model = "model.toml"\n', "")),
    Mistake("a process that does not exist", RUN, cell('kind = "constant"', 'kind = "drilling"')),
    Mistake("no kind of process", RUN, cell('kind = "constant"\n', "")),
    Mistake("axes that do not exist", RUN, cell('frame = "path"', 'frame = "feed"')),
    Mistake("a wrench of three numbers", RUN, cell(WRENCH, "[-120.0, 80.0, -60.0]")),
    Mistake("a wrench of seven numbers", RUN, cell(WRENCH, "[-120.0, 80.0, -60.0, 0.0, 0.0, 0.0, 0.0]")),
    Mistake("a wrench as text", RUN, cell(WRENCH, '"-120, 80, -60, 0, 0, 0"')),
    Mistake("a number as text", RUN, cell("250.0]", '"250,5"]')),
    Mistake("a number with its unit", RUN, cell("250.0]", '"250 mm"]')),
    Mistake("a mass without its centre", RUN, cell("com = [0.0, 0.0, 110.0]\n", "")),
    Mistake("a robot that is not there", RUN, cell("arm.toml", "amr.toml")),
    Mistake("a model that is not there", RUN, cell("model.toml", "modle.toml")),
)
NUMBERS = (
    Mistake("the tool in metres", RUN, cell("[0.0, 0.0, 250.0]", "[0.0, 0.0, 0.25]")),
    Mistake("an angle in radians", RUN, cell("250.0]", "250.0]\nrpy = [0.0, 1.5707963, 0.0]")),
    Mistake("a tool measured from another flange", PREVIEW, both(cell('tip = "tool0"\n'), cell("110.0]", "-70.0]"))),
    Mistake("a tool without length", PREVIEW, cell("[0.0, 0.0, 250.0]", "[0.0, 0.0, 0.0]")),
    Mistake("the wrench in kN", PREVIEW, cell(WRENCH, "[-0.12, 0.08, -0.06, 0.0, 0.0, 0.0]")),
    Mistake("a moment in N*mm", PREVIEW, cell(WRENCH, "[-120.0, 80.0, -60.0, 0.0, 0.0, 900.0]")),
    Mistake("the force on the part", PREVIEW, cell(WRENCH, "[120.0, -80.0, 60.0, 0.0, 0.0, 0.0]")),
    Mistake("ten times the force", RUN, cell(WRENCH, "[-6000.0, 4000.0, -3000.0, 0.0, 0.0, 0.0]")),
    Mistake("poses 0.0001 mm apart", RUN, added("[sampling]\nspacing = 0.0001")),
    Mistake("a part out of reach", RUN, cell("[1500.0, -150.0, 800.0]", "[15000.0, -1500.0, 8000.0]")),
    Mistake("a part upside down", RUN, cell("800.0]", "100.0]\nrpy = [180.0, 0.0, 0.0]")),
    Mistake("a start with five joints", RUN, added("[start]\njoints = [0.0, 0.0, 20.0, 0.0, 60.0]")),
    Mistake("a start beyond a joint limit", RUN, added("[start]\njoints = [0.0, 0.0, 120.0, 0.0, 60.0, 0.0]")),
    Mistake("a start in another configuration", RUN, added("[start]\njoints = [129, -60, -5, 165, 87, 25]")),
    Mistake("a lateral force in tool axes", RUN, cell('frame = "path"', 'frame = "tool"')),
    Mistake("400 deg C", RUN, cell('gravity = "calibrated-out"', "temperature = 400.0")),
)
MODELS = (
    Mistake("the model is empty", RUN, write("model.toml", "")),
    Mistake("a model without effects", RUN, write("model.toml", MODEL.partition("[effects")[0])),
    Mistake("five stiffnesses", RUN, model(", 3.74e4]", "]")),
    Mistake("stiffness in N*m per deg", RUN, model("9.6e4, 3.74e4", "1675.0, 65.0")),
    Mistake("a negative stiffness", RUN, model("2.0e6", "-2.0e6")),
    Mistake("an effect that does not exist", RUN, model("joint-stiffness]", "joint-stifness]")),
    Mistake("a model of another robot", RUN, model('"arm.toml"', '"ur10"')),
    Mistake("a joint that nobody measured", RUN, model("sd_nm", f"identified = {UNKNOWN}\nsd_nm")),
    Mistake("an HTML page saved as model", RUN, write("model.toml", "<!DOCTYPE html>\n<html></html>\n")),
)
TABLES = (
    Mistake("the wrench table is not there", TABLE, remove("wrenches.csv")),
    Mistake("a cut without a wrench", TABLE, edit("wrenches.csv", "3,-120,80,-60,0,0,0\n", "")),
    Mistake("a wrench twice", TABLE, edit("wrenches.csv", "3,-120", "2,-120")),
    Mistake("semicolons in the wrench table", TABLE, write("wrenches.csv", HEAD.replace(",", ";") + "2;0,5;0;0\n")),
    Mistake("a word for a force", TABLE, edit("wrenches.csv", "3,-120", "3,much")),
    Mistake("a table without moments", TABLE, write("wrenches.csv", "index,fx,fy,fz\n2,0,0,0\n")),
)
