"""Data as JSON has it."""

import json

import numpy as np

from sensorless.plain_json import plain


def test_what_is_no_number_becomes_null() -> None:
    data = {1: (np.nan, np.inf, np.float64(2.5)), "n": np.int64(3), "b": True, "x": np.eye(2)}
    want = '{"1": [null, null, 2.5], "n": 3, "b": true, "x": [[1.0, 0.0], [0.0, 1.0]]}'
    assert json.dumps(plain(data), allow_nan=False) == want


def test_floats_are_rounded_where_asked() -> None:
    assert plain([1.23456789, 12345], 3) == [1.23, 12345]
