"""Makes docs/mistakes.md: `python -m tests.mistakes`."""

from __future__ import annotations

import tempfile
from pathlib import Path

from tests.mistakes.inputs import write_inputs
from tests.mistakes.mistake import Mistake
from tests.mistakes.page import PAGE, outcome, page, row
from tests.mistakes.shell import Mishap


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        inputs = Path(folder) / "inputs"
        inputs.mkdir()
        write_inputs(inputs)
        done: list[str] = []

        def made(mistake: Mistake | Mishap) -> str:
            done.append(row(mistake, outcome(mistake, inputs, Path(folder) / str(len(done)))))
            print(done[-1], flush=True)
            return done[-1]

        PAGE.write_text(page(made), encoding="utf-8")


if __name__ == "__main__":
    main()
