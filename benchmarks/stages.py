"""How the processor time of a command falls to its stages, on one core: a KRL program of 180,000 moves written anew as
RAPID, and a csv of 200,000 poses."""

from __future__ import annotations

import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import wraps
from importlib import import_module
from pathlib import Path
from typing import Any
from unittest.mock import patch

from benchmarks.job import CELL, MEMORY, SPRINGS, write_inputs
from benchmarks.table import Row
from benchmarks.timing import cores
from compensator.tasks.compensate import compensate_file

MOVES = 180_000
POSES = 200_000
PER_ROW = 1_000
#: Stage -> the functions that it consists of, by module; what one calls of another stage counts there.
STAGES = {
    "reading": ("compensator.tasks.compensate:read_program",),
    "robot, frames, joint moves": (
        "compensator.tasks.compensate:job_for", "compensator.tasks.compensate:with_joint_poses",
    ),
    "turns and configurations": ("compensator.tasks.compensate:planned",),
    "forces of the process": ("compensator.solve.compensate:load_along",),
    "prediction without a correction": ("compensator.solve.compensate:_positions",),
    "the solve": ("compensator.solve.compensate:_solved",),
    "flank changes": ("compensator.solve.compensate:with_flank_poses",),
    "writing": ("compensator.program.export:program_of", "compensator.program.export:write_program"),
    "reading back": ("compensator.solve.verify:_printed",),
    "the written program in the model": ("compensator.solve.verify:_error",),
    "shares of the deflection": ("compensator.solve.assessment:share_sizes",),
    "collisions": ("compensator.solve.assessment:collisions_along",),
    "judging, the rest": ("compensator.tasks.compensate:judged", "compensator.solve.assessment:judged"),
    "numbers of the summary": ("compensator.tasks.compensate:path_report",),
}  # fmt: skip


def write_program(folder: Path, moves: int, *, memory: bool) -> Path:
    """A wave in rows, half a millimetre from move to move; a joint move off the part and back between the rows."""
    frames = CELL[CELL.index("[tool]") : CELL.index("[process]")]
    (folder / "cell.toml").write_text(CELL.replace(frames, ""))
    (folder / "model.toml").write_text(MEMORY if memory else SPRINGS)
    lines = ["DEF part()", "$TOOL={X 20,Y -10,Z 250,A 0,B 0,C 0}", "$LOAD={M 35,CM {X 0,Y 10,Z 120,A 0,B 0,C 0}}",
             "$BASE={X 1500,Y -300,Z 800,A 0,B 0,C 0}", "$VEL.CP=0.03"]  # fmt: skip
    for k in range(moves):
        row, along = divmod(k, PER_ROW)
        x, y = 0.5 * (PER_ROW - 1 - along if row % 2 else along), 2.0 * (row % 250)
        z, tilt = 3.0 * ((along % 200) / 100.0 - 1.0) ** 2, 180.0 + 4.0 * ((row % 20) / 10.0 - 1.0)
        pose = f"{{X {x:.3f},Y {y:.3f},Z %s,A 0.000,B 0.000,C {tilt:.3f}}}"
        if not along:
            lines.append(f"PTP {pose % f'{z + 60.0:.4f}'}")
        lines.append(f"LIN {pose % f'{z:.4f}'} C_DIS")
        if along == PER_ROW - 1:
            lines.append(f"PTP {pose % f'{z + 60.0:.4f}'}")
    file = folder / "part.src"
    file.write_text("\n".join([*lines, "END", ""]))
    return file


def run(moves: int = MOVES, poses: int = POSES) -> Iterator[Row]:
    """Seconds of the process, and shares of the KRL program; of the csv microseconds a pose; with joint memory, too."""
    for memory in (False, True):
        group = f"KRL of {moves:,} moves to RAPID" + (" (backlash and preload)" if memory else "")
        with tempfile.TemporaryDirectory(prefix="bench-") as name:
            spent, whole = _compensated(write_program(Path(name), moves, memory=memory))
        yield Row(group, "all of it, CPU", whole, "s", "")
        for stage in STAGES:
            yield Row(group, f"  {stage}", 100.0 * spent[stage] / whole, "%", "")
        yield Row(group, "  the rest", 100.0 * (whole - sum(spent.values())) / whole, "%", "")
    for memory in (False, True):
        group = f"csv of {poses:,} poses to RAPID, one core" + (" (backlash and preload)" if memory else "")
        with tempfile.TemporaryDirectory(prefix="bench-") as name:
            write_inputs(Path(name), poses, memory=memory)
            spent, whole = _compensated(Path(name) / "path.csv")
        yield Row(group, "all of it, CPU", whole, "s", "")
        for stage in STAGES:
            yield Row(group, f"  {stage}", 1e6 * spent[stage] / poses, "us per pose", "")
        yield Row(group, "  the rest", 1e6 * (whole - sum(spent.values())) / poses, "us per pose", "")


def _compensated(source: Path) -> tuple[dict[str, float], float]:
    with cores(1):
        return timed(lambda: compensate_file(source, source.with_name("cell.toml"), source.with_name("out.mod")))


def timed(task: Callable[[], object]) -> tuple[dict[str, float], float]:
    """CPU seconds of a task by stage, and of all of it."""
    spent: dict[str, float] = defaultdict(float)
    inside: list[str] = []
    begun = time.process_time()

    def passed() -> None:
        """The time since the last change goes to the innermost stage."""
        nonlocal begun
        now = time.process_time()
        if inside:
            spent[inside[-1]] += now - begun
        begun = now

    def counted(stage: str, function: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(function)
        def call(*args: Any, **kwargs: Any) -> Any:
            passed()
            inside.append(stage)
            try:
                return function(*args, **kwargs)
            finally:
                passed()
                inside.pop()

        return call

    with ExitStack() as patches:
        for stage, functions in STAGES.items():
            for place in functions:
                module, name = import_module(place.partition(":")[0]), place.partition(":")[2]
                patches.enter_context(patch.object(module, name, counted(stage, getattr(module, name))))
        first = begun = time.process_time()
        task()
        return spent, time.process_time() - first
