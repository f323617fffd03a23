"""Writes docs/python-functions.md: a section for every function of `import compensator`, with an example.

    python -m docs.make_functions
"""

from __future__ import annotations

import inspect
import re
from pathlib import Path

import compensator

PAGE = Path(__file__).parent / "python-functions.md"
HEAD = """# The functions of `import compensator`

Made from the code by `python -m docs.make_functions`; a test compares, and runs the examples in their order.
An introduction: [python.md](python.md).

```python
>>> import compensator as comp

```
"""
EXAMPLES = {
    "load_robot": """
>>> robot = comp.load_robot("ur10")
>>> robot.n, robot.name
(6, 'ur10')
""",
    "load_model": """
>>> model = comp.load_model("model.toml")
>>> print(model.values["joint-stiffness"]["k_nm_per_rad"][:3])
[2000000. 1700000. 1300000.]
""",
    "load_cell": """
>>> cell = comp.load_cell("cell.toml")
>>> cell.robot, cell.tool.mass
('abb-irb6600-175-255', 30.0)
""",
    "read_toolpath": """
>>> path = comp.read_toolpath("part.nc", cell)
>>> path.language, len(path)
('gcode', 6)
""",
    "preview": """
>>> shown = comp.preview(path, cell)
>>> round(shown.summary["predicted_error_mm"]["before"]["max"], 1)
1.0
>>> comp.write(shown, "deflection.csv")
WrittenFiles(deflection.csv)
""",
    "compensate": """
>>> done = comp.compensate("part.nc", "cell.toml")
>>> done.summary["max_correction_mm"] > 0.5
True
>>> [sentence for sentence in done.findings if sentence.startswith("error")]
[]
""",
    "identify": """
>>> fit = comp.identify("session.toml", effects=["joint-stiffness"])
>>> fit.summary["n_readings"] > 100
True
""",
    "diagnose": """
>>> comp.write(fit, "fitted.toml")
WrittenFiles(fitted.toml)
>>> found = comp.diagnose("session.toml", "fitted.toml")
>>> found.facts()["added"]
'...'
""",
    "evaluate": """
>>> score = comp.evaluate("session.toml", "fitted.toml")
>>> score.summary["displacement"]["rms_mm"] < 0.05
True
""",
    "write": """
>>> comp.write(done, "part.src")
WrittenFiles(part.src)
>>> comp.write(done, "part.parquet")
WrittenFiles(part.parquet)
>>> import pandas
>>> len(pandas.read_parquet("part.parquet")) == done.summary["n_poses"]
True
""",
}


def page() -> str:
    """The whole page."""
    out = [HEAD]
    for name in EXAMPLES:
        function = getattr(compensator, name)
        lead, args, raises = _parts(inspect.getdoc(function) or "")
        signature = re.sub(r"'(\w[^']*)'", r"\1", str(inspect.signature(function)))
        out += [f"## {name}", "", "```text", f"{name}{signature}", "```", "", lead, ""]
        out += [*(f"- {line}" for line in args), *([""] if args else [])]
        out += [f"Raises {line}" for line in raises] + ([""] if raises else [])
        out += ["```python", EXAMPLES[name].strip(), "", "```", ""]
    return "\n".join(out)


def _parts(docstring: str) -> tuple[str, list[str], list[str]]:
    """Lead, arguments, errors of a docstring, in Markdown."""
    text = docstring.replace("``", "`")
    lead, _, rest = text.partition("\n\nArgs:\n")
    if not rest:
        lead, _, raised = text.partition("\n\nRaises:\n")
        return lead, [], _entries(raised)
    args, _, raised = rest.partition("\n\nRaises:\n")
    return lead, _entries(args), _entries(raised)


def _entries(text: str) -> list[str]:
    """One line each; the name in code."""
    found = re.split(r"\n {4}(?=\S)", "\n" + text.rstrip())[1:] if text.strip() else []
    return [re.sub(r"^([\w, ]+):", r"`\1`:", " ".join(entry.split())) for entry in found]


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8", newline="\n")
