"""The house: imports go one way and in no circle, libraries have one home, rooms stay small."""

import ast
import re
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import ftcfa

PACKAGE = Path(ftcfa.__file__).parent

LAYERS = (
    {"errors"},
    {"arrays", "files", "coefficients"},
    {"checks", "portable"},
    {"streams"},
    {"parts"},
    {"model", "statistics"},  # beside each other: neither knows the other
    {"vibration", "control"},
    {"hardware"},
    {"loop"},
    {"description"},
    {"engine"},
    {"study"},
    {"theory"},
    {"experiment"},
    {"starter"},
    {"report"},
    {"__init__"},  # the public names
    {"cli"},
    {"__main__"},
)
NAMED = re.compile(r"ftcfa(\.\w+)+:\w+")
"""A name in a registry."""
LONGEST_MODULE = 300
"""Lines of a module."""
LONGEST_FUNCTION = 60
"""Lines of a function, its docstring not counted."""
HOMES = {
    "pinocchio": ("model.arm", "model.pinocchio_model", "model.urdf.model"),
    "matplotlib": ("report",),
    "plotly": ("report",),
}
"""Libraries, and the modules or folders that may import each."""


def modules(package):
    """Every module's name below the package, such as ``control.ftcf``, with its file."""
    for file in sorted(package.rglob("*.py")):
        yield ".".join(file.relative_to(package).with_suffix("").parts), file


def imported(file, package):
    """Absolute names that a file imports, or names in a text as ``module:name``."""
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                folder = file.parents[node.level - 1].relative_to(package.parent)
                base = ".".join([*folder.parts, *filter(None, [base])])
            yield from (f"{base}.{alias.name}" for alias in node.names)
            yield from [base] if base != package.name else []
        elif isinstance(node, ast.Constant) and NAMED.fullmatch(str(node.value)):
            yield node.value.split(":")[0]


def layer(part):
    """Number of the layer of a folder or module of the package, by its name."""
    return next((i for i, parts in enumerate(LAYERS) if part in parts), None)


def wrong_imports(package):
    """Imports against the order, as (importer, imported)."""
    parts = {path.stem for path in package.iterdir()}
    for module, file in modules(package):
        own = module.split(".")[0]
        for target in imported(file, package):
            names = target.split(".")
            if names[0] == package.name:
                part = names[1] if names[1:] and names[1] in parts else "__init__"
                if part != own and layer(part) >= layer(own):
                    yield module, target


def strangers(package):
    """Imports of libraries away from their homes, as (importer, imported)."""
    for module, file in modules(package):
        for target in imported(file, package):
            homes = HOMES.get(target.split(".")[0])
            if homes and not any(f"{module}.".startswith(f"{home}.") for home in homes):
                yield module, target


def circle(package):
    """Names of modules that import one another in a circle; empty if there is none."""
    names = {f"{package.name}.{module}" for module, _ in modules(package)}
    graph = {
        f"{package.name}.{module}": names & set(imported(file, package))
        for module, file in modules(package)
    }
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return error.args[1]
    return []


def lengths(file):
    """Names and lengths of the functions of a file, docstrings not counted [lines]."""
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.FunctionDef):
            lines = node.end_lineno - node.lineno + 1
            if ast.get_docstring(node) is not None:
                lines -= node.body[0].end_lineno - node.body[0].lineno + 1
            yield node.name, lines


def test_every_part_has_its_layer():
    assert [module for module, _ in modules(PACKAGE) if layer(module.split(".")[0]) is None] == []


def test_imports_go_one_way():
    assert list(wrong_imports(PACKAGE)) == []


def test_no_modules_import_one_another_in_a_circle():
    assert circle(PACKAGE) == []


def test_modules_and_functions_are_short():
    long = [
        module for module, file in modules(PACKAGE)
        if len(file.read_text().splitlines()) > LONGEST_MODULE
    ]  # fmt: skip
    for module, file in modules(PACKAGE):
        long += [f"{module}.{name}" for name, lines in lengths(file) if lines > LONGEST_FUNCTION]
    assert long == []


def test_libraries_stay_at_home():
    assert list(strangers(PACKAGE)) == []


@pytest.mark.parametrize(
    ("module", "line", "found"),
    [
        ("control/law.py", "from ftcfa.vibration.excitation import Excitation", True),
        ("control/law.py", "import ftcfa.loop.closed_loop", True),
        ("control/law.py", "def f():\n    from ftcfa import loop", True),
        ("control/law.py", "from ..loop import closed_loop", True),
        ("control/law.py", "from ftcfa import simulate", True),
        ("control/law.py", "LAWS = 'ftcfa.loop.closed_loop:ClosedLoop'", True),
        ("vibration/noise.py", "from ftcfa.control.protocol import Signals", True),
        ("errors.py", "from ftcfa.arrays import Array", True),
        ("model/traced.py", "import pinocchio as pin", True),
        ("study/plot.py", "from matplotlib import pyplot", True),
        ("control/law.py", "from ftcfa.control.filters import ImplicitFilter", False),
        ("control/law.py", "from . import filters", False),
        ("control/law.py", "from ftcfa.model.arm import Arm", False),
        ("cli.py", "from ftcfa import simulate", False),
        ("model/arm.py", "import pinocchio", False),
        ("report/figures.py", "import matplotlib.pyplot as plt", False),
    ],
)
def test_the_walk_finds_what_it_looks_for(tmp_path, module, line, found):
    package = tmp_path / "ftcfa"
    for part in ("model", "vibration", "control", "loop", "engine", "study", "report"):
        (package / part).mkdir(parents=True)
    (package / module).write_text(line)
    assert bool([*wrong_imports(package), *strangers(package)]) == found


def test_a_circle_within_a_room_is_found(tmp_path):
    room = tmp_path / "ftcfa" / "loop"
    room.mkdir(parents=True)
    (room / "plant.py").write_text("def f():\n    from ftcfa.loop import path")
    (room / "path.py").write_text("from ftcfa.loop.plant import f")
    assert set(circle(tmp_path / "ftcfa")) == {"ftcfa.loop.plant", "ftcfa.loop.path"}
    (room / "plant.py").write_text("import numpy")
    assert circle(tmp_path / "ftcfa") == []


def test_a_docstring_does_not_count_as_length(tmp_path):
    file = tmp_path / "law.py"
    file.write_text('def f():\n    """One.\n\n    Two.\n    """\n    return 1\n')
    assert list(lengths(file)) == [("f", 2)]
