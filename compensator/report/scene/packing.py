"""Arrays as text: little-endian numbers in base64, which a page unpacks without a loop."""

from __future__ import annotations

from base64 import b64encode
from typing import Any

import numpy as np
import numpy.typing as npt


def packed(values: npt.NDArray[Any], kind: npt.DTypeLike = np.float32) -> str:
    """All numbers of an array in row order."""
    return b64encode(np.ascontiguousarray(values, dtype=np.dtype(kind).newbyteorder("<")).tobytes()).decode()
