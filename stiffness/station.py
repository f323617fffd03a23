"""Station: what belongs to the measurement set-up and is estimated with the rest.

The tracker's pose per block where the session is not registered, reflectors that are only roughly known, and the
placement of a rigid probe whose reflectors form a group. Rotations are kept as matrices; the vector holds
increments that ``moved`` folds in.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.session import Session

Floats = npt.NDArray[np.float64]
