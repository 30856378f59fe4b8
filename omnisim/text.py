"""Facts for people: names in a column, the text beside them wrapped to a width that terminals have."""

import textwrap
from collections.abc import Mapping

WIDTH = 110  # columns


def aligned(facts: Mapping[str, str], indent: str = "") -> str:
    """One fact below the other, the names in a column; those without text are left out."""
    told = {name: text for name, text in facts.items() if text}
    width = max(len(name) for name in told) + 2
    return "\n".join(hanging(f"{indent}{name:<{width}}", text) for name, text in told.items())


def hanging(head: str, text: str) -> str:
    """`head`, and `text` beside it in lines of at most WIDTH columns; words that are longer stay whole."""
    lines = textwrap.wrap(text, max(WIDTH - len(head), 24), break_long_words=False, break_on_hyphens=False)
    return head + f"\n{'':<{len(head)}}".join(lines)


def columns(rows: list[tuple[str, ...]], indent: str = "") -> str:
    """A table: every column as wide as its longest cell; the last one is wrapped. Empty without rows."""
    widths = [max(map(len, column)) for column in list(zip(*rows, strict=True))[:-1]]
    heads = ("  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=False)) for row in rows)
    return "\n".join(hanging(f"{indent}{head}  ", row[-1]) for head, row in zip(heads, rows, strict=True))
