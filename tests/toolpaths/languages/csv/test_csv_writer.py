"""CSV: exactly the columns of the interface, every number where it belongs."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.oracles.sample_programs import changed, random_program, small
from toolpaths.files import read_back, write_program

HEADER = (
    "index,kind,x_mm,y_mm,z_mm,qw,qx,qy,qz,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,feed_mm_min,"
    "nominal_x_mm,nominal_y_mm,nominal_z_mm,nominal_qw,nominal_qx,nominal_qy,nominal_qz,"
    "fx_n,fy_n,fz_n,mx_nm,my_nm,mz_nm,dx_mm,dy_mm,dz_mm,source_line"
)


def rows(path) -> list[dict[str, str]]:
    with open(path, newline="") as stream:
        return list(csv.DictReader(stream))


def test_every_column(tmp_path):
    g = np.random.default_rng(5)
    p = random_program(200, 5)
    p = changed(
        p, nominal_position=g.normal(size=(200, 3)), nominal_rotation=Rotation.random(200, rng=g).as_matrix(),
        wrench=g.normal(size=(200, 6)) * 500, deflection=g.normal(size=(200, 3)) * 1e-4,
    )  # fmt: skip
    write_program(p, tmp_path / "p.csv")
    assert (tmp_path / "p.csv").read_text().splitlines()[0] == HEADER
    table = rows(tmp_path / "p.csv")

    def column(*names: str) -> np.ndarray:
        return np.array([[float(r[n] or "nan") for n in names] for r in table])

    def rotation(prefix: str) -> np.ndarray:
        q = column(*(f"{prefix}q{c}" for c in "wxyz"))
        return Rotation.from_quat(q, scalar_first=True).as_matrix()

    assert [r["index"] for r in table] == [str(i) for i in range(200)]
    assert [r["kind"] for r in table] == [["rapid", "cut"][k] for k in p.kind]
    assert [int(r["source_line"]) for r in table] == list(range(1, 201))
    np.testing.assert_allclose(column("x_mm", "y_mm", "z_mm"), p.position * 1e3, atol=0.51e-6)
    np.testing.assert_allclose(rotation(""), p.rotation, atol=1e-9)
    np.testing.assert_allclose(column(*(f"q{i}_deg" for i in range(1, 7))), np.degrees(p.joints), atol=1e-9)
    np.testing.assert_allclose(column("feed_mm_min")[:, 0], p.feed * 6e4, rtol=1e-5)
    nominal = column("nominal_x_mm", "nominal_y_mm", "nominal_z_mm")
    np.testing.assert_allclose(nominal, p.nominal_position * 1e3, atol=0.51e-6)
    np.testing.assert_allclose(rotation("nominal_"), p.nominal_rotation, atol=1e-9)
    np.testing.assert_allclose(column("fx_n", "fy_n", "fz_n", "mx_nm", "my_nm", "mz_nm"), p.wrench, atol=1e-6)
    np.testing.assert_allclose(column("dx_mm", "dy_mm", "dz_mm"), p.deflection * 1e3, atol=1e-7)


def test_what_is_not_known_stays_empty(tmp_path):
    write_program(small(), tmp_path / "p.csv")
    for row in rows(tmp_path / "p.csv"):
        assert all(row[c] == "" for c in ("fx_n", "mz_nm", "dx_mm", "dz_mm"))
        assert [row[c] for c in ("x_mm", "qx")] == [row[c] for c in ("nominal_x_mm", "nominal_qx")]
        assert (row["feed_mm_min"] == "") == (row["kind"] == "rapid")


@pytest.mark.parametrize("joints", [5, 7])
def test_other_numbers_of_joints(joints, tmp_path):
    p = random_program(20, 1)
    q = np.random.default_rng(1).normal(size=(20, joints))
    write_program(changed(p, joints=q), tmp_path / "p.csv")
    assert f"q{joints}_deg,feed_mm_min" in (tmp_path / "p.csv").read_text()
    np.testing.assert_allclose(read_back(tmp_path / "p.csv").joints, q, atol=1e-11)
