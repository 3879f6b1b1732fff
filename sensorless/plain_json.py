"""Data in the types that JSON knows."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np


def plain(data: Any, digits: int | None = None) -> Any:
    """Data in JSON types: what is no finite number becomes None.

    Parameters
    ----------
    data : mappings, lists, tuples and arrays of any depth
    digits : int, optional
        Significant digits of a float; default: all.
    """
    if isinstance(data, np.ndarray | np.generic):
        data = data.tolist()
    if isinstance(data, list | tuple):
        return [plain(entry, digits) for entry in data]
    if isinstance(data, Mapping):
        return {str(key): plain(value, digits) for key, value in data.items()}
    if not isinstance(data, float):
        return data
    if not math.isfinite(data):
        return None
    return data if digits is None else float(f"{data:.{digits}g}")
