"""What `compensator effects` says of the catalogue."""

from __future__ import annotations

import re
from dataclasses import replace
from importlib.metadata import EntryPoint

import pytest

from compensator.errors import CompensatorError
from compensator.tasks import effects as tasks_effects
from compensator.tasks.effects import WIDTH, catalogue, effect_lines, effects_lines
from stiffness.effects import BUILT_IN, BY_NAME
from stiffness.effects.effect import Effect

every_effect = pytest.mark.parametrize("effect", BUILT_IN, ids=lambda e: e.name)


def cells(line: str) -> list[str]:
    """Columns stand two blanks apart at least."""
    return re.split(r" {2,}", line.strip())


def test_the_list_has_every_effect_once_with_its_cause() -> None:
    head, *lines = effects_lines()
    assert cells(head) == ["name", "scope", "sits in"]
    rows = [cells(line) for line in lines if not line.startswith(" ")]
    assert [row[:2] for row in rows] == [[e.name, e.scope] for e in BUILT_IN]
    text = re.sub(r"\s+", " ", " ".join(lines))
    assert all(f"{row[-1]} {e.cause}" in text for row, e in zip(rows, BUILT_IN, strict=True))
    assert max(map(len, lines)) <= WIDTH
    assert all(one.package == "" for one in catalogue())


@pytest.mark.parametrize(
    ("name", "where"),
    [
        ("joint-stiffness", "every joint"),
        ("link-compliance", "every link but the last"),
        ("joint-coupling", "every pair of joints"),
        ("thermal-drift", "base, every link and tool; every joint"),
        ("gravity-compensator", "joint-2"),
        ("payload", "tool"),
        ("base-compliance", "base"),
        ("tracker-drift", "tracker"),
        ("force-sensor-bias", "force-sensor"),
    ],
)
def test_where_an_effect_sits(name: str, where: str) -> None:
    assert [one.where for one in catalogue() if one.effect.name == name] == [where]
    assert f"sits in       {where}" in effect_lines(name)


@every_effect
def test_one_effect_shows_every_parameter(effect: Effect) -> None:
    lines = effect_lines(effect.name)
    assert lines[0] == effect.name and lines[1] == effect.cause
    assert any(line.startswith("scope ") and f" {effect.scope}: " in line for line in lines)
    assert f"[effects.{effect.name}]" in "\n".join(lines)
    (head,) = [k for k, line in enumerate(lines) if line.startswith("parameter")]
    assert [cells(line)[0] for line in lines[head + 1 :]] == [p.name for p in effect.parameters]
    for line, p in zip(lines[head + 1 :], effect.parameters, strict=True):
        _, unit, _, bounds, default, meaning = cells(line)
        assert (unit, meaning) == (p.unit, p.meaning)
        assert [float(b) for b in bounds.split(" ... ")] == pytest.approx([p.low, p.high], rel=1e-5)
        assert default == "must be given" if p.default is None else float(default) == pytest.approx(p.default)


def test_numbers_and_deeds_in_words() -> None:
    text = "\n".join(effect_lines("thermal-drift"))
    assert re.search(r"expansion_per_k +1/K +base, one per link, tool ", text)
    assert re.search(r"zero_rad_per_k +rad/K +one per joint ", text)
    assert "deflects joints, moves the places that it sits in" in text
    assert "one per pair of joints" in "\n".join(effect_lines("joint-coupling"))
    assert re.search(r"coupling +\S+, \S+, \S+ +15 ", "\n".join(effect_lines("tool-compliance")))
    assert re.search(r"mass_kg +kg +one ", "\n".join(effect_lines("payload")))
    assert "remembers the way it came (N*m)" in "\n".join(effect_lines("joint-friction"))
    assert "never acts on a planned path" in "\n".join(effect_lines("tracker-drift"))


@every_effect
def test_every_effect_does_something(effect: Effect) -> None:
    (line,) = [line for line in effect_lines(effect.name) if line.startswith("what it does")]
    assert len(cells(line)) == 2


def test_an_unknown_name_is_refused() -> None:
    with pytest.raises(CompensatorError, match=r"'backlsh'; did you mean 'backlash'\? `compensator effects` lists all"):
        effect_lines("backlsh")
    with pytest.raises(CompensatorError, match=r"'zzz'; `compensator effects`"):
        effect_lines("zzz")


def test_a_foreign_effect_is_marked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without metadata of its own it is foreign all the same; tests/test_own_effect.py has real packages."""
    own = replace(BY_NAME["payload"], name="own", cause="word " * 40)
    entry = EntryPoint("own", "somewhere:EFFECT", tasks_effects.GROUP)
    monkeypatch.setattr(EntryPoint, "load", lambda self: own)
    monkeypatch.setattr(tasks_effects, "entry_points", lambda group: [entry])
    monkeypatch.setattr(tasks_effects, "CATALOGUE", (*BUILT_IN, own))
    head, *lines = effects_lines()
    assert cells(head) == ["name", "scope", "sits in", "from"]
    assert cells(lines[-3]) == ["own", "tool", "tool", "package ?"]
    assert [line.split() for line in lines[-2:]] == [["word"] * 21, ["word"] * 19]
    assert not any("package" in line for line in lines[: 2 * len(BUILT_IN)])
