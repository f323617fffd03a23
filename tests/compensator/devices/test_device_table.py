"""The table of devices: files are known by what is in them, and what is unknown is refused with what to give."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest

from compensator.devices.device_text import device_text
from compensator.devices.readings import KINDS, DeviceFile
from compensator.devices.table import DEVICES, device_of
from compensator.errors import DeviceError
from tests.compensator.devices.device_samples import BAR, SA_BARE, SAMPLES

FOLDER = Path(__file__).parents[3] / "compensator" / "devices"


@pytest.mark.parametrize("name", SAMPLES)
def test_a_file_is_known_by_its_content(name: str) -> None:
    assert device_of(DeviceFile("whatever.dat", SAMPLES[name])).name == name


@pytest.mark.parametrize("name", SAMPLES)
@pytest.mark.parametrize("other", SAMPLES)
def test_no_other_device_takes_it_for_its_own(name: str, other: str) -> None:
    device = next(d for d in DEVICES if d.name == other)
    assert device.recognised(DeviceFile("x.txt", SAMPLES[name])) == (name == other)


def test_other_forms() -> None:
    assert device_of(DeviceFile("x.txt", SA_BARE)).name == "spatial-analyzer"
    assert device_of(DeviceFile("x.csv", BAR)).name == "csv"
    assert device_of(DeviceFile("run.B5R", "")).name == "ball-bar"
    assert device_of(DeviceFile("x.txt", "a b\n1 2\n"), "qif").name == "qif"
    assert device_of(DeviceFile("x.txt", SAMPLES["qif"], {"x": "X"})).name == "csv"


def test_every_device_has_a_sample_and_a_kind() -> None:
    assert {d.name for d in DEVICES} == {*SAMPLES, "ball-bar"}
    for d in DEVICES:
        if d.name in SAMPLES:
            given = d.read(DeviceFile("f", SAMPLES[d.name]))
            assert given.device == d.name and given.kind in KINDS and len(given) and np.all(given.line > 0)


def test_no_device_imports_another_or_the_table() -> None:
    modules = {d.module for d in DEVICES}
    for name in modules:
        tree = ast.parse((FOLDER / f"{name}.py").read_text(encoding="utf-8"))
        imported = {n.module for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)}
        assert not imported & {f"compensator.devices.{m}" for m in {*modules, "table"} - {name}}


def test_what_nobody_knows_is_refused() -> None:
    with pytest.raises(DeviceError, match=r"f\.txt: no device known here .* --from with one of: .*qif .*--column x="):
        device_of(DeviceFile("f.txt", "hello\nworld\n"))
    with pytest.raises(DeviceError, match=r"--column names columns of a csv, not of --from qif"):
        device_of(DeviceFile("f.txt", SAMPLES["qif"], {"x": "X"}), "qif")


def test_a_closed_format_is_refused_with_the_way_around() -> None:
    with pytest.raises(DeviceError, match=r"closed format.* save them as csv.* --column radius="):
        device_of(DeviceFile("a.b5r", "")).read(DeviceFile("a.b5r", ""))


@pytest.mark.parametrize(
    ("raw", "why"),
    [(b"PK\x03\x04", "a zip or office file"), (b"%PDF-1.7", "a PDF"), (b"a\0b", "binary"), (b" \n", "is empty")],
)
def test_what_is_no_text_is_refused(tmp_path: Path, raw: bytes, why: str) -> None:
    file = tmp_path / "f.txt"
    file.write_bytes(raw)
    with pytest.raises(DeviceError, match=rf"f\.txt: (is )?{why}"):
        device_text(file)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_text_of_shop_floor_computers(tmp_path: Path, encoding: str) -> None:
    (tmp_path / "f.txt").write_bytes("Prüfplan µm\n".encode(encoding))
    assert device_text(tmp_path / "f.txt").lines == ["Prüfplan µm"]
