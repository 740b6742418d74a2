"""The arms that every property is checked on."""

import pytest

from ftcfa import Arm, load_arm
from ftcfa.model.urdf.catalogue import catalogue


@pytest.fixture(scope="session", params=list(catalogue()))
def arm(request: pytest.FixtureRequest) -> Arm:
    """Every arm of the catalogue in turn."""
    return load_arm(request.param)
