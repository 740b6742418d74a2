"""What every refusal has to look like."""

from pathlib import Path

import pytest

from ftcfa import UrdfError, load_arm


def sentence_of(file: Path | str, **options: object) -> str:
    """The sentence with which a file is refused; it must be one, without a traceback."""
    with pytest.raises(UrdfError) as caught:
        load_arm(file, **options)  # type: ignore[arg-type]
    sentence = str(caught.value)
    assert "\n" not in sentence
    assert "Traceback" not in sentence
    assert len(sentence) < 500
    return sentence
