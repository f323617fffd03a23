"""Real files of devices, beside the checkout where they are: their traps, and second readers as oracles."""

from __future__ import annotations

import csv
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from compensator.devices.order import TraceOrder
from compensator.errors import DeviceError
from compensator.tasks.trace import TraceMade, trace_file

FOLDER = "shared/data/shop"
SHOP = next((p / FOLDER for p in Path(__file__).parents if (p / FOLDER).is_dir()), Path(FOLDER))
pytestmark = pytest.mark.skipif(not SHOP.is_dir(), reason=f"real device files: no {FOLDER} in a folder above")


def made(folder: Path, name: str, **options: object) -> TraceMade:
    order = TraceOrder(**{key: options.pop(key) for key in list(options) if key in TraceOrder.__dataclass_fields__})
    return trace_file(SHOP / name, folder / "trace.toml", order=order, **options)  # type: ignore[arg-type]


def columns(folder: Path) -> dict[str, np.ndarray]:
    rows = list(csv.DictReader((folder / "samples.csv").read_text().splitlines()))
    return {key: np.array([float(row[key]) for row in rows]) for key in rows[0]}


def test_a_tracked_trajectory(tmp_path: Path) -> None:
    done = made(tmp_path, "sa_trace_vel100.txt", frame="free", noise=0.01)
    got = columns(tmp_path)
    # second reader: three numbers before a date, of lines that begin as the trajectory does
    text = (SHOP / "sa_trace_vel100.txt").read_text()
    seen = np.array([m.groups() for m in re.finditer(r"^Traj[^,]*,[^,]*,[^,]*,([^,]*),([^,]*),([^,]*),", text, re.M)])
    assert seen.shape == (13544, 3)
    np.testing.assert_allclose(np.column_stack([got[k] for k in "xyz"]), seen.astype(float), atol=1e-6)
    assert np.all(np.diff(got["time"]) > 0)
    seconds = [int(m[1]) * 60 + int(m[2]) for m in re.finditer(r"^Traj.* 16:(\d\d):(\d\d)\s*$", text, re.M)]
    offset = got["time"] - (np.array(seconds) - seconds[0])
    assert np.ptp(offset) < 1.0  # within the second of its date
    stray = next(f for f in done.report["findings"] if "other groups" in f["what"])
    assert stray["source_line"] == 13548 and "'pose1Anfahrt2::Satz1' (1 points)" in stray["what"]


def test_visits_of_one_pose_show_lost_motion(tmp_path: Path) -> None:
    """Repeatability as INDEX.md has it: 0.26 to 0.56 mm after arbitrary predecessors, 0.013 to 0.017 mm after one."""
    for name, low, high in (("sa_anfahrt_pose1.txt", 0.15, 0.6), ("sa_pose1.txt", 0.0, 0.02)):
        for point in "123":
            made(tmp_path, name, units="mm", frame="free", noise=0.01, index="4", point=point)
            got = columns(tmp_path)
            assert got["run"].tolist() == list(range(1, 11)) and set(got["index"]) == {4}
            place = np.column_stack([got[k] for k in "xyz"])
            far = np.linalg.norm(place - place.mean(axis=0), axis=1)
            assert low < far.mean() + 3 * far.std(ddof=1) < 3 * high
    with pytest.raises(DeviceError, match=r"'1' \(10 points\), '2' \(10 points\), '3' \(10 points\)"):
        made(tmp_path, "sa_pose1.txt", units="mm", frame="free", noise=0.01, index="4")


def test_a_milling_report(tmp_path: Path) -> None:
    names = {"PLN18": "-34 y", "PLN7": "-40 z", "PNT4": "-39 z", "PLN17": "-1.4 z"}
    lines = ["name,x,y,z,i,j,k"]
    for k, (name, place) in enumerate(names.items()):
        value, axis = place.split()
        lines.append(f"{name},{k},{value},0,0,-1,0" if axis == "y" else f"{name},{k},0,{value},0,0,1")
    (tmp_path / "nominals.csv").write_text("\n".join(lines))
    nominals = tmp_path / "nominals.csv"
    done = made(tmp_path, "pcdmis_MILLING.TXT", frame="workobject", noise=0.002, nominals=nominals)
    got = columns(tmp_path)
    assert got["deviation"].tolist() == [0.025, -0.116, 0.046, 0.042]  # DEV of the report, along the normals given
    left = next(f for f in done.report["findings"] if "are not known" in f["what"] or "is not known" in f["what"])
    assert left["count"] == 13 - 4
    dimensions = next(f for f in done.report["findings"] if "no points of a surface" in f["what"])
    text = (SHOP / "pcdmis_MILLING.TXT").read_text()
    assert dimensions["what"].startswith(f"{len(re.findall('UNITS=MM', text)) - 13} dimensions")


def test_a_small_report_asks_for_its_normal(tmp_path: Path) -> None:
    with pytest.raises(DeviceError, match=r"PLN4,\?,42\.5,\?,\?,\?,\?"):
        made(tmp_path, "pcdmis_302.TXT", frame="workobject", noise=0.002)


def test_qif_results_against_the_deviations_that_the_file_has(tmp_path: Path) -> None:
    done = made(tmp_path, "qif_sheetmetal_results_1.QIF", frame="workobject", noise=0.01)
    root = ET.parse(SHOP / "qif_sheetmetal_results_1.QIF").getroot()
    q = "{http://qifstandards.org/xsd/qif3}"
    told: dict[str, list[float]] = {}
    for e in root.iter(f"{q}PointProfileCharacteristicMeasurement"):
        key = e.findtext(f"{q}FeatureMeasurementIds/{q}Id") or ""
        told.setdefault(key, []).append(float(e.findtext(f"{q}Value") or 0))
    ids = [e.get("id") for e in root.iter() if e.tag.endswith("PointFeatureMeasurement")]
    got = columns(tmp_path)
    assert len(ids) == 17 == len(got["deviation"])
    for own, key in zip(got["deviation"], ids, strict=True):
        assert min(abs(own - v) for v in told[str(key)]) < 2e-6
    assert [f["what"] for f in done.report["findings"] if f["level"] == "note"] == [
        "4 measured features are no points of a surface, left out: 4 Circle"
    ]


def test_a_plate_of_drilled_holes_by_its_columns(tmp_path: Path) -> None:
    mapping = ["x=Nom X", "y=Nom Y", "z=0", "i=1", "j=0", "k=0", "deviation=Err X", "diameter=Meas D"]
    made(tmp_path, "cmm_sdss_D8131_1.txt", units="mm", frame="free", noise=0.005, columns=mapping)
    got = columns(tmp_path)
    table = np.loadtxt(SHOP / "cmm_sdss_D8131_1.txt", skiprows=4)
    np.testing.assert_array_equal(got["x"], table[:, 2])
    np.testing.assert_array_equal(got["deviation"], table[:, 4])
    np.testing.assert_array_equal(got["diameter"], table[:, 6])
