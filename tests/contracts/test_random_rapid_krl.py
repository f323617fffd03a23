"""Random RAPID and KRL programs in place: what is read again is what was commanded, and nothing else has changed."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.oracles.commanded import without_marker
from toolpaths.files import read_toolpath
from toolpaths.frame import Frame
from toolpaths.languages.krl import filter as krl_filter
from toolpaths.languages.rapid import filter as rapid_filter
from toolpaths.toolpath import Toolpath
from toolpaths.writing.program import Program

AXES = "[9E9,9E9,9E9,9E9,9E9,9E9]"
END = {".mod": "\r\n", ".src": "\n"}


class Random:
    """One random program: rapids, lines, arcs, declared targets, several tools and frames."""

    def __init__(self, seed: int, suffix: str) -> None:
        self.rng, self.suffix = np.random.default_rng(seed), suffix
        self.declared: list[str] = []
        self.lines: list[str] = []

    def pose(self) -> str:
        """A pose in the language, numbers printed with random digits."""
        digits = int(self.rng.integers(0, 6))
        xyz = [f"{v:.{digits}f}" for v in self.rng.uniform(-300, 300, 3)]
        turn = Rotation.from_quat(self.rng.normal(size=4))
        if self.suffix == ".mod":
            q = ",".join(f"{v:.8f}" for v in turn.as_quat(scalar_first=True) * self.rng.choice([-1, 1]))
            return f"[[{','.join(xyz)}],[{q}],[0,-1,{self.rng.integers(-2, 2)},1],{AXES}]"
        abc = [f"{v:.{max(digits, 3)}f}" for v in turn.as_euler("ZYX", degrees=True)]
        words = [f"{k} {v}" for k, v in zip("XYZABC", [*xyz, *abc], strict=True)]
        return "{" + f"{self.rng.choice(['', 'E6POS: '])}{','.join(words)}{self.rng.choice(['', ',S 2,T 35'])}" + "}"

    def target(self, word: str) -> str:
        kind = self.rng.random()
        if kind < 0.5 or not self.declared or word == "arc":
            return self.pose()
        name = str(self.rng.choice(self.declared))
        if kind < 0.9:
            return name
        step = [int(v) for v in self.rng.integers(-50, 50, 3)]
        if self.suffix == ".mod":
            return f"Offs({name},{step[0]},{step[1]},{step[2]})"
        return f"{name}:{{X {step[0]},Y {step[1]},Z {step[2]},A 0,B 0,C 0}}"

    def move(self) -> None:
        kind = self.rng.choice(["rapid", "line", "line", "line", "arc"]) if len(self.lines) > 2 else "line"
        if self.suffix == ".mod":
            word = {"rapid": "MoveJ", "line": "MoveL", "arc": "MoveC"}[kind]
            via = f"{self.pose()}, " if kind == "arc" else ""
            zone = self.rng.choice(["fine", "z1", "z10\\Z:=3"])
            tail = f"v{self.rng.choice([5, 20, 100])},{zone},tool{self.rng.choice(['0', 'A'])}"
            wobj = self.rng.choice(["", "\\WObj:=w1", "\\WObj:=w2"])
            self.lines.append(f"    {word} {via}{self.target(kind)}, {tail}{wobj};")
        else:
            if self.rng.random() < 0.15:
                self.lines.append(f"$BASE=BASE_DATA[{self.rng.integers(1, 3)}]")
            word = {"rapid": "PTP", "line": "LIN", "arc": "CIRC"}[kind]
            via = f"{self.pose()}, " if kind == "arc" else ""
            self.lines.append(f"{word} {via}{self.target(kind)} {self.rng.choice(['', 'C_DIS'])}".rstrip())
        if self.rng.random() < 0.2:
            self.lines[-1] += "  ! a, [b]; {c}" if self.suffix == ".mod" else "  ; a, {b}; C_DIS"

    def text(self, moves: int) -> str:
        head = []
        for k in range(int(self.rng.integers(0, 5))):
            pose = self.pose()
            self.declared.append(f"p{k}0")
            head.append(f"  CONST robtarget p{k}0:={pose};" if self.suffix == ".mod" else f"DECL E6POS p{k}0={pose}")
        for _ in range(moves):
            self.move()
        body = "\n".join(self.lines)
        if self.suffix == ".mod":
            a, b = ("[1,0,0,0]", "[0.707106781,0,0,-0.707106781]")
            frames = "".join(
                f'  PERS wobjdata w{k}:=[FALSE,TRUE,"",[[{k}00,50,-7],{q}],[[0,{k},0],[1,0,0,0]]];\n'
                for k, q in ((1, a), (2, b))
            )
            tool = "[[30,-20,240],[1,0,0,0]],[3,[0,0,9],[1,0,0,0],0,0,0]"
            data = f"{frames}  PERS tooldata toolA:=[TRUE,{tool}];\n" + "\n".join(head)
            return f"MODULE P\n{data}\n  PROC main()\n{body}\n  ENDPROC\nENDMODULE\n"
        frames = "BASE_DATA[1]={X 100,Y 50,Z -7,A 0,B 0,C 0}\nBASE_DATA[2]={X 9,Y 5,Z 2,A 90,B 0,C 10}\n"
        return "DEF P()\n" + "\n".join(head) + f"\n{frames}$BASE=BASE_DATA[1]\n$TOOL=$NULLFRAME\n{body}\nEND\n"


def commanded(path: Toolpath, rng: np.random.Generator) -> tuple[Program, np.ndarray]:
    """Other poses at some of the cuts, some poses of arcs and lines put in; and their rows."""
    extra = [(k, float(f)) for k in np.flatnonzero(path.kind[1:] == 1) + 1 for f in rng.random(1) if rng.random() < 0.2]
    extra = [(k, path.row[k - 1] + f * (path.row[k] - path.row[k - 1])) for k, f in extra]
    index = np.concatenate([np.arange(len(path)), [k for k, _ in extra]]).astype(int)
    row = np.concatenate([path.row, [r for _, r in extra]])
    order = np.argsort(row, kind="stable")
    index, row = index[order], row[order]
    moved = (rng.random(len(path)) < 0.8)[index] & (path.kind[index] == 1)
    phase = np.outer(path.row[index], [7.0, 8.0, 9.0])
    shift = 3e-4 * np.sin(phase) * moved[:, None]
    turn = Rotation.from_rotvec(2e-3 * np.cos(phase) * moved[:, None])
    rotation = (turn * Rotation.from_quat(path.quaternion[index], scalar_first=True)).as_matrix()
    n = len(index)
    program = Program(
        "P", path.position[index] + shift, rotation, np.zeros((n, 6)), np.zeros(n), path.kind[index],
        path.tool[index], path.line[index], {}, Frame.identity(), 0.5,
    )  # fmt: skip
    return program, row


def in_frame(path: Toolpath, frame: Frame) -> Toolpath:
    """The poses in another frame: lines put in may make another one that of most cuts."""
    relative = np.linalg.inv(frame.matrix) @ path.setting.workobject.matrix
    turn = Rotation.from_matrix(relative[:3, :3]) * Rotation.from_quat(path.quaternion, scalar_first=True)
    position = path.position @ relative[:3, :3].T + relative[:3, 3]
    return replace(path, position=position, quaternion=turn.as_quat(scalar_first=True))


def bare(text: bytes, suffix: str) -> bytes:
    """A program without the numbers of its poses and the names of what was split."""
    text = re.sub(rb"p(\d)0_[cC]\d+", rb"p\g<1>0", text)
    if suffix == ".mod":
        return re.sub(rb"\[\[[^\[\]]*\],\[[^\[\]]*\],\[0,-1", b"[[#],[#],[0,-1", text)
    return re.sub(rb"X [^XYZABCST}]*,Y [^,]*,Z [^,]*,A [^,]*,B [^,]*,C [^,}]*", b"#", text)


@pytest.mark.parametrize("seed", range(40))
@pytest.mark.parametrize("suffix", [".mod", ".src"])
def test_what_is_read_again_is_what_was_commanded(tmp_path: Path, suffix: str, seed: int) -> None:
    file = tmp_path / f"P{suffix}"
    text = Random(seed, suffix).text(12).replace("\n", END[suffix])
    file.write_bytes(text.encode())
    path = read_toolpath(file, chord=1e-3)
    program, row = commanded(path, np.random.default_rng(seed))
    rewrite = {".mod": rapid_filter.rewrite, ".src": krl_filter.rewrite}[suffix]
    out = rewrite(file.read_bytes(), program, row, file)
    assert out.beside == ()
    again = tmp_path / f"Q{suffix}"
    again.write_bytes(out.text)
    read = in_frame(read_toolpath(again, chord=1e-3), path.setting.workobject)
    ends = np.abs(read.row - np.rint(read.row)) < 1e-9
    wanted = np.abs(row - np.rint(row)) < 1e-9
    arcs = [k for k, line in enumerate(text.split(END[suffix])) if "MoveC" in line or "CIRC" in line]
    if not arcs:
        wanted[:] = True
    kind = 9.0 * program.kind[wanted], 9.0 * read.kind[ends]
    kept = in_order(np.c_[program.position[wanted], kind[0]], np.c_[read.position[ends], kind[1]])
    a, b = np.flatnonzero(wanted), np.flatnonzero(ends)[kept]
    np.testing.assert_allclose(read.position[b], program.position[a], atol=2e-7)
    turned = Rotation.from_quat(read.quaternion[b], scalar_first=True).inv() * Rotation.from_matrix(program.rotation[a])
    assert turned.magnitude().max() < 5e-8
    np.testing.assert_array_equal(read.kind[b], program.kind[a])
    lines = bare(without_marker(out.text), suffix).split(END[suffix].encode())
    left = iter(lines)
    for line in bare(text.encode(), suffix).split(END[suffix].encode()):
        if not re.search(rb"MoveC|CIRC|Offs|\w:\{", line):  # these may become lines, and numbers
            assert line in left, line


def in_order(wanted: np.ndarray, given: np.ndarray) -> list[int]:
    """Where the wanted points stand among the given ones, in their order."""
    out, at = [], 0
    for point in wanted:
        while at < len(given) and np.linalg.norm(given[at] - point) > 1e-6:
            at += 1
        if at == len(given):
            raise AssertionError(f"{point} does not come again")
        out.append(at)
        at += 1
    return out


@pytest.mark.parametrize(("suffix", "limit"), [(".mod", 32), (".src", 24)])
def test_names_of_split_targets_are_legal_and_new(tmp_path: Path, suffix: str, limit: int) -> None:
    """The longest name, a neighbour that has the next name already, and moves that need four different poses."""
    name = "p" + "x" * (limit - 1)
    taken = f"{name[: limit - 3]}_c1"
    pose = {".mod": f"[[1,2,3],[0,1,0,0],[0,-1,0,1],{AXES}]", ".src": "{X 1,Y 2,Z 3,A 0,B 0,C 180}"}[suffix]
    if suffix == ".mod":
        data = "".join(f"CONST robtarget {n}:={pose};\n" for n in (name, taken.upper()))
        moves = "".join(f"MoveL {n},v5,z1,tool0;\n" for n in (name, name, taken, name, name))
        text = f"MODULE P\n{data}PROC main()\n{moves}ENDPROC\nENDMODULE\n"
    else:
        data = "".join(f"DECL POS {n}={pose}\n" for n in (name, taken.upper()))
        text = f"DEF P()\n{data}" + "".join(f"LIN {n}\n" for n in (name, name, taken, name, name)) + "END\n"
    file = tmp_path / f"P{suffix}"
    file.write_text(text)
    path = read_toolpath(file)
    shift = np.outer(np.arange(5), [1e-4, 0, 0])
    rotation = Rotation.from_quat(path.quaternion, scalar_first=True).as_matrix()
    program = Program(
        "P", path.position + shift, rotation, np.zeros((5, 6)), np.zeros(5), path.kind, path.tool, path.line, {},
        Frame.identity(), 0.5,
    )  # fmt: skip
    out = {".mod": rapid_filter.rewrite, ".src": krl_filter.rewrite}[suffix](file.read_bytes(), program, path.row, file)
    names = re.findall(r"(?:robtarget|POS) (\w+)", out.text.decode())
    assert len(names) == 5 and len({n.lower() for n in names}) == 5 and all(len(n) <= limit for n in names)
    (tmp_path / f"Q{suffix}").write_bytes(out.text)
    again = read_toolpath(tmp_path / f"Q{suffix}")
    np.testing.assert_allclose(again.position, path.position + shift, atol=1e-9)
