"""docs/own-effect.md: the package on the page works, and packages that do not are refused by name.

Packages are put on the path with their metadata as an installer writes it; nothing is fetched.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from compensator.errors import CompensatorError
from compensator.tasks.effects import effect_lines
from stiffness.errors import ModelError
from stiffness.model.model import load_model
from stiffness.robot.load import load_robot
from stiffness.robot.robot import Robot

Floats = npt.NDArray[np.float64]
ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "own-effect.md"
GROUP = "compensator.effects"
STIFFNESS = np.array([4.0e4, 3.8e4, 2.1e4, 8.0e3, 7.0e3, 6.0e3])
SPRING = np.array([0.0, 12.0, 25.0, 0.0, 18.0, 30.0])
REST = np.array([0.0, -1.2, 0.9, 0.0, 0.4, -2.0])
TCP = np.array([0.03, -0.05, 0.21])
GRAVITY = np.array([0.0, 0.0, -9.80665])
Q = np.random.default_rng(4).uniform(-1.5, 1.5, (5, 6))
WRENCH = np.array([60.0, -45.0, -80.0, 4.0, -6.0, 3.0])

# what the program makes of the model file of the page, in a process that sees the package
PROBE = """
import json, sys
import numpy as np
from compensator.tasks.effects import catalogue, effect_lines
from stiffness.effects import BY_NAME, CATALOGUE
from stiffness.model.model import load_model, model_text
from stiffness.statics.predictor import Predictor
from stiffness.statics.tool import Tool
from stiffness.robot.load import load_robot
from stiffness.identification.unknowns import numbers_of, start_values, unknowns

given = json.loads(sys.argv[1])
model = load_model("stiffness.toml")
tool = Tool(np.eye(3), np.array(given["tcp"]))
q = np.array(given["q"])

def predictor(gravity):
    return Predictor(load_robot("ur10"), model.applied("tool")[0], model.values, tool, gravity=np.array(gravity))

