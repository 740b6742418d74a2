"""The recipes of CONTRIBUTING.md, followed to the letter in a copy of the checkout."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[1]
COPIED = ("ftcfa", "robots", "tests", "pyproject.toml")
BLOCK = re.compile(r"```(python|diff|bash)\n(.*?)```", re.DOTALL)


def recipes():
    """Title and blocks (language, text) of every recipe."""
    text = (CHECKOUT / "CONTRIBUTING.md").read_text()
    recipes = text.split("## Recipes")[1].split("\n## ")[0]
    sections = [section.split("\n", 1) for section in recipes.split("\n### ")[1:]]
    return {title: BLOCK.findall(body) for title, body in sections}


def insert(folder, change):
    """Add the lines marked + of a diff after the line above them, which stands once in the file."""
    file, *lines = change.splitlines()
    path = folder / file.removeprefix("# ")
    (before,) = [line[1:] for line in lines if not line.startswith("+")]
    added = [line[1:] for line in lines if line.startswith("+")]
    assert len(added) == 1  # one line is what a recipe promises
    text = path.read_text()
    assert text.count(f"{before}\n") == 1
    path.write_text(text.replace(f"{before}\n", f"{before}\n{added[0]}\n"))


def follow(folder, blocks):
    """Do what the blocks of a recipe say, and count them by language."""
    for language, text in blocks:
        if language == "python":
            (folder / text.splitlines()[0].removeprefix("# ")).write_text(text)
        elif language == "diff":
            insert(folder, text)
        else:
            environment = Path(sys.executable).parent
            done = subprocess.run(
                ["bash", "-euc", text],
                cwd=folder,
                env={"PYTHONPATH": str(folder), "PATH": f"{environment}:/usr/bin:/bin"},
                capture_output=True,
                text=True,
            )
            assert done.returncode == 0, done.stdout + done.stderr
    return [language for language, _ in blocks]


def test_there_is_a_recipe_for_every_kind_of_part():
    assert list(recipes()) == [
        "A controller",
        "A noise input",
        "An excitation",
        "A metric",
        "A command",
    ]


@pytest.mark.slow
@pytest.mark.parametrize("title", recipes())
def test_a_recipe_works_as_written(tmp_path, title):
    for name in COPIED:
        source = CHECKOUT / name
        copy = shutil.copytree if source.is_dir() else shutil.copy
        copy(source, tmp_path / name)
    assert follow(tmp_path, recipes()[title]) == ["python", "diff", "bash"]
