"""Array types that signatures name: what the numbers are, not how many axes they have; docstrings give the shape."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""Real numbers in double precision, in SI units."""
RealArray = NDArray[np.floating[Any]]
"""Real numbers in either precision."""
SingleArray = NDArray[np.float32]
"""Real numbers in single precision, as networks and meshes keep them."""
Indices = NDArray[np.int64]
"""Row numbers, counts, or labels as numbers."""
Times = NDArray[np.int64]
"""Moments in nanoseconds."""
Mask = NDArray[np.bool_]
"""True where something holds."""
PictureArray = NDArray[np.uint8]
"""One picture (h, w, 3) or several (n, h, w, 3): RGB, 0 to 255."""
