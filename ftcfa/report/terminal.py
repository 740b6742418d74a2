"""Tables on a terminal, all in one look, wide or narrow."""

from rich import box
from rich.console import Console
from rich.table import Table


def plain_table() -> Table:
    """An empty table with a ruled head and no frame."""
    return Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, collapse_padding=True)


def print_fitted(table: Table, console: Console) -> None:
    """Print a table, its columns closer together if it is wider than the console."""
    unbounded = console.options.update(max_width=10_000)
    if console.measure(table, options=unbounded).maximum > console.width:
        table.padding = (0, 0)
    console.print(table, highlight=False)
