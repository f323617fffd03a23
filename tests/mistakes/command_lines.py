"""Mistakes of the command line: names, options, and outputs where they must not be."""

from __future__ import annotations

import os
from pathlib import Path

from tests.mistakes.mistake import Mistake, write


def symbolic(folder: Path) -> None:
    os.symlink("model.toml", folder / "link.json")


def hard(folder: Path) -> None:
    os.link(folder / "session.toml", folder / "link.json")


def pipe(folder: Path) -> None:
    os.mkfifo(folder / "pipe.mod")


def subfolder(folder: Path) -> None:
    (folder / "out.mod").mkdir()


COMPENSATE = "compensate part.nc --cell cell.toml"
TABLE = "compensate path.csv --cell table.toml"
IDENTIFY = "identify session.toml --effects joint-stiffness"

NAMES = (
    Mistake("no cell is given", "compensate part.nc -o part.mod"),
    Mistake("a verb is misspelt", "compensat part.nc --cell cell.toml -o part.mod"),
    Mistake("an option is misspelt", f"{COMPENSATE} --ouput part.mod"),
    Mistake("the toolpath is not there", "preview prat.nc --cell cell.toml"),
    Mistake("a folder is the toolpath", "preview other --cell cell.toml"),
    Mistake("standard input is the toolpath", "preview - --cell cell.toml"),
    Mistake("the toolpath is a drawing", "preview part.dxf --cell cell.toml", write("part.dxf", "0\nSECTION\n")),
    Mistake("the cell is not there", "preview part.nc --cell cel.toml"),
    Mistake("a folder is the cell", "preview part.nc --cell other"),
    Mistake("the cell is the toolpath", "preview cell.toml --cell part.nc"),
    Mistake("a model is given as cell", "preview part.nc --cell model.toml"),
    Mistake("a session is given as model", "evaluate session.toml --model session.toml"),
    Mistake("a model is given as session", "evaluate model.toml --model model.toml"),
    Mistake("the samples are given as session", "identify samples.csv -o out.toml"),
    Mistake("the language of the output is not known", f"{COMPENSATE} -o part.txt"),
    Mistake("a format that does not exist", f"{COMPENSATE} -o part.txt --format cobol"),
    Mistake("a robot that does not exist", "robots kr1000"),
    Mistake("an effect is misspelt", "effects backlsh"),
    Mistake("an effect to fit is misspelt", "identify session.toml --effects backlsh -o out.toml"),
    Mistake("the method by joint with a set of effects", f"{IDENTIFY} --method local -o out.toml"),
    Mistake("a plan for a toolpath without its cell", "plan model.toml --toolpath part.nc -o plan.csv"),
    Mistake("a plan of no set-up", "plan model.toml --count 0 -o plan.csv"),
    Mistake("a grid with commas for colons", "stiffness-map model.toml --grid -20,20,10 --json map.json"),
    Mistake("a map without load", "stiffness-map model.toml --wrench 0 0 0 0 0 0 --json map.json"),
    Mistake("a robot without reducer data", "datasheet ur10 -o out.toml"),
)
OUTPUTS = (
    Mistake("the program over the toolpath", f"{COMPENSATE} -o part.nc"),
    Mistake("the program over the cell", f"{COMPENSATE} --format csv -o cell.toml"),
    Mistake("the program over the model", f"{COMPENSATE} --format csv -o model.toml"),
    Mistake("the program over the robot", f"{COMPENSATE} --format csv -o ./other/../arm.toml"),
    Mistake("the program over the wrench table", f"{TABLE} -o wrenches.csv"),
    Mistake("the report over the toolpath", f"{COMPENSATE} -o part.mod --report part.nc"),
    Mistake("the summary through a link to the model", f"{COMPENSATE} -o part.mod --json link.json", symbolic),
    Mistake("the deflections over the toolpath", "preview path.csv --cell cell.toml --csv path.csv"),
    Mistake("the model over the session", f"{IDENTIFY} -o session.toml"),
    Mistake("the model over the samples", f"{IDENTIFY} -o samples.csv"),
    Mistake("the summary over a hard link of the session", f"{IDENTIFY} -o out.toml --json link.json", hard),
    Mistake("the summary over the model", "evaluate session.toml --model model.toml --json model.toml"),
    Mistake("the refined model over the model", "diagnose session.toml --model model.toml -o model.toml"),
    Mistake("the plan over the samples", "plan model.toml --session session.toml -o samples.csv"),
    Mistake("program and summary in one file", f"{COMPENSATE} -o part.mod --json part.mod"),
    Mistake("an output in a folder that is not there", f"{COMPENSATE} -o aut/part.mod"),
    Mistake("an output below a file", f"{COMPENSATE} -o part.nc/part.mod"),
    Mistake("a folder stands where the output goes", f"{COMPENSATE} -o out.mod", subfolder),
    Mistake("a pipe stands where the output goes", f"{COMPENSATE} -o pipe.mod", pipe),
    Mistake("an output to /dev/null", f"{COMPENSATE} --format rapid -o /dev/null"),
    Mistake("a program of several files to standard output", f"{COMPENSATE} --format val3 -o -"),
    Mistake("two files to standard output", f"{COMPENSATE} --format rapid -o - --json -"),
    Mistake("standard output without a format", f"{COMPENSATE} -o -"),
    Mistake("a name that the language cannot have", f"{COMPENSATE} -o 1-part.src"),
    Mistake("the summary where a file of the program goes", f"{COMPENSATE} --format val3 -o part.pgx --json part.dtx"),
    Mistake("a program beside another application", f"{COMPENSATE} -o part.pgx", write("start.pgx", "another one")),
    Mistake("the model ends in .txt", "datasheet arm.toml -o model.txt"),
)
