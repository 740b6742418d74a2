"""The practical settling time: hand-made bounds and a decay with a known answer."""

import numpy as np
import pytest

from ftcfa.errors import ParameterError, ShapeError
from ftcfa.statistics.settling import practical_settling_time

NAN = np.nan
TIME = [0.0, 1.0, 2.0, 3.0]


@pytest.mark.parametrize(
    ("bound", "settled"),
    [
        ([9.0, 0.5, 0.5, 0.5], 1.0),
        ([0.5, 0.5, 0.5, 0.5], 0.0),
        ([9.0, 0.5, 1.0, 0.5], 3.0),
        ([9.0, 0.5, NAN, 0.5], 3.0),
        ([9.0, 0.5, 0.5, 1.0], NAN),
        ([0.5, 0.5, 0.5, NAN], NAN),
    ],
)
def test_by_hand(bound, settled):
    np.testing.assert_equal(practical_settling_time(TIME, bound, 1.0), settled)


def test_a_decay():
    """e^(-2 t) + 0.1 < 0.2 from t = log(10)/2."""
    t = np.linspace(0, 5, 5001)
    assert practical_settling_time(t, np.exp(-2 * t) + 0.1, 0.2) == pytest.approx(
        np.log(10) / 2, abs=1e-3
    )


@pytest.mark.parametrize(
    ("arguments", "error", "text"),
    [
        (([], [], 1.0), ShapeError, "time: shape (0,), expected shape (k,), one or more"),
        ((TIME, [1.0], 1.0), ShapeError, "mean_square_bound: shape (1,), expected shape (4,)"),
        ((TIME, TIME, 0.0), ParameterError, "epsilon: 0.0, expected a number > 0 [rad^2]"),
        (([0.0, 0.0], [1.0, 1.0], 1.0), ParameterError, "times that do not rise"),
    ],
)
def test_errors(arguments, error, text):
    with pytest.raises(error) as caught:
        practical_settling_time(*arguments)
    assert text in str(caught.value)
