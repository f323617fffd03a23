"""Readers of devices: the numbers of small files, and every mistake by its line."""

from __future__ import annotations

import re

import numpy as np
import pytest

from compensator.devices import column_file, pcdmis, probe_results, qif, spatial_analyzer
from compensator.devices.readings import BALLBAR, POSITIONS, SURFACE, DeviceFile, DeviceReadings
from compensator.errors import DeviceError
from tests.compensator.devices.device_samples import BAR, PCDMIS, PROBE, QIF, SA, SA_BARE, TABLE


def words(given: DeviceReadings) -> str:
    return "\n".join(map(str, given.findings))


def test_spatial_analyzer() -> None:
    given = spatial_analyzer.read(DeviceFile("f", SA))
    assert (given.kind, given.to_mm, given.frame) == (POSITIONS, 1.0, "A::WORLD")
    assert given.group == ("Run::Fast",) * 3 and given.name == ("0", "1", "2")
    assert given.measured.tolist() == [[100, -200.5, 30.25], [101, -200.5, 30.25], [102, -200.5, 30.25]]
    assert given.line.tolist() == [4, 5, 6]
    # two points of the first second, one of the next: spread within theirs
    assert np.diff(given.time).tolist() == [0.5, 0.75]
    assert "1 to 2 points have the same" in words(given)


def test_spatial_analyzer_without_its_header() -> None:
    given = spatial_analyzer.read(DeviceFile("f", SA_BARE))
    assert given.to_mm is None and given.frame == "" and not np.isfinite(given.time).any()
    assert given.name == ("1", "2", "1", "2")
    assert given.measured[1].tolist() == [2331.349757, -2328.039341, -547.862927]


def test_spatial_analyzer_times_with_a_fraction_stay_as_they_are() -> None:
    text = "".join(f"A,  B,  {k},  1.000000,  2.000000,  3.000000,  02/12/25 16:56:08.{k}\n" for k in range(3))
    given = spatial_analyzer.read(DeviceFile("f", text))
    assert np.diff(given.time) == pytest.approx([0.1, 0.1]) and not given.findings


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ("-200.500000,  30.250000,  02/12/25 16:56:09", "-200.5o0,  30.250000,  02/12/25 16:56:09",
         r"line 6: y is '-200\.5o0', expected a number"),
        (",  02/12/25 16:56:09", "", r"line 6: no date and time, other points have one"),
        ("(mm)", "(furlong)", r"line 3: unit 'furlong', expected mm, inch, m"),
        ("CARTESIAN", "SPHERICAL", r"line 3: axes are SPHERICAL, expected CARTESIAN"),
        ("Run,  Fast,  2,", "2,", ""),
        ("Run,  Fast,  2,  102.000000,", "", r"line 6: 2 values .* expected \[collection,\]"),
        ("02/12/25 16:56:09", "42/13/25 16:56:09", r"line 6: date '42/13/25 16:56:09'"),
    ],
)  # fmt: skip
def test_spatial_analyzer_refusals(old: str, new: str, why: str) -> None:
    assert old in SA
    if not why:
        assert spatial_analyzer.read(DeviceFile("f", SA.replace(old, new))).group[-1] == ""
        return
    with pytest.raises(DeviceError, match=f"f: {why}"):
        spatial_analyzer.read(DeviceFile("f", SA.replace(old, new)))


def test_pcdmis() -> None:
    given = pcdmis.read(DeviceFile("f", PCDMIS))
    assert (given.kind, given.to_mm, given.name) == (SURFACE, 1.0, ("PLN4", "PNT1", "PNT2"))
    np.testing.assert_array_equal(given.nominal[0], [np.nan, 42.5, np.nan])
    np.testing.assert_array_equal(given.measured[0], [np.nan, 42.52, np.nan])
    assert given.nominal[1].tolist() == [10, 5, -7]  # a page ends within its table
    assert given.measured[1].tolist() == [10.03, 5.04, -7]
    assert (given.deviation[2], given.low[2], given.high[2]) == (-0.061, -0.05, 0.1)
    assert given.line.tolist() == [3, 9, 18]
    assert "2 dimensions are no points of a surface, left out: 1 FLATNESS, 1 POSITION OF CIRCLE" in words(given)


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ("42.520      0.020", "42.520     -0.020", r"line 5: axis Y of PLN4: DEV -0\.02, but MEAS - NOMINAL is 0\.02"),
        ("     42.520      0.020      0.000 ----#----", "", r"line 5: axis Y of PLN4: DEV 0\.2, but MEAS"),
        ("      0.200      0.200     42.520      0.020      0.000", "", r"line 5: .* has 1 numbers, expected at least"),
        ("PLN4  UNITS=MM", "PLN4  UNITS=ELL", r"line 3: UNITS=ELL, expected MM or IN"),
        ("PLN4  UNITS=MM", "PLN4  UNITS=IN", r"points in several units: IN \(line 3\), MM \(line 9\)"),
    ],
)
def test_pcdmis_refusals(old: str, new: str, why: str) -> None:
    assert old in PCDMIS
    with pytest.raises(DeviceError, match=f"f: {why}"):
        pcdmis.read(DeviceFile("f", PCDMIS.replace(old, new)))