free = predictor(np.zeros(3)).forward(q, np.zeros(6), np.zeros(0))
loaded = predictor(given["gravity"])
under = loaded.forward(q, np.array(given["wrench"]), np.zeros(0))
wrench = np.tile(given["wrench"], (len(q), 1))
wanted = loaded.nominal(q)
command = loaded.command(wanted, wrench, np.zeros((len(q), 0)), q)
back = loaded.forward(command.q, wrench, np.zeros(0))
own = BY_NAME["dress-pack"]
every = unknowns(model.effects, 6)
print(json.dumps({
    "last": CATALOGUE[-1].name,
    "packages": {one.effect.name: one.package for one in catalogue() if one.package},
    "lines": effect_lines("dress-pack"),
    "effects": [e.name for e in model.effects],
    "values": {k: v.tolist() for k, v in model.values["dress-pack"].items()},
    "text": model_text(model),
    "free": free.position.tolist(), "under": under.position.tolist(), "torque": under.torque.tolist(),
    "missed": float(np.abs(back.position - wanted.origin).max()),
    "corrected": float(np.abs(command.q - q).max()),
    "unknowns": [str(u) for u in every.free],
    "start": every.start(start_values(model.effects, 6)).tolist(),
    "sites": [[site.where[0], [str(u) for u in numbers_of(own, site, 6)]] for site in own.sites(6)],
    "neutral": {k: v.tolist() for k, v in own.neutral(6).items()},
}))
"""


def blocks() -> dict[str, str]:
    """The files of the page: blocks whose fence names one."""
    found = re.findall(r"^```\w+ (\S+)\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    assert len({name for name, _ in found}) == len(found)
    return dict(found)


def installed(folder: Path, package: str, points: dict[str, str]) -> None:
    """What an installer leaves beside the modules of a package."""
    info = folder / f"{package.replace('-', '_')}-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.0\n", encoding="utf-8")
    lines = [f"[{GROUP}]", *(f"{name} = {value}" for name, value in points.items())]
    (info / "entry_points.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")


def run(folder: Path, *arguments: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Python in a process of its own that sees the folder and this checkout."""
    env = {k: v for k, v in os.environ.items() if not k.startswith(("PYTEST", "PYTHON"))}
    env |= {"PYTHONPATH": os.pathsep.join((str(folder), str(ROOT))), "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, *arguments]
    return subprocess.run(command, cwd=cwd or folder, env=env, capture_output=True, text=True, timeout=300, check=False)


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The package of the page."""
    folder = tmp_path_factory.mktemp("own")
    for name, text in blocks().items():
        (folder / name).write_text(text, encoding="utf-8")
    project = tomllib.loads(blocks()["pyproject.toml"])["project"]
    installed(folder, project["name"], project["entry-points"][GROUP])
    return folder


@pytest.fixture(scope="module")
def found(package: Path) -> dict[str, Any]:
    given = {"q": Q.tolist(), "tcp": TCP.tolist(), "wrench": WRENCH.tolist(), "gravity": GRAVITY.tolist()}
    done = run(package, "-W", "error", "-c", PROBE, json.dumps(given))
    assert done.returncode == 0, done.stderr
    result: dict[str, Any] = json.loads(done.stdout)
    return result


def tcp(robot: Robot, q: Floats) -> Floats:
    return np.array([(pose := robot.pose(one))[:3, :3] @ TCP + pose[:3, 3] for one in q])


def test_the_catalogue_has_it_and_says_whose_it_is(found: dict[str, Any]) -> None:
    assert found["last"] == "dress-pack"
    assert found["packages"] == {"dress-pack": "dresspack-effect"}
    text = "\n".join(found["lines"])
    for words in ("package dresspack-effect", "every joint", "loads joints", "0 ... 10000", "N*m/rad", "hangs free"):
        assert words in text


def test_the_model_file_of_the_page_loads_and_comes_back(found: dict[str, Any], package: Path) -> None:
    assert found["effects"] == ["joint-stiffness", "dress-pack"]
    assert found["values"] == {"spring_nm_per_rad": SPRING.tolist(), "rest_rad": REST.tolist()}
    again = tomllib.loads(found["text"])["effects"]
    assert again == tomllib.loads((package / "stiffness.toml").read_text(encoding="utf-8"))["effects"]


def test_prediction_is_that_of_a_hand_calculation(found: dict[str, Any]) -> None:
    """Unloaded: K dq = -c (q + dq - r), so dq = -c (q - r) / (K + c)."""
    robot = load_robot("ur10")
    dq = -SPRING * (Q - REST) / (STIFFNESS + SPRING)
    wanted = tcp(robot, Q + dq)
    np.testing.assert_allclose(found["free"], wanted, atol=1e-10)
    assert np.linalg.norm(wanted - tcp(robot, Q), axis=1).min() > 1e-4


def test_under_weight_and_wrench_as_well(found: dict[str, Any]) -> None:
    """K dq = J^T W + g - c (q + dq - r), everything at q + dq, with Pinocchio's J and g."""
    robot = load_robot("ur10")
    dq, torque = np.zeros_like(Q), np.zeros_like(Q)
    for _ in range(40):
        for k, q in enumerate(Q + dq):
            jacobian, arm = robot.jacobian(q), robot.pose(q)[:3, :3] @ TCP
            about = np.concatenate([WRENCH[:3], WRENCH[3:] + np.cross(arm, WRENCH[:3])])
            torque[k] = jacobian.T @ about + robot.gravity_torque(q, tuple(GRAVITY)) - SPRING * (q - REST)
        dq = torque / STIFFNESS
    np.testing.assert_allclose(found["torque"], torque, atol=1e-6)
    np.testing.assert_allclose(found["under"], tcp(robot, Q + dq), atol=1e-9)


def test_compensation_cancels_it(found: dict[str, Any]) -> None:
    assert found["missed"] < 1e-9
    assert found["corrected"] > 1e-3


def test_identification_has_its_numbers(found: dict[str, Any]) -> None:
    keys = ("spring_nm_per_rad", "rest_rad")
    own = [u for u in found["unknowns"] if u.startswith("dress-pack")]
    assert own == [f"dress-pack.{key}[{k}]" for key in keys for k in range(1, 7)]
    assert len(found["unknowns"]) == 6 + len(own)
    assert found["start"][6:] == [10.0] * 6 + [0.0] * 6
    assert found["sites"] == [[f"joint-{k}", [f"dress-pack.{key}[{k}]" for key in keys]] for k in range(1, 7)]
    assert found["neutral"] == {"spring_nm_per_rad": [0.0] * 6, "rest_rad": [0.0] * 6}


def test_the_checks_of_the_page_pass_and_can_fail(package: Path, tmp_path: Path) -> None:
    command = ("-m", "pytest", "-q", "-W", "error", "-p", "no:cacheprovider", "test_dresspack.py")
    good = run(package, *command)
    assert good.returncode == 0 and "5 passed" in good.stdout, good.stdout
    for name in ("test_dresspack.py", "dresspack.py"):
        text = (package / name).read_text(encoding="utf-8").replace('return -p["spring', 'return p["spring')
        (tmp_path / name).write_text(text, encoding="utf-8")
    installed(tmp_path, "dresspack-effect", {"dress-pack": "dresspack:EFFECT"})
    bad = run(tmp_path, *command)
    assert bad.returncode == 1 and "2 failed, 3 passed" in bad.stdout, bad.stdout


def test_the_contract_suite_runs_on_it(package: Path) -> None:
    page = PAGE.read_text(encoding="utf-8")
    ((suite, which),) = re.findall(r"^    python -m pytest -p dresspack_oracle (\S+) -k \"(.*)\"$", page, re.MULTILINE)
    options = ("-q", "-p", "no:cacheprovider", "-p", "dresspack_oracle")
    done = run(package, "-m", "pytest", *options, suite, "-k", which, cwd=ROOT)
    passed = re.search(r"^(\d+) passed", done.stdout, re.MULTILINE)
    assert done.returncode == 0 and passed and int(passed[1]) > 20, done.stdout


def test_without_the_package_the_model_is_refused_by_name(package: Path) -> None:
    with pytest.raises(ModelError, match=r"stiffness\.toml: unknown effect dress-pack"):
        load_model(package / "stiffness.toml")
    with pytest.raises(CompensatorError, match=r"'dress-pack'.*own-effect\.md"):
        effect_lines("dress-pack")


def test_the_module_may_be_imported_first(package: Path) -> None:
    done = run(package, "-c", "import dresspack; from stiffness.effects import BY_NAME; print(BY_NAME['dress-pack'])")
    assert (done.returncode, done.stdout.strip()) == (0, "Effect(dress-pack)")


BROKEN = {
    "raises": ("raise OSError('no licence found')", "cannot be loaded: OSError('no licence found')"),
    "syntax": ("EFFECT = (", "cannot be loaded: SyntaxError"),
    "empty": ("", "cannot be loaded: AttributeError"),
    "not an effect": ("EFFECT = 'dress-pack'", "is a str; expected a stiffness.effects.effect.Effect"),
    "class": ("from stiffness.effects.effect import Effect as EFFECT", "is a type; expected"),
    "taken": (
        "from dataclasses import replace\nfrom stiffness.effects import payload\n"
        "EFFECT = replace(payload.EFFECT, name='backlash')",
        "is named 'backlash', as another effect already is",
    ),
    "base": (
        "from dataclasses import replace\nfrom stiffness.effects import joint_stiffness\n"
        "EFFECT = replace(joint_stiffness.EFFECT, name='own-stiffness')",
        "declares is_base: there is one base model",
    ),
}


@pytest.mark.parametrize("case", BROKEN)
def test_a_broken_package_is_refused_with_its_name(case: str, tmp_path: Path) -> None:
    text, problem = BROKEN[case]
    (tmp_path / "broken.py").write_text(text + "\n", encoding="utf-8")
    installed(tmp_path, "broken-effect", {"bad": "broken:EFFECT"})
    done = run(tmp_path, "-m", "compensator.cli", "robots")
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("compensator: effect 'broken:EFFECT' of package broken-effect ")
    assert problem in done.stderr and done.stderr.count("\n") == 1


def test_help_does_not_need_the_catalogue(tmp_path: Path) -> None:
    (tmp_path / "broken.py").write_text("raise OSError\n", encoding="utf-8")
    installed(tmp_path, "broken-effect", {"bad": "broken:EFFECT"})
    done = run(tmp_path, "-m", "compensator.cli", "--help")
    assert (done.returncode, done.stderr) == (0, "") and "compensate" in done.stdout
