"""Types of arguments and results."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Callable, Literal, Optional, Union

import numpy as np
import numpy.typing as npt

Ids = Union[npt.NDArray[np.int32], npt.NDArray[np.int64]]
Floats = npt.NDArray[np.float64]
Period = Union[float, Sequence[Optional[float]], Floats]
Method = Union[Literal["linear"], Literal["sibson"], Literal["laplace"]]
Progress = Callable[[str, int, int], None]
