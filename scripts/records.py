"""What the modules of README's tables share: the records of the scripts, and Markdown."""

import json
from pathlib import Path
from typing import Any

FIGURES = Path(__file__).parent / "figures"


def record(name: str) -> Any:
    """The record of a script."""
    return json.loads((FIGURES / f"{name}.json").read_text())


def table(heads: list[str], rows: list[list[str]]) -> str:
    """A table in Markdown."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)
