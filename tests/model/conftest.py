"""The arms that every property is checked on."""

from collections.abc import Callable
from pathlib import Path

import pytest

from ftcfa import Arm, load_arm
from ftcfa.model.urdf.catalogue import catalogue


@pytest.fixture(scope="session", params=list(catalogue()))
def arm(request: pytest.FixtureRequest) -> Arm:
    """Every arm of the catalogue in turn."""
    return load_arm(request.param)


@pytest.fixture
def urdf(tmp_path: Path) -> Callable[..., Path]:
    """Writes a URDF text or bytes to a file."""

    def write(text: str | bytes, name: str = "arm.urdf") -> Path:
        file = tmp_path / name
        file.write_bytes(text if isinstance(text, bytes) else text.encode())
        return file

    return write
