"""Settings and fixtures of all tests."""

from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import settings

settings.register_profile("ftcfa", deadline=None)  # a busy machine is no defect
settings.load_profile("ftcfa")


@pytest.fixture
def urdf(tmp_path: Path) -> Callable[..., Path]:
    """Writes a URDF text or bytes to a file."""

    def write(text: str | bytes, name: str = "arm.urdf") -> Path:
        file = tmp_path / name
        file.write_bytes(text if isinstance(text, bytes) else text.encode())
        return file

    return write
