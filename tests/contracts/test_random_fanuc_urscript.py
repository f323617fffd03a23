"""Random Fanuc and URScript programs in place: what is read again is what was commanded, nothing else has changed."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.oracles.commanded import commanded
from tests.oracles.tp_programs import POSE
from toolpaths.languages.fanuc import filter as fanuc_filter
from toolpaths.languages.fanuc import reader as fanuc
from toolpaths.languages.urscript import filter as urscript_filter
from toolpaths.languages.urscript import reader as urscript
from toolpaths.toolpath import CUT

CHORD = 1e-3
FILTERS = {"ls": (fanuc, fanuc_filter), "script": (urscript, urscript_filter)}


def angles(g: np.random.Generator, n: int) -> np.ndarray:
    """W, P, R deg: a third in or next to gimbal lock, some half turns."""
    out = g.uniform(-180, 180, (n, 3)) * [1.0, 0.5, 1.0]
    out[::3, 1] = g.choice([-90.0, 90.0], len(out[::3])) * (1.0 - g.choice([0.0, 1e-6, 1e-3], len(out[::3])))
    out[1::5] = g.choice([0.0, 90.0, 180.0], (len(out[1::5]), 3)) * [1.0, 0.5, 1.0]
    return out


def _turns(wpr: np.ndarray) -> Rotation:
    return Rotation.from_euler("xyz", wpr, degrees=True)


def listing(g: np.random.Generator) -> str:
    n, eol = 12, g.choice(["\n", "\r\n"])
    at, turned = np.cumsum(g.uniform(-80, 80, (n, 3)), axis=0), angles(g, n)
    config = [f"{g.choice(['N', 'F'])} U T, 0, {g.integers(-1, 2)}, {g.integers(-1, 2)}" for _ in range(n)]
    records = "".join(
        POSE.format(n=k + 1, uf=1, ut=2, config=c, x=x, y=y, z=z, w=w, p=p, r=r, more="")
        for k, (c, (x, y, z), (w, p, r)) in enumerate(zip(config, at, turned, strict=True))
    )
    lines = ["J P[1] 20% FINE"]
    for k in range(2, n + 1):
        word = g.choice(["L", "L", "L", "C", "J"]) if k < n else "L"
        tail = g.choice(["20mm/sec CNT50", "7cm/min FINE ACC50", "2.8inch/min CNT100 TB .10sec,DO[1]=ON"])
        if word == "C":
            lines.append(f"L P[{k - 1}] 30mm/sec CNT10")
            lines.append(f"C P[{k}]{eol}    :  P[{k + 1}] 20mm/sec FINE")
        else:
            lines.append(f"{word} P[{k}] " + ("10% CNT5" if word == "J" else tail))
        if g.random() < 0.3:
            lines.append(str(g.choice(["  DO[1]=ON", "  !a remark", "  WAIT .50(sec)", "  R[1]=R[1]+1"])))
        if g.random() < 0.3:
            lines.append(f"L P[{g.integers(1, k)}] 9mm/sec FINE")
    body = "".join(f"{i:4d}:{line} ;{eol}" for i, line in enumerate(lines, 1))
    return f"/PROG  RANDOM{eol}/ATTR{eol}/MN{eol}{body}/POS{eol}{records.replace(chr(10), eol)}/END{eol}"


def script(g: np.random.Generator) -> str:
    n, eol = 12, g.choice(["\n", "\r\n"])
    at, turned = np.cumsum(g.uniform(-0.08, 0.08, (n, 3)), axis=0), _turns(angles(g, n)).as_rotvec()
    digits = int(g.integers(4, 9))
    poses = ["p[" + ", ".join(f"{v:.{digits}f}" for v in (*a, *b)) + "]" for a, b in zip(at, turned, strict=True)]
    lines = ["f = p[0.5, -0.1, 0.2, 0.3, -0.2, 1.0]", *(f"wp_{k} = {p}" for k, p in enumerate(poses[:4]))]
    lines += [f"movej({poses[0]}, a=1.4, v=0.5)"]
    for k in range(1, n - 1):
        to = str(g.choice([poses[k], f"wp_{g.integers(0, 4)}", f"pose_trans(f, {poses[k]})"]))
        word = g.choice(["movel", "movel", "movep", "movec", "movej"])
        if word == "movec":
            lines.append(f"movel({poses[k - 1]}, v=0.05)")
            lines.append(f"movec({poses[k]}, {poses[k + 1]}, 1.2, 0.02, 0.0005)")
        else:
            lines.append(f"{word}({to}, a=1.2, v=0.0{g.integers(1, 9)}{g.choice(['', ', r=0.001'])})  # {k}")
        if g.random() < 0.3:
            lines.append(str(g.choice(["set_digital_out(1, True)", "# a comment", "sleep(0.1)", "x = 5"])))
    return f"def random():{eol}" + "".join(f"  {line}{eol}" for line in lines) + f"end{eol}"


def orders(g: np.random.Generator, t):
    """Other poses for the cuts, some as they were, some shifted as a whole, and poses put in before straight moves."""
    whole = np.flatnonzero((t.row % 1 == 0) & (t.kind == CUT))
    straight = [k for k in whole.tolist() if k > 0 and t.row[k - 1] == t.row[k] - 1]
    extra = np.repeat(g.choice(straight, min(4, len(straight)), replace=False), g.integers(1, 3))
    index = np.sort([*range(len(t)), *extra])
    made, row = commanded(t, index, np.zeros(3))
    row, position = row.copy(), made.position.copy()
    for k in np.unique(extra):
        group = np.flatnonzero(index == k)
        share = np.arange(1, len(group) + 1) / len(group)
        row[group] = t.row[k] - 1 + share
        position[group] = position[group[0] - 1] + share[:, None] * (position[group[-1]] - position[group[0] - 1])
    move = np.ceil(row - 1e-9).astype(int)
    shift = g.normal(scale=1e-4, size=(move.max() + 1, 3)) * (g.random((move.max() + 1, 1)) < 0.7)
    turn = g.normal(scale=1e-3, size=(move.max() + 1, 3)) * (np.abs(shift).max(axis=1) > 0)[:, None]
    arcs = np.unique(move[(row % 1 != 0)])
    shift[np.intersect1d(arcs, move[g.random(len(move)) < 0.5])] = 0.0
    cut = t.kind[index] == CUT
    position[cut] += shift[move[cut]]
    rotation = made.rotation.copy()
    rotation[cut] = Rotation.from_rotvec(turn[move[cut]]).as_matrix() @ rotation[cut]
    return replace(made, position=position, rotation=rotation), row


@pytest.mark.parametrize("suffix", ["ls", "script"])
@pytest.mark.parametrize("seed", range(40))
def test_what_is_read_again_is_what_was_commanded(tmp_path, suffix, seed):
    g = np.random.default_rng([seed, len(suffix)])
    reader, language = FILTERS[suffix]
    text = (listing if suffix == "ls" else script)(g)
    path = tmp_path / f"random.{suffix}"
    path.write_bytes(text.encode())
    t = reader.read(path, path.name, CHORD)
    made, row = orders(g, t)
    done = language.rewrite(text.encode(), made, row, path)
    path.write_bytes(done.text)
    new = reader.read(path, path.name, CHORD)
    cut = [p.kind == CUT for p in (made, new)]
    assert len(new) == len(made) and (cut[0] == cut[1]).all()
    arc = np.isin(np.ceil(row - 1e-9), np.ceil(t.row[t.row % 1 != 0]))[cut[0]]  # may lie 0.01 mm off one, 0.2 mrad
    off = np.linalg.norm(new.position[cut[1]] - made.position[cut[0]], axis=1)
    assert (off < np.where(arc, 1.05e-5, 3e-7)).all(), off.max()
    got = Rotation.from_quat(new.quaternion[cut[1]], scalar_first=True)
    turned = (got.inv() * Rotation.from_matrix(made.rotation[cut[0]])).magnitude()
    assert (turned < np.where(arc, 2.1e-4, 4e-7)).all(), turned.max()
    np.testing.assert_allclose(new.feed, made.feed, equal_nan=True)
    old = [t.position[(t.kind != CUT) & (t.row % 1 == 0)], new.position[(new.kind != CUT) & (new.row % 1 == 0)]]
    np.testing.assert_array_equal(*old)
    _nothing_else(text, done.text.decode(), suffix)


def _nothing_else(text: str, new: str, suffix: str) -> None:
    """Every line of the source that is no arc stands there in its order, but for numbers and names of poses."""
    assert ("\r\n" in text) == ("\r\n" in new) and new.count("\n") == new.count("\r\n") + (
        "\r\n" not in new
    ) * new.count("\n")
    if suffix == "ls":
        masks = [(r"(?<=P\[)\d+", "#"), (r"(?<==)\s*-?[\d.]+(?=\s+(?:mm|deg))", "#"), (r"(?<=CONFIG)[^']*'[^']*'", "#")]
    else:
        masks = [(r"(?:pose_trans\(f, )?p\[[^\]]*\]\)?|wp_\d", "#"), (r", r=[\d.]+(?=\))", "")]

    def masked(source: str) -> list[str]:
        out = []
        for line in source.splitlines():
            for pattern, word in masks:
                line = re.sub(pattern, word, line)
            out.append(line)
        return out

    left = iter(masked(new))
    for line in masked(text):
        arc = "C P[" in line or line.startswith("    :  P[") or "movec" in line
        assert arc or line in left, line
