"""Small runs that the tests of reports look at: each takes some seconds, so each is made once."""

from __future__ import annotations

from pathlib import Path

import pytest

from compensator.report.json.text import Report
from compensator.solve.compensation import Compensation
from compensator.tasks.compensate import compensate_file, preview_file
from stiffness.identification.fit import Fit
from stiffness.identify import identify
from tests.compensator.report.small_path import prepared
from tests.plant.lab import Form
from tests.stiffness.bench_lab import Lab

Run = tuple[Compensation, Report]


@pytest.fixture(scope="session")
def circle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a path, its cell and its model."""
    return prepared(tmp_path_factory.mktemp("circle"))


@pytest.fixture(scope="session")
def run(circle: Path) -> Run:
    """The path compensated."""
    done = compensate_file(circle / "circle.csv", circle / "cell.toml", circle / "out.csv")
    return done.result, done.report


@pytest.fixture(scope="session")
def preview(circle: Path) -> Run:
    """The path not compensated."""
    done = preview_file(circle / "circle.csv", circle / "cell.toml")
    return done.result, done.report


@pytest.fixture(scope="session")
def fitted(tmp_path_factory: pytest.TempPathFactory) -> tuple[Fit, list[int]]:
    """A fit of joint stiffness, and the lines of samples.csv that are wrong."""
    session, wrong = Lab().session(tmp_path_factory.mktemp("fit"), 11, setups=12, form=Form(wrong=2))
    return identify([session], ["joint-stiffness"]), wrong
