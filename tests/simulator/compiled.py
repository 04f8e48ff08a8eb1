"""numba's `njit` with a cache that belongs to the whole source.

numba's own cache looks at one file's time stamp only: after an edit of plant.py the
compiled rollout.py would still hold the old plant. Here every state of the compiled
sources has a cache folder of its own, named by their digest.
"""

import hashlib
from functools import partial
from pathlib import Path

import numba

_HERE = Path(__file__).resolve().parent
_DIGEST = hashlib.sha256(b"".join((_HERE / f).read_bytes() for f in ("plant.py", "rollout.py")))
numba.config.CACHE_DIR = str(_HERE / "__pycache__" / f"numba-{_DIGEST.hexdigest()[:16]}")

njit = partial(numba.njit, cache=True)
