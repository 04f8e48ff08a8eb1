"""Types that arguments and answers have."""

import os
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
File: TypeAlias = str | os.PathLike[str]
Recording: TypeAlias = File | tuple[str, list[tuple[str, Array]]]
