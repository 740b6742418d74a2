"""The README's Python and its files, run and read as they stand; names that READMEs mention."""

import re
import runpy
from pathlib import Path
from pkgutil import resolve_name

import pytest

from ftcfa import read_table

README = Path(__file__).parents[1] / "README.md"


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README.read_text(), re.DOTALL)


def test_the_code_blocks_run_one_after_the_other(capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    for text in blocks("toml"):
        Path(re.match(r"# (\S+)", text)[1]).write_text(text)
    assert len(blocks("python")) >= 5
    names = {}
    for block in blocks("python"):
        exec(block, names)
    printed = capsys.readouterr().out
    assert float(printed.split()[0]) < 0.03  # Panda's error in the last half of its run [rad]
    assert names["rms"].shape == (1000,)
    assert names["floor"].shape == (4000, 3)
    assert Path("again.toml").exists()
    assert list(read_table("my_site.toml")) == ["hall"]


@pytest.mark.parametrize("file", ["README.md", "ftcfa/README.md"])
def test_numbers_are_those_of_the_records(file):
    script = runpy.run_path(str(README.parent / "scripts" / "readme.py"))
    assert script["rewritten"](file) == (README.parent / file).read_text()


def test_every_name_in_the_guide_of_the_package_exists():
    guide = (README.parent / "ftcfa" / "README.md").read_text()
    names = set(re.findall(r"`(ftcfa(?:\.\w+)+)`", guide))
    assert len(names) > 40
    for name in names:
        resolve_name(name)
    paths = set(re.findall(r"\]\(([^)#:]+)\)", guide))
    assert [path for path in paths if not (README.parent / "ftcfa" / path).exists()] == []
