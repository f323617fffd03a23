"""``python -m compensator``: the command line."""

from __future__ import annotations

from compensator.cli import main

if __name__ == "__main__":
    main(prog_name="compensator")
