"""Tables and numbers on a terminal, all in one look, wide or narrow."""

from collections.abc import Iterable

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text


def plain_table() -> Table:
    """An empty table with a ruled head and no frame."""
    return Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, collapse_padding=True)


def print_fitted(table: Table, console: Console) -> None:
    """Print a table, its columns closer together if it is wider than the console."""
    unbounded = console.options.update(max_width=10_000)
    if console.measure(table, options=unbounded).maximum > console.width:
        table.padding = (0, 0)
    console.print(table, highlight=False)


def print_facts(facts: Iterable[tuple[str, str | Text]], console: Console) -> None:
    """Print labels and their texts in two columns, the texts folded to the width.

    Args:
        facts: Label and text of each row; a text is a str or rich's Text.
        console: Where to print.
    """
    table = Table.grid(padding=(0, 2))
    table.add_column(style="dim", no_wrap=True)
    table.add_column(overflow="fold")
    for label, text in facts:
        table.add_row(label, text)
    console.print(table, highlight=False, markup=False)


def number(value: float | None, spec: str = ".4g", missing: str = "-") -> str:
    """A number as text, or what stands for a missing one."""
    return missing if value is None else format(value, spec)