def test_pcdmis_without_a_point() -> None:
    text = re.sub(r"LOCATION OF P\w+", "FLATNESS OF PLANE", PCDMIS)
    with pytest.raises(DeviceError, match=r"no location of a point or plane in it \(4 FLATNESS, 1 POSITION OF"):
        pcdmis.read(DeviceFile("f", text))


def test_qif() -> None:
    given = qif.read(DeviceFile("f", QIF))
    assert (given.kind, given.to_mm, given.name) == (SURFACE, 25.4, ("B", "A"))  # in the order of the measurement
    assert given.nominal.tolist() == [[4, 5, 6], [1, 2, 3]]
    assert given.normal.tolist() == [[0.6, 0.8, 0], [0, 0, 1]]
    assert given.measured.tolist() == [[4.01, 5.02, 6.5], [1, 2, 2.999]]
    assert given.line.tolist() == [19, 21]
    assert "1 points of the plan have no measurement" in words(given) and "left out: 1 Circle" in words(given)
    assert "is not the value" not in words(given)
    other = qif.read(DeviceFile("f", QIF.replace("<Value>0.022<", "<Value>0.05<")))
    assert "f:19: the deviation along the normal is not the value of its point profile" in words(other)


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ("<FeatureItemId>12<", "<FeatureItemId>99<", r"line 19: PointFeatureMeasurement FeatureItemId is id '99'"),
        ("4.01 5.02 6.5", "4.01 5.02", r"line 20: Location of PointFeatureMeasurement is '4\.01 5\.02', expected"),
        ("0.6 0.8 0<", "0.6 O.8 0<", r"line 8: Normal of PointFeatureNominal is 'O\.8', expected a number"),
        ("</QIFDocument>", "", r"line \d+: is not complete XML"),
        ("PointFeatureMeasurement", "ArcFeatureMeasurement", r"no measured point .* \(2 Arc, 1 Circle\)"),
        ("0.0254", "25.4", r"line 4: a unit of length of 25\.4 m"),
        ("<QIFDocument", "<!DOCTYPE x><QIFDocument", r"has a document type"),
    ],
)
def test_qif_refusals(old: str, new: str, why: str) -> None:
    assert old in QIF
    with pytest.raises(DeviceError, match=f"f: {why}"):
        qif.read(DeviceFile("f", QIF.replace(old, new)))


def test_qif_in_another_encoding_and_deep_in_itself() -> None:
    other = QIF.replace("UTF-8", "ISO-8859-1").replace(">B<", ">Bö<")  # as text it is read already
    assert qif.read(DeviceFile("f", other)).name == ("Bö", "A")
    deep = QIF.replace("<Features>", f"{'<Note>' * 5000}{'</Note>' * 5000}<Features>")
    assert len(qif.read(DeviceFile("f", deep))) == 2


def test_qif_without_units_asks() -> None:
    text = re.sub(r"<FileUnits>.*</FileUnits>", "", QIF, flags=re.S)
    assert qif.read(DeviceFile("f", text)).to_mm is None
    bare = re.sub(r"<UnitConversion>.*</UnitConversion>", "", QIF)
    assert qif.read(DeviceFile("f", bare)).to_mm == 25.4


def test_probe_results() -> None:
    given = probe_results.read(DeviceFile("f", PROBE))
    assert (given.kind, given.to_mm, given.name) == (SURFACE, None, ("N1 Sleeve", "N2 Sleeve"))
    # ball centre less nominal, along the normal, less the radius: by hand
    by_hand = (-0.4187 + 0.4394) * 0.63893 + (0.5040 - 0.5291) * -0.76927 - 0.0345
    assert given.deviation == pytest.approx([by_hand, 0.7 - 0.5 - 0.1], abs=1e-6)
    assert given.line.tolist() == [12, 14]
    told = words(given)
    assert "2 sets: the last counts (START at line 8); 1 points of those at line 2 do not" in told
    assert "f:16: G800 without a G801" in told and "f:14: O: the surface was offset" in told


