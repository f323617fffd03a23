"""Causes in no catalogue, as a linear model has them: what the plant's fixture and servos do lies in their columns."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from compensator.tasks.measurements import in_terms_of, load_measurement
from stiffness.diagnosis.added_effects import ModelFits
from stiffness.diagnosis.beyond_catalogue import beyond_catalogue
from stiffness.diagnosis.search import Search
from stiffness.identification.evaluate import shown_effects
from stiffness.identification.fit import Fit
from stiffness.model.model import load_model
from stiffness.numerics.least_squares import ROUGH
from tests.traces_report.case import _programs, _trace, _worn, at_hand
from tests.traces_report.causes import Kind, scenarios


def searched(keep: Path, name: str, kind: Kind) -> tuple[Search, Fit]:
    """The search of a scenario's trace, and the model's own numbers fitted."""
    scenario = next(s for s in scenarios() if (s.name, s.kind) == (name, kind))
    (keep / kind).mkdir(exist_ok=True)
    program, _ = _programs(keep / kind, kind)
    model = load_model(at_hand(keep, "healthy"))
    session = in_terms_of(load_measurement(_trace(program, _worn(program, scenario, 3.0)[0], 1)), model)
    effects = shown_effects(model, session)
    used = [np.ones(len(session.samples), dtype=bool)]
    fits = ModelFits.of((session,), effects, {e.name: model.values[e.name] for e in effects}, used)
    fits = replace(fits, ending=ROUGH)
    return Search(fits, (), lambda text: None), fits.fit([])


@pytest.mark.parametrize(
    ("name", "kind", "words"),
    [
        ("unknown servo lag joint-2", "ballbar", "the speed of joint 2"),
        ("unknown fixture edge", "surface", "a fixture that gives way"),
    ],
)
def test_a_cause_in_no_catalogue_is_known_by_itself(tmp_path: Path, name: str, kind: Kind, words: str) -> None:
    search, base = searched(tmp_path, name, kind)
    found = beyond_catalogue(search, base, base)
    assert found is not None and words in found.words


@pytest.mark.parametrize(("name", "kind"), [("backlash joint-2", "ballbar"), ("clean 1", "surface")])
def test_a_cause_of_the_catalogue_and_noise_are_none(tmp_path: Path, name: str, kind: Kind) -> None:
    search, base = searched(tmp_path, name, kind)
    linear = search.linearisation.at(base, [])
    fit, _ = search.run(linear, search.beginnings(linear))
    assert beyond_catalogue(search, base, fit) is None
