"""Tables, facts and numbers on a terminal, all in one look, wide or narrow."""

from collections.abc import Iterable

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ftcfa.errors import plain

COLUMNS = {
    "l": {"no_wrap": True},
    "r": {"no_wrap": True, "justify": "right"},
    "f": {"overflow": "fold", "min_width": 10},
}
"""Options of a column of `print_table`, by letter: left, right, and left with folded lines."""


def print_table(
    heads: Iterable[str], rows: Iterable[Iterable[str | Text]], console: Console, align: str = "lr"
) -> None:
    """Print a table with a ruled head and no frame, closer together if it is too wide.

    Args:
        heads: Text above each column.
        rows: Cells of each row.
        console: Where to print.
        align: A letter for each column, `COLUMNS`; the last one holds for all that follow.
    """
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, collapse_padding=True)
    for i, head in enumerate(heads):
        table.add_column(literal(head), **COLUMNS[align[min(i, len(align) - 1)]])  # type: ignore[arg-type]
    for row in rows:
        table.add_row(*map(literal, row))
    unbounded = console.options.update(max_width=10_000, markup=False)
    if console.measure(table, options=unbounded).maximum > console.width:
        table.padding = (0, 0)
    console.print(table, highlight=False, markup=False)


def print_facts(
    facts: Iterable[Iterable[str | Text]], console: Console, style: str = "dim"
) -> None:
    """Print labels and their texts in columns, the texts folded to the width.

    Args:
        facts: Label and texts of each row.
        console: Where to print.
        style: Style of the labels.
    """
    table = Table.grid(padding=(0, 2))
    table.add_column(style=style, no_wrap=True)
    table.add_column(overflow="fold")
    for fact in facts:
        table.add_row(*map(literal, fact))
    console.print(table, highlight=False, markup=False)


def print_line(text: str, console: Console, style: str = "") -> None:
    """Print a text as it is, without markup and highlighting."""
    console.print(literal(text), style=style, highlight=False)


def literal(text: str | Text) -> Text:
    """A text as it is written: markup, emoji codes, links and control characters mean nothing."""
    if isinstance(text, Text):
        return text
    return Text("\n".join(map(plain, text.split("\n"))))


def number(value: float | None, spec: str = ".4g", missing: str = "-") -> str:
    """A number as text, or what stands for a missing one."""
    return missing if value is None else format(value, spec)
