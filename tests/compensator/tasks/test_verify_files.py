"""`verify`: programs as they were written are told from those that somebody changed, in every language."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from compensator.cli import main
from compensator.tasks.compensate import compensate_file, preview_file
from compensator.tasks.verify import verify_file
from tests.compensator.small_job import Files, files

SUFFIXES = {
    "rapid": ".mod", "krl": ".src", "fanuc": ".ls", "urscript": ".script", "val3": ".pgx", "inform": ".jbi",
    "gcode": ".nc",
}  # fmt: skip
#: A pose of the program, and the same moved by a millimetre, by language.
POSE = {
    "rapid": r"(MoveL \[\[)(-?\d+)", "krl": r"(LIN \{X )(-?\d+)", "fanuc": r"(X = +)(-?\d+)",
    "urscript": r"(movel\(.*?p\[)(-?\d+)",
    "val3": r'(<Value key="\d+" x=")(-?\d+)', "inform": r"(C00020=)(-?\d+)", "gcode": r"(\nX)([4-6]0)(?=\.)",
}  # fmt: skip


def made(folder: Path, suffix: str = ".mod") -> tuple[Files, Path]:
    """The small job, and its program."""
    job = files(folder)
    program = job.out / f"PART{suffix}"
    compensate_file(job.toolpath, job.cell, program, json=job.out / "a.json")
    return job, program


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, ["verify", *(str(a) for a in arguments)])


@pytest.mark.parametrize("language", SUFFIXES)
def test_as_it_was_written(tmp_path: Path, language: str) -> None:
    """Confirmed; the error is that of the summary, its head has the hashes of the JSON summary."""
    job, program = made(tmp_path, SUFFIXES[language])
    report = verify_file(program, job.cell).report
    assert (report["verdict"], report["sealed"], report["n_changed_lines"]) == ("confirmed", True, 0), report
    summary = json.loads((job.out / "a.json").read_text())
    after = summary["predicted_error_mm"]["after"]
    assert report["predicted_error_mm"]["program"] == pytest.approx(after, abs=1e-9)
    assert report["predicted_error_mm"]["head"] == pytest.approx(after["max"], abs=5.1e-5)
    text = program.read_text()
    for name in ("cell", "model", "toolpath"):
        assert text.count(f"{name} sha256:{summary['provenance'][name]}") == 1
    assert report["provenance"] == summary["provenance"]


@pytest.mark.parametrize("language", SUFFIXES)
def test_a_pose_that_was_edited(tmp_path: Path, language: str) -> None:
    """By a millimetre: named by file and line, and its error is about that millimetre."""
    job, program = made(tmp_path, SUFFIXES[language])
    programs = [f for f in sorted(job.out.iterdir()) if f.suffix != ".json"]
    (edited,) = [f for f in programs if re.search(POSE[language], f.read_text())]
    data = edited.read_bytes().decode("latin-1")
    spots = list(re.finditer(POSE[language], data))
    m = spots[len(spots) // 2]
    step = 1 if language != "urscript" else 0
    new = f"{m[1]}{int(m[2]) + step}" if step else data[m.start() : m.end()]
    data = data[: m.start()] + new + data[m.end() :]
    if language == "urscript":  # metres: the third decimal
        n = next(x for x in re.finditer(r"movel\(.*?p\[(-?\d\.\d\d)(\d)", data) if x.start() >= m.start())
        data = data[: n.start(2)] + str((int(n[2]) + 1) % 10) + data[n.end(2) :]
    edited.write_bytes(data.encode("latin-1"))
    done = run(program, "--cell", job.cell)
    assert done.exit_code == 1 and "edited since it was written" in done.stdout, done.output
    line = data.count("\n", 0, m.start(2)) + 1
    assert f"error: {edited.name}:{line}: written was" in done.stdout, done.stdout
    report = verify_file(program, job.cell).report
    assert report["sealed"] is False and report["n_changed_lines"] == 1
    assert 0.5 < report["predicted_error_mm"]["program"]["max"] < 10


def test_a_comment_or_a_feed_that_was_edited(tmp_path: Path) -> None:
    """Not a pose, but not what was written."""
    job, program = made(tmp_path)
    text = program.read_text()
    program.write_text(text.replace("vf2:=[20", "vf2:=[40"), newline="")
    assert program.read_text() != text
    report = verify_file(program, job.cell).report
    assert report["verdict"] == "edited since it was written" and report["changed_lines"][0]["line"] > 1
    assert report["predicted_error_mm"]["program"]["max"] < 0.005
    program.write_bytes(program.read_bytes().replace(b"predicted error 0.", b"predicted error 9."))
    assert verify_file(program, job.cell).report["sealed"] is False


def test_a_line_that_was_taken_out(tmp_path: Path) -> None:
    """Cannot be simulated, and is told where."""
    job, program = made(tmp_path)
    lines = program.read_text().splitlines(keepends=True)
    moves = [k for k, line in enumerate(lines) if "MoveL" in line]
    program.write_text("".join(lines[: moves[5]] + lines[moves[6] :]), newline="")
    report = verify_file(program, job.cell).report
    assert report["verdict"] == "edited since it was written"
    assert [(c["line"], c["stands"]) for c in report["changed_lines"]] == [(moves[5] + 1, "")]
    assert report["predicted_error_mm"]["program"] is None


def test_other_inputs(tmp_path: Path) -> None:
    """A softer model: the program is as written, but not what was predicted; a comment in the cell changes nothing."""
    job, program = made(tmp_path)
    job.cell.write_text(job.cell.read_text() + "\n# a remark\n")
    done = run(program, "--cell", job.cell)
    assert done.exit_code == 0 and "warning: cell is " in done.stdout and "confirmed" in done.stdout
    model = tmp_path / "model.toml"
    model.write_text(model.read_text().replace("2000000.0", "1000000.0"))
    report = verify_file(program, job.cell).report
    assert report["verdict"] == "not what was predicted" and report["sealed"] is True
    assert report["other_inputs"] == ["cell", "model"]
    assert report["predicted_error_mm"]["program"]["max"] > 0.05


def test_the_toolpath_is_found_by_its_hash(tmp_path: Path) -> None:
    """Under another name beside the cell; where it is nowhere it is asked for."""
    job, program = made(tmp_path)
    job.toolpath.rename(tmp_path / "renamed.csv")
    assert verify_file(program, job.cell).report["verdict"] == "confirmed"
    (tmp_path / "renamed.csv").rename(tmp_path / "away.txt")
    done = run(program, "--cell", job.cell)
    assert done.exit_code == 1 and "give --toolpath FILE" in done.stderr
    assert run(program, "--cell", job.cell, "--toolpath", tmp_path / "away.txt", "--from", "csv").exit_code == 0


def test_a_csv_has_no_head(tmp_path: Path) -> None:
    """It is compared with what is written now."""
    job, program = made(tmp_path, ".csv")
    assert run(program, "--cell", job.cell).exit_code == 1
    report = verify_file(program, job.cell, toolpath=[job.toolpath]).report
    assert report["verdict"] == "confirmed" and report["sealed"] is None
    rows = program.read_text().splitlines()
    rows[6] = rows[6].replace(rows[6].split(",")[2], "55.5", 1)
    program.write_text("\n".join(rows) + "\n")
    assert verify_file(program, job.cell, toolpath=[job.toolpath]).report["verdict"] == "edited since it was written"


def test_in_place(tmp_path: Path) -> None:
    """A program that was changed in place has its head in the line of the mark."""
    job = files(tmp_path)
    part, program = tmp_path / "part.nc", job.out / "part_c.nc"
    part.write_text("%\nG21 G90\nG0 X0 Y0 Z80\nG0 Z5\nG1 Z-2 F300\nG1 X100 F1200\nG0 Z80\nM30\n%\n")
    compensate_file(part, job.cell, program)
    assert sum("sha256" in line for line in program.read_text().splitlines()) == 1
    assert verify_file(program, job.cell).report["verdict"] == "confirmed"
    text = program.read_text()
    m = re.search(r"G1 X(\d+)\.", text)
    assert m is not None
    program.write_text(text.replace(m[0], f"G1 X{int(m[1]) + 1}.", 1))
    done = run(program, "--cell", job.cell)
    assert done.exit_code == 1 and "part_c.nc:" in done.stdout and "edited since" in done.stdout


def test_same_inputs_same_bytes(tmp_path: Path) -> None:
    """In another folder, under other names of the folders."""
    texts = []
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        _, program = made(tmp_path / name)
        texts.append(program.read_bytes())
    assert texts[0] == texts[1]


def test_hashes_cover_what_the_cell_names(tmp_path: Path) -> None:
    """A wrench table is part of the cell."""
    rows = "index,fx,fy,fz,mx,my,mz\n" + "".join(f"{k},-300,200,250,5,-4,3\n" for k in range(6))
    (tmp_path / "w.csv").write_text(rows)
    job = files(tmp_path, {"process": {"kind": "table", "frame": "workobject", "file": "w.csv"}})
    one = preview_file(job.toolpath, job.cell).report["provenance"]
    (tmp_path / "w.csv").write_text(rows.replace("250", "251"))
    other = preview_file(job.toolpath, job.cell).report["provenance"]
    assert one["cell"] != other["cell"] and one["model"] == other["model"] and one["toolpath"] == other["toolpath"]
