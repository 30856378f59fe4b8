"""TOML as text: on which line a key stands, and setting keys while keeping comments.

A key is a path as in the parsed document: ("wheels", 0, "drive", "torque"). tomllib gives values without
positions, so `locate` scans the text again; it only runs on text that tomllib has accepted, and so may take
every token at its word.
"""

import re
import tomllib
from bisect import bisect_right
from collections.abc import Iterable
from typing import Any

KeyPath = tuple[str | int, ...]
MISSING = object()  # where a path leads to nothing

_BASIC = r'"(?:[^"\\\n]|\\.)*"'
_LITERAL = r"'[^'\n]*'"
_KEY = re.compile(rf"[A-Za-z0-9_-]+|{_BASIC}|{_LITERAL}")
_DOT = re.compile(r"[ \t]*\.[ \t]*")
_OPEN, _CLOSE, _EQUALS = (re.compile(rf"[ \t]*{mark}[ \t]*") for mark in (r"\[+", r"\]+", "="))
_SPACE = re.compile(r"(?:[\s,]|#[^\n]*)*")  # commas too: nothing has to be told apart in a valid text
_LONG_BASIC = r'"""(?:[^\\]|\\.)*?"""(?:"{0,2})'  # up to two quotes may stand before the closing three
_LONG_LITERAL = r"'''.*?'''(?:'{0,2})"
_SCALAR = re.compile(rf"{_LONG_BASIC}|{_LONG_LITERAL}|{_BASIC}|{_LITERAL}|[^,\]}}#\n]+", re.DOTALL)


def locate(text: str) -> dict[KeyPath, int]:
    """Line number (from 1) of every key, table and list entry of a valid TOML text; 1 for the root ()."""
    return _Scan(text).lines


def split_key(key: str) -> tuple[str, ...]:
    """The parts of a dotted key, quoted ones included; ValueError when it is none."""
    path, end = _read_key(key, 0)
    if end != len(key):
        raise ValueError(f"not a dotted key: {key!r}")
    return path


def show_path(path: KeyPath) -> str:
    """A path as a user would write it: wheels[0].drive.torque."""
    shown = ""
    for part in path:
        if isinstance(part, int):
            shown += f"[{part}]"
        else:
            bare = re.fullmatch(r"[A-Za-z0-9_-]+", part)
            shown += ("." if shown else "") + (part if bare else repr(part))
    return shown


def show_value(value: Any, width: int = 60) -> str:
    """A value on one line, about as TOML writes it, cut where it gets long."""
    if isinstance(value, bool):
        shown = str(value).lower()
    elif isinstance(value, dict):
        pairs = (f"{show_path((key,))} = {show_value(entry)}" for key, entry in value.items())
        shown = f"{{{', '.join(pairs)}}}"
    elif isinstance(value, list | tuple):
        shown = f"[{', '.join(map(show_value, value))}]"
    elif isinstance(value, int) and value.bit_length() > 64:
        shown = hex(value)  # Python refuses to write the decimals of a very long one
    else:
        shown = repr(value) if isinstance(value, str | int | float) else str(value)
    return shown if len(shown) <= width else f"{shown[: width - 3]}..."


def value_at(data: Any, path: KeyPath) -> Any:
    """The value under a path, or MISSING."""
    for part in path:
        if isinstance(data, dict if isinstance(part, str) else list | tuple):
            keys = data if isinstance(part, str) else range(len(data))
            data = data[part] if part in keys else MISSING
        else:
            return MISSING
    return data


def assign(tree: Any, path: KeyPath, value: Any) -> None:
    """Sets the value under a path, with new tables where there are none, in a plain or a tomlkit document; MISSING
    takes the key away.
    """
    for part in path[:-1]:
        tree = tree.setdefault(part, {}) if isinstance(tree, dict) else tree[part]
    if value is MISSING:
        del tree[path[-1]]
    else:
        tree[path[-1]] = value


def rewrite(text: str, edits: Iterable[tuple[KeyPath, Any]], data: dict[str, Any]) -> str:
    """`text` with values set and comments kept; `data` is what the result has to mean.

    tomlkit does not survive every legal layout. Where it fails the comments are lost, never a value.
    """
    import tomlkit  # here, since it is slow to import and most runs set nothing
    from tomlkit.exceptions import TOMLKitError

    try:
        document = tomlkit.parse(text)
        for path, value in edits:
            assign(document, path, value)
        edited = tomlkit.dumps(document)
        if tomllib.loads(edited) == data:
            return edited
    except (TOMLKitError, ValueError, TypeError, LookupError):
        pass
    return tomlkit.dumps(data)


def _read_key(text: str, at: int) -> tuple[tuple[str, ...], int]:
    """The dotted key that starts at a position, and the position after it."""
    parts = []
    while True:
        token = _KEY.match(text, at)
        if not token:
            raise ValueError(f"no TOML key at character {at}")
        parts.append(next(iter(tomllib.loads(f"{token.group()} = 0"))))
        dot = _DOT.match(text, token.end())
        if not dot:
            return tuple(parts), token.end()
        at = dot.end()


class _Scan:
    """One pass over the text; `at` is the position, `lines` the result."""

    def __init__(self, text: str):
        self.text, self.at = text, 0
        self.newlines = [found.start() for found in re.finditer("\n", text)]
        self.lines: dict[KeyPath, int] = {(): 1}
        self.counts: dict[KeyPath, int] = {}  # entries so far of each [[array]]
        table: KeyPath = ()
        self.skip(_SPACE)
        while self.at < len(text):
            if text[self.at] == "[":
                table = self.header()
            else:
                self.pair(table)
            self.skip(_SPACE)

    def skip(self, pattern: re.Pattern) -> None:
        found = pattern.match(self.text, self.at)
        if not found:
            raise ValueError(f"cannot read TOML at character {self.at}")
        self.at = found.end()

    def mark(self, path: KeyPath, table: KeyPath = ()) -> None:
        """The current line for `path`, and for those parents below `table` that have none yet."""
        line = bisect_right(self.newlines, self.at) + 1
        for end in range(len(table) + 1, len(path)):
            self.lines.setdefault(path[:end], line)
        self.lines[path] = line

    def key(self) -> tuple[str, ...]:
        path, self.at = _read_key(self.text, self.at)
        return path

    def header(self) -> KeyPath:
        many = self.text.startswith("[[", self.at)
        self.skip(_OPEN)
        path: KeyPath = ()
        *parents, last = self.key()
        for part in parents:
            path = self.newest((*path, part))
        path = (*path, last)
        if many:
            self.counts[path] = self.counts.get(path, 0) + 1
            path = self.newest(path)
        self.mark(path)
        self.skip(_CLOSE)
        return path

    def newest(self, path: KeyPath) -> KeyPath:
        """The last entry of an array of tables; the path itself for a table."""
        return (*path, self.counts[path] - 1) if path in self.counts else path

    def pair(self, table: KeyPath) -> None:
        path = (*table, *self.key())
        self.mark(path, table)
        self.skip(_EQUALS)
        self.value(path)

    def value(self, path: KeyPath) -> None:
        opening = self.text[self.at]
        if opening not in "[{":
            self.skip(_SCALAR)
            return
        self.at += 1
        self.skip(_SPACE)
        index = 0
        while self.text[self.at] not in "]}":
            if opening == "{":
                self.pair(path)
            else:
                self.mark((*path, index), path)
                self.value((*path, index))
                index += 1
            self.skip(_SPACE)
        self.at += 1