def test_probe_results_as_the_post_of_autodesk_makes_a_perfect_part() -> None:
    """Its mock results: measured = nominal + normal * radius of the tip."""
    rng = np.random.default_rng(3)
    nominal, normal = rng.normal(size=(5, 3)) * 50, rng.normal(size=(5, 3))
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    text = "START\n"
    for k, (p, n) in enumerate(zip(nominal, normal, strict=True), 1):
        text += f"G800 N{k} X{p[0]:+.4f} Y{p[1]:+.4f} Z{p[2]:+.4f} I{n[0]:.6f} J{n[1]:.6f} K{n[2]:.6f}\n"
        c = p + 3.0 * n
        text += f"G801 N{k} X{c[0]:+.4f} Y{c[1]:+.4f} Z{c[2]:+.4f} R+3.0000\n"
    given = probe_results.read(DeviceFile("f", text + "END\n"))
    assert np.abs(given.deviation).max() < 2e-4 and given.nominal == pytest.approx(nominal, abs=1e-4)


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ("G801 N1 X-.4187", "G801 N7 X-.4187", r"line 13: G801 N7 without its G800"),
        ("Y.5040 Z-.0753 R.0345", "Y.5040 Z-.0753", r"line 13: 'G801 N1 .*' lacks R: expected N, X, Y, Z, R"),
        ("X-.4187", "X-.41.87", r"line 13: X of G801 is '-\.41\.87', expected a number"),
        ("G800 N2 X1", "G330 N2 A90. B0. C0. X0 Y0 Z0\nG800 N2 X1", r"line 15: G330 .* several work planes"),
    ],
)
def test_probe_results_refusals(old: str, new: str, why: str) -> None:
    assert old in PROBE
    with pytest.raises(DeviceError, match=f"f: {why}"):
        probe_results.read(DeviceFile("f", PROBE.replace(old, new)))


def test_probe_results_in_a_turned_plane_and_an_empty_last_set() -> None:
    turned = probe_results.read(DeviceFile("f", PROBE.replace("G330 N1 A0.", "G330 N1 A30.")))
    assert "G330 30, 0, 0" in turned.needs_free_frame
    with pytest.raises(DeviceError, match=r"f: line 18: the last START has no touch after it"):
        probe_results.read(DeviceFile("f", PROBE + "START\n"))


def test_columns() -> None:
    given = column_file.read(DeviceFile("f", TABLE))
    assert (given.kind, given.to_mm) == (POSITIONS, 1.0) and given.index.tolist() == [0, 2.5]
    assert given.measured.tolist() == [[1, 2, 3], [4, 5, 6]] and given.line.tolist() == [2, 3]
    assert "left out: spindle load. --column NAME=HEADING keeps one" in words(given)


def test_columns_of_a_ball_bar_with_decimal_commas() -> None:
    given = column_file.read(DeviceFile("f", BAR))
    assert (given.kind, given.to_mm) == (BALLBAR, 1.0)
    assert given.radius == pytest.approx([150.0015, 150.003]) and given.index.tolist() == [3, 4]


def test_columns_by_the_command_line() -> None:
    text = "Plate: 7\n\n  Nom X    Nom Y    Err X   Load\n  1.5  2  -0.25  7\n  3  4  .5  8\n"
    mapping = {"x": "Nom X", "y": "Nom Y", "z": "0", "i": "1", "j": "0", "k": "0", "deviation": "Err X", "load": "Load"}
    given = column_file.read(DeviceFile("f", text, mapping))
    assert (given.kind, given.to_mm, given.line.tolist()) == (SURFACE, None, [4, 5])
    assert given.nominal.tolist() == [[1.5, 2, 0], [3, 4, 0]] and given.deviation.tolist() == [-0.25, 0.5]
    assert given.normal.tolist() == [[1, 0, 0]] * 2 and given.columns["load"].tolist() == [7, 8]


@pytest.mark.parametrize(
    ("text", "mapping", "why"),
    [
        ("x,y,z\n1,2,3\n1,2\n", {}, r"f: line 3: 2 values, the heading at line 1 has 3"),
        ("x,y,z\n1,2,a\n", {}, r"f: line 2: column 'z' \(z\) is 'a', expected a number"),
        ("x,y,z\n", {}, r"f: no row below the heading at line 1"),
        ("x_mm,y_mm,z\n1,2,3\n", {}, r"f: unit of column z: expected one of mm, inch"),
        ("x,y,z,i\n1,2,3,4\n", {}, r"f: surface points lack j, k, deviation \(or mx, my, mz\)"),
        ("x,y,z\n1,2,3\n", {"x": "X"}, r"f: no heading line with X in its first 60 lines"),
        ("X,X,z\n1,2,3\n", {"x": "X", "y": "z", "z": "z"}, r"f: line 1: column 'X' stands twice"),
    ],
)
def test_columns_refusals(text: str, mapping: dict[str, str], why: str) -> None:
    with pytest.raises(DeviceError, match=why):
        column_file.read(DeviceFile("f", text, mapping))
