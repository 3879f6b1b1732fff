"""Pictures say nothing on the terminal."""

import warnings

import pytest

pytest.importorskip("matplotlib")

from sensorless.plots.figure import new_figure, png


def test_a_letter_that_the_font_lacks_is_no_warning() -> None:
    figure, ((ax,),) = new_figure((2.0, 2.0))
    ax.set_title("\u4f3a\u670d\u7535\u673a")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert png(figure).startswith(b"\x89PNG")
