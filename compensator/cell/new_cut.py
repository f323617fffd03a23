"""The [process] table of a new cell: cutters, material and stock as they were answered, or a wrench that is assumed."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from pydantic import ValidationError

from compensator.errors import CellError
from compensator.process.milling.cutter_table import CutterTable
from compensator.process.milling.mesh_reader import FORMATS, UNITS
from compensator.process.milling.stock_table import StockTable
from stiffness.schema import findings
from toolpaths.toolpath import CUT, Toolpath

Lines = tuple[str, ...]
NONE, UNKNOWN = "none", "unknown"
#: Further numbers of a cutter, after diameter, flutes and length.
MORE = {"bull": ("corner_radius",), "taper": ("half_angle", "corner_radius"), "drill": ("point_angle",)}
CUTTER_EXAMPLE = "flat 10 2 25"
SIDEWAYS = 2.0  # a move that goes farther across than twice its way down is no plunge
MARGIN = 1.0  # mm of an assumed stock around what the cutters pass


@dataclass(frozen=True)
class CutAnswers:
    """A cut in words of the user; paths as seen from the cell.

    Attributes:
        cutters: number of the tool in the file, or None: the only one.
        material: built-in set, or file. stock: its table. assumed: whether nobody gave the stock.
        spindle: 1/min where the file gives none, or None.
    """

    cutters: Mapping[int | None, CutterTable]
    material: str
    stock: StockTable
    assumed: bool
    spindle: float | None


def cutters_of(words: str) -> dict[int | None, CutterTable]:
    """``flat 10 2 25``, or ``1=flat 10 2 25; 2=ball 6 2 20``: shape, diameter mm, flutes, length of edge mm; then the
    corner radius of a bull, half angle (and corner radius) of a taper, point angle of a drill.

    Raises:
        CellError: names what was answered and what was expected.
    """
    return {number: _cutter_of(one) for number, one in numbered(words, "cutter")}


def numbered(words: str, what: str) -> list[tuple[int | None, str]]:
    """``ANSWER``, or ``1=ANSWER; 2=ANSWER`` by the number of the tool in the file.

    Raises:
        CellError: names what was asked, what was answered and what was expected.
    """
    out: dict[int | None, str] = {}
    parts = [part.strip() for part in words.split(";") if part.strip()]
    for one in parts or [""]:
        number, equals, rest = one.rpartition("=")
        key = int(number) if equals and number.strip().isdecimal() else None
        if (equals and key is None) or key in out or (len(parts) > 1 and key is None):
            remedy = "several are given as 1=...; 2=... by the number of the tool in the file"
            raise CellError(f"{what} = {words!r}: {remedy}")
        out[key] = rest
    return list(out.items())


def _cutter_of(one: str) -> CutterTable:
    shape, *numbers = [*one.replace(",", " ").split(), ""]
    names = ("diameter", "flutes", "length", *MORE.get(shape, ()))
    try:
        values = [float(v) for v in numbers if v]
    except ValueError:
        raise _cutter(one, "what follows the shape are numbers") from None
    if not 3 <= len(values) <= len(names):
        raise _cutter(one, f"{len(values)} numbers after {shape!r}")
    table: dict[str, object] = {"shape": shape, **dict(zip(names, values, strict=False))}
    if values[1] == int(values[1]):
        table["flutes"] = int(values[1])
    try:
        return CutterTable.model_validate(table)
    except ValidationError as e:
        raise _cutter(one, "; ".join(str(f) for f in findings(e))) from e


def _cutter(answer: str, why: str) -> CellError:
    expected = f"expected shape, diameter mm, flutes, length of the edge mm, such as {CUTTER_EXAMPLE} or bull 10 2 25 1"
    return CellError(f"cutter = {answer!r}: {why}; {expected}")


def stock_of(words: str, toolpath: Toolpath | None, cutters: Mapping[int | None, CutterTable]) -> StockTable:
    """``box`` and two corners, ``cylinder`` x y radius z z, a mesh and its unit, or ``unknown``: a box around the cuts.

    Raises:
        CellError: names what was answered and what was expected.
    """
    if words.strip() == UNKNOWN:
        return _around(toolpath, cutters)
    try:
        first, *rest = shlex.split(words) or [""]
    except ValueError:
        raise _stock(words, "its quotes do not close") from None
    if first not in ("box", "cylinder"):
        unit = rest[0] if rest else "mm"
        if not first.lower().endswith(FORMATS) or len(rest) > 1 or unit not in UNITS:
            raise _stock(words, "no shape that is known")
        return StockTable.model_validate({"file": first, **({"units": unit} if rest else {})})
    try:
        v = [float(word) for word in " ".join(rest).replace(",", " ").split()]
    except ValueError:
        v = []
    if len(v) != (6 if first == "box" else 5):
        raise _stock(words, f"{first} has {'6' if first == 'box' else '5'} numbers")
    round_ = {"center": v[:2], "radius": v[2], "z": v[3:]} if first == "cylinder" else None
    try:
        return StockTable.model_validate({"cylinder": round_} if round_ else {"box": [v[:3], v[3:]]})
    except ValidationError as e:
        raise _stock(words, "; ".join(str(f) for f in findings(e))) from e


def _stock(answer: str, why: str) -> CellError:
    meshes = f"a mesh ({' '.join(FORMATS)}) and its unit if it is not mm"
    expected = f"expected {meshes}, box X Y Z X Y Z, cylinder X Y RADIUS Z Z, in mm, or unknown"
    return CellError(f"stock = {answer!r}: {why}; {expected}")


def _around(toolpath: Toolpath | None, cutters: Mapping[int | None, CutterTable]) -> StockTable:
    """A box around what is cut; its top is z = 0 where the path goes below that, else the highest cut."""
    if toolpath is None or not (toolpath.kind == CUT).any():
        raise CellError("stock = 'unknown': the CAM file cannot be read with this cell, so no box is known; give one")
    at = toolpath.position * 1e3
    cut = toolpath.kind == CUT
    way = np.abs(np.diff(at, axis=0, prepend=at[:1]))
    across = cut & (np.hypot(way[:, 0], way[:, 1]) > SIDEWAYS * way[:, 2])
    used = across if across.any() else cut
    used[:-1] |= used[1:]  # a move begins at the pose before
    wide = max(0.5 * c.diameter for c in cutters.values()) + MARGIN
    low, high = at[used].min(axis=0) - wide, at[used].max(axis=0) + wide
    low[2] = at[cut, 2].min() - MARGIN
    high[2] = 0.0 if low[2] + MARGIN < 0.0 else at[used, 2].max()
    box = [[float(v) for v in np.floor(low)], [float(v) for v in np.ceil(high)]]
    return StockTable.model_validate({"box": box})


def cut_lines(cut: CutAnswers) -> Lines:
    """[process] for a cut whose force is computed."""
    given = cut.spindle is not None
    return (
        "[process]  # the force of the cut is computed from cutter, material and stock: docs/cutting.md",
        'kind = "milling"',
        f"material = {quoted(cut.material)}",
        f"spindle_rpm = {cut.spindle:g}" if given else "# spindle_rpm = 8000.0  # where the CAM file gives no S",
        "",
        *(line for number, cutter in cut.cutters.items() for line in _cutter_lines(number, cutter)),
        *_stock_lines(cut),
        "# part = \"part.stl\"  # the finished part: gouges and rest material are reported against it",
    )


def _cutter_lines(number: int | None, cutter: CutterTable) -> Lines:
    told = {k: v for k, v in cutter.model_dump(exclude_unset=True).items() if v is not None and k != "shape"}
    return (
        "[process.cutter]" if number is None else f"[process.cutters.{number}]  # T{number} of the CAM file",
        f'shape = "{cutter.shape}"',
        *(f"{key} = {value:g}" for key, value in told.items()),
        "",
    )


def _stock_lines(cut: CutAnswers) -> Lines:
    s = cut.stock
    if s.file is not None:
        unit = (f'units = "{s.units}"',) if "units" in s.model_fields_set else ()
        return ("[process.stock]  # in the frame of the CAM file", f"file = {quoted(s.file)}", *unit)
    if s.cylinder is not None:
        c = s.cylinder
        shape = f"cylinder = {{ center = {_listed(c.center)}, radius = {c.radius:g}, z = {_listed(c.z)} }}"
        return ("[process.stock]  # in the frame of the CAM file, mm", shape)
    box = [] if s.box is None else [_listed(corner) for corner in s.box]
    why = "ASSUMED: a full block around the cuts of the CAM file" if cut.assumed else "in the frame of the CAM file, mm"
    return (f"[process.stock]  # {why}", f"box = [{', '.join(box)}]")


def wrench_lines(wrench: tuple[float, ...]) -> Lines:
    """[process] for a wrench that nobody gave."""
    return (
        "[process]  # ASSUMED: a light finishing cut in aluminium. Put in yours, or cutter, material and stock "
        "(docs/cutting.md)",
        'kind = "constant"',
        'frame = "path"  # x along the feed, z out of the tool into the work',
        f"wrench = {_listed(wrench)}  # on the robot, about the TCP",
    )


def _listed(values: tuple[float, ...]) -> str:
    return str([float(v) for v in values])


def quoted(text: str) -> str:
    """As a TOML string."""
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
