"""ToolNumbers: the numbers of tools that a CNC program calls by number, or by name."""

from __future__ import annotations


class ToolNumbers:
    """Tools of one file. Names get numbers in the order in which they are first called, from 1 on."""

    def __init__(self) -> None:
        self._names: dict[str, int] = {}
        self._numbered = False

    def of(self, tool: float | str) -> int:
        """The number of a tool.

        Raises:
            ValueError: it is no number of a tool, or some tools are called by name and some by number.
        """
        if isinstance(tool, str) and not tool.strip().isdigit():
            if self._numbered:
                raise ValueError(f'tool "{tool}" by its name, others by number', "Call all by number, or all by name.")
            return self._names.setdefault(tool.strip(), len(self._names) + 1)
        value = float(tool)
        if not 0 <= value < 1e9 or value != int(value):
            raise ValueError(f"tool {value:g}: a whole number from 0 on is expected")
        if self._names and value:
            raise ValueError(f"tool {value:g} by its number, others by name", "Call all by number, or all by name.")
        self._numbered = self._numbered or value > 0
        return int(value)
