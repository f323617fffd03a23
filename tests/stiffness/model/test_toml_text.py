"""How a model file is laid out: arrays in rows, whatever the number of numbers, and nothing lost."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import tomli_w

from stiffness.effects import BY_NAME
from stiffness.model.correlations import Correlations
from stiffness.model.model import ComplianceModel, load_model, model_text, save_model

KINEMATIC = ("zero_rad", "x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")


def test_arrays_stand_in_rows_and_read_back_to_the_last_bit(tmp_path: Path) -> None:
    """Of 54 numbers and their correlations a file of 3,300 lines was made."""
    rng = np.random.default_rng(2)
    names = [f"kinematic-offset.{p}[{k}]" for p in KINEMATIC for k in range(1, 7)]
    root = rng.normal(size=(len(names), 60))
    values = {"joint-stiffness": {"k_nm_per_rad": 10 ** rng.uniform(4, 6, 6)}}
    values["kinematic-offset"] = {p: 1e-3 * rng.normal(size=6) for p in KINEMATIC}
    values["joint-angle-error"] = {**BY_NAME["joint-angle-error"].neutral(6), "error_rad": 1e-4 * rng.normal(size=720)}
    model = ComplianceModel(
        source="",
        robot="ur10",
        gravity="uncompensated",
        reference_temperature=20.0,
        base=None,
        tip=None,
        values=values,
        sd={"joint-stiffness": {"k_nm_per_rad": np.full(6, 0.1)}},
        identified={"joint-stiffness": np.array([True] * 5 + [False])},
        provenance={
            "source": ["a, b.toml", 'c "d".toml'], "empty": [], "note": "two\nlines",
            "rows": [{"a b": 1}, {"c": [2.5]}],
            "diagnosis": {"verdict": "explained", "added": ["x"] * 40}, "more": {},
        },
        correlations=Correlations.of(tuple(names), root @ root.T),
    )  # fmt: skip
    text = model_text(model)
    lines = text.splitlines()
    assert max(map(len, lines)) <= 120
    assert len(lines) < 42 * 7 + 720 / 4 + 60
    path = tmp_path / "rows.toml"
    save_model(model, path)
    back = load_model(path)
    for effect, parameters in values.items():
        for name, numbers in parameters.items():
            assert back.values[effect][name].tobytes() == numbers.tobytes()
    assert back.provenance == model.provenance
    assert back.identified["joint-stiffness"].tolist() == [True] * 5 + [False]
    assert back.correlations is not None and model.correlations is not None
    assert back.correlations.names == tuple(names)
    assert back.correlations.matrix.tobytes() == model.correlations.matrix.tobytes()
    # as another writer of TOML puts it, a number to a line: files of before load the same
    old = tmp_path / "old.toml"
    old.write_text(tomli_w.dumps(tomllib.loads(text)), encoding="utf-8")
    assert len(old.read_text(encoding="utf-8").splitlines()) > 2000
    assert model_text(load_model(old)) == text
