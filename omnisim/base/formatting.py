"""Facts for people: names in a column, the text beside them wrapped to a width that terminals have.

And text that a terminal only shows: what would act on it is written out.
"""

import re
import textwrap
from collections.abc import Mapping, Sequence

WIDTH = 110  # columns
# what moves the cursor, colours, reorders or breaks lines; lone surrogates stand for bytes that are no UTF-8
ACTING = re.compile("[\x00-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")


def visible(text: str, but: str = "") -> str:
    """The text with every control character, except those in `but`, as \\xNN (\\uNNNN)."""
    return ACTING.sub(lambda found: found[0] if found[0] in but else _escaped(ord(found[0])), text)


def _escaped(code: int) -> str:
    byte = code - 0xDC00 if 0xDC80 <= code <= 0xDCFF else code  # as Python reads a byte that is no UTF-8
    return f"\\x{byte:02x}" if byte < 0x100 else f"\\u{byte:04x}"


def aligned(facts: Mapping[str, str], indent: str = "") -> str:
    """One fact below the other, the names in a column; those without text are left out."""
    told = {name: text for name, text in facts.items() if text}
    width = max(len(name) for name in told) + 2
    return "\n".join(hanging(f"{indent}{name:<{width}}", text) for name, text in told.items())


def hanging(head: str, text: str) -> str:
    """`head`, and `text` beside it in lines of at most WIDTH columns; words that are longer stay whole."""
    lines = textwrap.wrap(text, max(WIDTH - len(head), 24), break_long_words=False, break_on_hyphens=False)
    return head + f"\n{'':<{len(head)}}".join(lines)


def columns(rows: Sequence[Sequence[str]], indent: str = "") -> str:
    """A table: every column as wide as its longest cell; the last one is wrapped. Empty without rows."""
    widths = [max(map(len, column)) for column in list(zip(*rows, strict=True))[:-1]]
    heads = ("  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=False)) for row in rows)
    return "\n".join(hanging(f"{indent}{head}  ", row[-1]) for head, row in zip(heads, rows, strict=True))
