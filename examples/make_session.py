"""Make examples/session: a day at a tracker, simulated with the independent plant of the tests.

    python -m examples.make_session [-o FOLDER]

An ABB IRB 6600 that is 1.3 times as stiff as its published set in joint 2, and has a gap in joint 3 that nobody has
declared. The same call writes the same bytes.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tests.plant.lab import Noise
from tests.stiffness.bench_lab import Lab

SETUPS = 8


@dataclass(frozen=True)
class Shop(Lab):
    """The robot of the session."""

    @property
    def stiffness(self) -> np.ndarray:
        return super().stiffness * [1.0, 1.3, 1.0, 1.0, 1.0, 1.0]


def main() -> None:
    """Write the files."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--out", type=Path, default=Path(__file__).parent / "session")
    gap = (0.0, 0.0, 3e-4, 0.0, 0.0, 0.0)
    Shop(gap=gap, breakaway=30.0).session(parser.parse_args().out, 11, setups=SETUPS, noise=Noise())


if __name__ == "__main__":
    main()
