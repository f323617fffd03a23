"""Files that the suffix does not tell, and jobs of Yaskawa and Staubli, through to a program."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from compensator.cli import main
from compensator.tasks.compensate import compensate_file
from tests.compensator.small_job import files
from toolpaths.errors import ReadError, WriteError
from toolpaths.files import read_toolpath

TOOL = {"xyz": [0.0, 0.0, 240.0], "mass": 30.0, "com": [0.0, 0.0, 110.0]}
#: Tool down in the base frame, mm.
PLACES = [(1500, -150, 880), (1500, -150, 798), (1600, -150, 798), (1600, -90, 798), (1600, -90, 880)]
DOWN = "180.0000,0.0000,0.0000"


def inform() -> str:
    rows = "".join(f"C{k:05d}={x:.3f},{y:.3f},{z:.3f},{DOWN}\n" for k, (x, y, z) in enumerate(PLACES))
    moves = "MOVJ C00000 VJ=10.00\nMOVL C00001 V=5.0\nMOVL C00002 V=20.0\nMOVL C00003 V=20.0\nMOVJ C00004 VJ=10.00\n"
    head = "/JOB\n//NAME PART\n//POS\n///NPOS 5,0,0,0,0,0\n///TOOL 3\n///POSTYPE ROBOT\n///RECTAN\n"
    return f"{head}{rows}//INST\nNOP\n{moves}END\n"


def val3() -> str:
    body = ""
    for k, (x, y, z) in enumerate(PLACES):
        word, speed = ("movel", 5 if k == 1 else 20) if 0 < k < 4 else ("movej", 9999)
        body += f"  p.trsf={{{x},{y},{z},180,0,0}}\n  m.tvel={speed}\n  {word}(p,tMill3,m)\n"
    names = {"p": "pointRx", "m": "mdesc"}.items()
    data = "".join(f'<Local name="{n}" type="{k}" xsi:type="array" size="1" />\n' for n, k in names)
    code = f"<Code><![CDATA[\nbegin\n{body}end\n]]></Code>\n"
    return f'<Programs>\n<Program name="part">\n<Locals>\n{data}</Locals>\n{code}</Program>\n</Programs>\n'


@pytest.mark.parametrize(("suffix", "text"), [(".jbi", inform()), (".pgx", val3())])
def test_a_job_becomes_a_program_of_another_robot(tmp_path: Path, suffix: str, text: str) -> None:
    """The same from both; the tool is the cell's, and the correction is that of the prediction."""
    cell = files(tmp_path, {"tool": TOOL, "workobject": None}).cell
    source = tmp_path / f"part{suffix}"
    source.write_text(text)
    done = compensate_file(source, cell, tmp_path / "part_c.mod")
    error = done.report["predicted_error_mm"]
    assert error["before"]["mean"] > 0.5 and error["after"]["max"] < 0.01
    path = read_toolpath(tmp_path / "part_c.mod")
    moved = np.linalg.norm(path.position[-1] * 1e3 - PLACES[-1])
    assert 0.3 < np.linalg.norm(path.position[path.kind == 1][-1] * 1e3 - PLACES[3]) < 3.0 and moved < 3.0
    compensate_file(source, cell, tmp_path / f"again{suffix}")  # its own language is written anew, not filtered
    with pytest.raises(ReadError, match="compensated already"):
        compensate_file(tmp_path / f"again{suffix}", cell, tmp_path / "d.mod")


def test_the_language_is_said_where_the_suffix_does_not_tell_it(tmp_path: Path) -> None:
    job = files(tmp_path)
    other = tmp_path / "path.txt"
    other.write_bytes(job.toolpath.read_bytes())
    with pytest.raises(ReadError, match=r"no reader for '\.txt'.*--from LANGUAGE"):
        compensate_file(other, job.cell, tmp_path / "a.mod")
    done = compensate_file(job.toolpath, job.cell, tmp_path / "a.mod")
    named = compensate_file(other, job.cell, tmp_path / "b.mod", read_as="csv")
    assert named.report["predicted_error_mm"] == done.report["predicted_error_mm"]
    asked = ["preview", str(other), "--cell", str(job.cell), "--from", "csv", "--json", str(tmp_path / "s.json")]
    assert CliRunner().invoke(main, asked).exit_code == 0
    with pytest.raises(ReadError, match="not an APT statement"):
        read_toolpath(other, language="apt")
    with pytest.raises((ReadError, WriteError), match="no language 'cobol'"):
        read_toolpath(other, language="cobol")
