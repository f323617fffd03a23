"""Which postures collide, against python-fcl with the same meshes: 2,000 random postures."""

from __future__ import annotations

import sysconfig
from pathlib import Path

import numpy as np
import pytest
import trimesh

from compensator.cell.scene_tables import CollisionsTable
from compensator.scene.body import WORLD, Body
from compensator.scene.collider import Collider
from compensator.scene.link_bodies import link_bodies
from compensator.scene.pairs import pairs_of
from compensator.scene.shape import BoxShape
from stiffness.robot.load import load_robot
from tests.compensator.scene import mesh_arm
from toolpaths.frame import Frame

fcl_contacts = pytest.importorskip("tests.oracles.fcl_contacts", reason="python-fcl is not installed")
HOME = Frame.identity()
PLACE = Frame(np.eye(3), np.array([0.9, 0.0, 0.5]))
TABLE = Body("table", WORLD, BoxShape(np.array([0.8, 1.2, 0.05])), PLACE, role="scene")


def table() -> trimesh.Trimesh:
    return trimesh.creation.box(TABLE.shape.size, trimesh.transformations.translation_matrix(TABLE.placement.origin))


def collider(urdf: Path, packages: list[Path], base: str | None = None, around: tuple[Body, ...] = ()) -> Collider:
    robot = load_robot(str(urdf), base=base)
    links = link_bodies(robot, packages)
    assert links.missing == ""
    bodies = (*(b for b in links.bodies if not isinstance(b.shape, BoxShape)), *around)
    return Collider(robot, bodies, pairs_of(bodies, robot, CollisionsTable(), "cell.toml"))


def compared(ours: Collider, arm: fcl_contacts.FclArm, count: int) -> None:
    """Every posture, and every pair of the first 300."""
    robot, rng = ours.robot, np.random.default_rng(11)
    q = rng.uniform(np.maximum(robot.lower, -3.1), np.minimum(robot.upper, 3.1), (count, robot.n))
    theirs = [arm.touching(row) for row in q]
    hit = ours.collides(q, workobject=HOME)
    assert 0.1 < hit.mean() < 0.9  # both kinds are there
    assert hit.tolist() == [bool(t) for t in theirs]
    for pair in ours.pairs:
        alone = Collider(robot, ours.bodies, [pair]).collides(q[:300], workobject=HOME)
        names = frozenset((number(ours.bodies[pair.inner].name), number(ours.bodies[pair.outer].name)))
        expected = [names in {frozenset(map(number, t)) for t in named} for named in map(arm.numbered, theirs[:300])]
        assert alone.tolist() == expected, names


def number(name: str) -> str:
    return {"base": "0", "table": "around-0"}.get(name, name.removeprefix("link-").split(" ")[0])


def test_a_lumpy_arm_beside_a_table(tmp_path: Path) -> None:
    urdf = mesh_arm.write(tmp_path, scale=0.001)
    links = {f"link{k}": mesh for k, mesh in enumerate(mesh_arm.meshes())}
    compared(collider(urdf, [], around=(TABLE,)), fcl_contacts.FclArm(urdf, links, [table()]), 2000)


def test_a_real_arm_with_its_meshes(shared: Path) -> None:
    urdf = shared / "data" / "robots" / "ur10_robot.urdf"
    share = Path(sysconfig.get_paths()["purelib"]) / "cmeel.prefix" / "share"
    folder = share / "example-robot-data" / "robots" / "ur_description" / "meshes" / "ur10" / "collision"
    if not folder.is_dir():
        pytest.skip("no meshes of the UR10: pip install example-robot-data")
    files = {"base_link": "base", "shoulder_link": "shoulder", "upper_arm_link": "upperarm", "forearm_link": "forearm"}
    files |= {f"wrist_{k}_link": f"wrist{k}" for k in (1, 2, 3)}
    meshes = {link: trimesh.load_mesh(str(folder / f"{file}.stl")) for link, file in files.items()}
    ours = collider(urdf, [share], base="base_link")
    assert [len(b.shape.faces) for b in ours.bodies] == [len(m.faces) for m in meshes.values()]
    compared(ours, fcl_contacts.FclArm(urdf, meshes), 2000)
