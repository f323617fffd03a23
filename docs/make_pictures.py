"""Make the pictures in docs/images from real results of this checkout.

    python -m docs.make_pictures [--cell CELL.toml] [--toolpath FILE]      needs the extra `docs` (matplotlib)

The example's path, coloured by the predicted distance of the TCP from where it has to be: commanded as the
file says, and with the commands of the solve, read back from the written program.
"""

from __future__ import annotations

import argparse
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
from matplotlib.colors import Normalize
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Line3DCollection
from PIL import Image

from compensator.solve.compensation import Compensation
from compensator.solve.verify import verify
from compensator.tasks.compensate import compensate_file

ROOT = Path(__file__).resolve().parents[1]
Floats = npt.NDArray[np.float64]
SCALE = "viridis"
LIGHTEST = 0.98  # of the cutting poses: a few where a slot is cut would leave no colours for the others


def solved(toolpath: Path, cell: Path) -> tuple[Compensation, Floats, Floats]:
    """The result, and the errors (N,) in mm before and after, the latter of the program as written."""
    with TemporaryDirectory() as folder:
        program = Path(folder) / "program.mod"
        result = compensate_file(toolpath, cell, program).result
        after = verify(result, program, "rapid").error
    return result, np.linalg.norm(result.error_before, axis=1) * 1e3, after * 1e3


def wave(result: Compensation, before: Floats, after: Floats, target: Path) -> None:
    """Both views on one colour scale."""
    norm = Normalize(0.0, np.quantile(before[result.cutting], LIGHTEST))
    figure = plt.figure(figsize=(11.0, 3.9), dpi=110)
    for k, (name, value) in enumerate((("uncompensated", before), ("compensated", after))):
        axes = figure.add_axes((0.038 + 0.445 * k, -0.02, 0.42, 0.93), projection="3d")
        view(axes, result, value, norm)
        cut = value[result.cutting]
        axes.set_title(f"{name}\nmean {length(cut.mean())}, at most {length(cut.max())}", fontsize=12, y=1.0)
    bar = figure.add_axes((0.93, 0.12, 0.014, 0.7))
    figure.colorbar(plt.cm.ScalarMappable(norm, SCALE), bar, label="predicted TCP error, mm", extend="max")
    drawn = BytesIO()
    figure.savefig(drawn, facecolor="white")
    plt.close(figure)
    picture = Image.open(drawn).convert("RGB")  # 256 colours do, and take half the bytes
    few = picture.quantize(256, Image.Quantize.MEDIANCUT, kmeans=4, dither=Image.Dither.NONE)
    few.save(target, optimize=True)


def length(mm: float) -> str:
    """In mm, µm or nm, as fits."""
    if mm >= 0.01:
        return f"{mm:.2f} mm"
    return f"{mm * 1e3:.2f} µm" if mm >= 1e-5 else "below 0.01 µm"


def view(axes: Axes3D, result: Compensation, value: Floats, norm: Normalize) -> None:
    """The cuts of the path in the work object, coloured by ``value``; rapids thin and grey; equal axes."""
    at = result.path.toolpath.position * 1e3
    segments = np.stack([at[:-1], at[1:]], axis=1)
    cut = result.cutting[1:]
    # the axes are a square in the middle of their place: what reaches beyond it must not be cut off
    rapids = Line3DCollection(segments[~cut], colors="0.6", linewidths=0.6, clip_on=False)
    axes.add_collection3d(rapids)
    lines = Line3DCollection(segments[cut], cmap=SCALE, norm=norm, linewidths=1.5, clip_on=False)
    lines.set_array(value[1:][cut])
    axes.add_collection3d(lines)
    low, high = at[result.cutting].min(axis=0), at[result.cutting].max(axis=0)
    for name, a, b in zip("xyz", low, high, strict=True):
        getattr(axes, f"set_{name}lim")(a - 3.0, b + 3.0)
    axes.set_xlabel("x, mm", fontsize=9)
    axes.set_ylabel("y, mm", fontsize=9)
    axes.set_zticks([-20, 0], ["-20 mm", "z = 0"])  # a z label would stand in the other view
    axes.set_xticks([0, 50, 100, 150, 200])
    axes.set_yticks([0, 50, 100, 150])
    axes.set_box_aspect(high - low + 6.0, zoom=1.2)
    axes.tick_params(labelsize=8, pad=0)
    axes.view_init(elev=34, azim=-125)


def main() -> None:
    parser = argparse.ArgumentParser(description="make the pictures in docs/images")
    parser.add_argument("--toolpath", type=Path, default=ROOT / "examples" / "wave.nc")
    parser.add_argument("--cell", type=Path, default=ROOT / "examples" / "cell.toml")
    given = parser.parse_args()
    folder = ROOT / "docs" / "images"
    folder.mkdir(exist_ok=True)
    wave(*solved(given.toolpath, given.cell), folder / "wave-before-after.png")


if __name__ == "__main__":
    main()
