"""Variables of a MATLAB file."""

from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensorless.files import read_bytes


def read_matlab(path: Path) -> dict[str, NDArray[Any]]:
    """Variables by name, the fields of a structure in the place of the structure.

    Raises
    ------
    OSError
        The file cannot be read, or is too large.
    ValueError
        It is no MATLAB file, or of version 7.3, which is HDF5.
    """
    from scipy.io import loadmat

    raw = BytesIO(read_bytes(path))
    try:
        known = loadmat(raw, squeeze_me=True)
    except NotImplementedError:
        raise ValueError("a MATLAB file of version 7.3; save it with -v7, or as CSV") from None
    except Exception as error:  # of a broken file SciPy raises whatever comes up
        raise ValueError(f"not a valid MATLAB file: {error}; save it anew, or as CSV") from None
    found: dict[str, NDArray[Any]] = {}
    for name, value in known.items():
        fields = value.dtype.names if isinstance(value, np.ndarray) and value.ndim == 0 else None
        if fields:
            found |= {field: np.asarray(value[field].item()) for field in fields}
        elif not name.startswith("__"):
            found[name] = np.asarray(value)
    return found
