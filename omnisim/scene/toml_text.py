"""TOML as text: on which line a key stands, and setting keys while keeping comments.

A key is a path as in the parsed document: ("wheels", 0, "drive", "torque"). tomllib gives values without
positions, so `locate` and `rewrite` scan the text again; they only run on text that tomllib has accepted, and so may
take every token at its word.
"""

import json
import re
import tomllib
from bisect import bisect_right
from collections.abc import Iterable
from typing import Any, NamedTuple

KeyPath = tuple[str | int, ...]
MISSING = object()  # where a path leads to nothing
DEEPEST = 20  # keys in a path: no scene needs half of it, and what recurses over a scene can rely on it

_BASIC = r'"(?:[^"\\\n]|\\.)*"'
_LITERAL = r"'[^'\n]*'"
_KEY = re.compile(rf"[A-Za-z0-9_-]+|{_BASIC}|{_LITERAL}")
_DOT = re.compile(r"[ \t]*\.[ \t]*")
_OPEN, _CLOSE, _EQUALS = (re.compile(rf"[ \t]*{mark}[ \t]*") for mark in (r"\[+", r"\]+", "="))
_SPACE = re.compile(r"(?:[\s,]|#[^\n]*)*")  # commas too: nothing has to be told apart in a valid text
_LONG_BASIC = r'"""(?:[^\\]|\\.)*?"""(?:"{0,2})'  # up to two quotes may stand before the closing three
_LONG_LITERAL = r"'''.*?'''(?:'{0,2})"
_SCALAR = re.compile(rf"{_LONG_BASIC}|{_LONG_LITERAL}|{_BASIC}|{_LITERAL}|[^,\]}}#\n]+", re.DOTALL)

_CHAIN = re.compile(rf"(?:^|[{{,])[ \t]*(?:\[{{1,2}}[ \t]*)?(?:(?:{_KEY.pattern})[ \t]*\.[ \t]*){{100}}", re.MULTILINE)


class TooDeep(ValueError):
    """A path of more than DEEPEST keys, on this `line`."""

    def __init__(self, line: int):
        self.line = line
        super().__init__(f"line {line}: keys are nested more than {DEEPEST} deep")


class _Statement(NamedTuple):
    """A header, or a key with its value, which begins at `value`; from `begin` to `end` in the text."""

    path: KeyPath
    begin: int
    value: int
    end: int


def locate(text: str) -> dict[KeyPath, int]:
    """Line number (from 1) of every key, table and list entry of a valid TOML text; 1 for the root ().

    Raises TooDeep.
    """
    return _Scan(text).lines


def long_key(text: str) -> int | None:
    """The line of a key with more than a hundred dots, if there is one; tomllib takes quadratic time for such keys."""
    found = _CHAIN.search(text)
    return text.count("\n", 0, found.end()) + 1 if found else None


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
            shown += ("." if shown else "") + shortened(part if _is_bare(part) else repr(part))
    return shown


def shortened(text: str, width: int = 60) -> str:
    """The text, cut where it gets long."""
    return text if len(text) <= width else f"{text[: width - 3]}..."


def show_value(value: Any, width: int = 60) -> str:
    """A value on one line, about as TOML writes it, cut where it gets long."""
    if isinstance(value, bool):
        shown = str(value).lower()
    elif isinstance(value, dict):
        pairs = (f"{show_path((key,))} = {show_value(entry, width)}" for key, entry in value.items())
        shown = f"{{{', '.join(pairs)}}}"
    elif isinstance(value, list | tuple):
        shown = f"[{', '.join(show_value(entry, width) for entry in value)}]"
    elif isinstance(value, int) and value.bit_length() > 64:
        shown = hex(value)  # Python refuses to write the decimals of a very long one
    else:
        shown = repr(value) if isinstance(value, str | int | float) else str(value)
    return shortened(shown, width)


def is_deeper(value: Any, most: int) -> bool:
    """Whether a path in `value` has more than `most` keys; without recursion, which a deep value would exhaust."""
    level = [value] if isinstance(value, dict | list) else []
    for _ in range(most):
        nested = (entry.values() if isinstance(entry, dict) else entry for entry in level)
        level = [entry for entries in nested for entry in entries if isinstance(entry, dict | list)]
    return most < 0 or any(level)


def value_at(data: Any, path: KeyPath) -> Any:
    """The value under a path, or MISSING."""
    for part in path:
        if isinstance(data, dict if isinstance(part, str) else list | tuple):
            keys: Any = data if isinstance(part, str) else range(len(data))
            data = data[part] if part in keys else MISSING  # type: ignore[index]
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

    Where a layout defeats this, comments are lost, never a value.
    """
    try:
        edited = _spliced(text, _splices(_Scan(text), [path for path, _ in edits], data))
        if tomllib.loads(edited) == data:
            return edited
    except (ValueError, TypeError, KeyError):
        pass
    import tomlkit  # here, since it is slow to import and hardly ever needed

    return tomlkit.dumps(data)


def write_value(value: Any) -> str:
    """A value on one line, as TOML."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        pairs = (f"{_dotted((key,))} = {write_value(entry)}" for key, entry in value.items())
        return f"{{ {', '.join(pairs)} }}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(write_value, value)) + "]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")  # the same escapes, but for DEL
    return repr(value) if isinstance(value, int | float) else value.isoformat()


def _splices(scan: "_Scan", paths: Iterable[KeyPath], data: dict[str, Any]) -> dict[tuple[int, int], str]:
    """What has to stand at which places of the text for the values under `paths` to be those of `data`.

    The value of a key is replaced as a whole, with what is nested in it. A table that is spread over statements, and is
    now a value, is taken out. A new key stands below the last one of the innermost table that has a header.
    """
    found: dict[tuple[int, int], str] = {}
    edited = dict.fromkeys(paths)
    for path in edited:
        if any(path[:end] in edited for end in range(len(path))):
            continue  # it is part of a value that is written anyway
        outer = next((path[:end] for end in range(len(path) + 1) if path[:end] in scan.pairs), None)
        if outer is not None and value_at(data, outer) is not MISSING:
            pair = scan.pairs[outer]
            found[pair.value, pair.end] = write_value(value_at(data, outer))
            continue
        for statement in scan.statements:
            if statement.path[: len(path)] == path:
                found[statement.begin, statement.end] = ""
        if value_at(data, path) is not MISSING:
            table = next(path[:end] for end in range(len(path) - 1, -1, -1) if path[:end] in scan.tails)
            line = f"{_dotted(path[len(table) :])} = {write_value(value_at(data, path))}"
            at = scan.line_end(scan.tails[table])
            found[at, at] = found.get((at, at), "") + (f"\n{line}" if at else f"{line}\n")
    return found


def _spliced(text: str, splices: dict[tuple[int, int], str]) -> str:
    parts: list[str] = []
    at = 0
    for (begin, end), new in sorted(splices.items()):
        parts += text[at:begin], new
        at = end
    return "".join([*parts, text[at:]])


def _is_bare(key: str) -> bool:
    return re.fullmatch(r"[A-Za-z0-9_-]+", key) is not None


def _dotted(path: KeyPath) -> str:
    """A path of keys as TOML; TypeError for an index."""
    return ".".join(key if isinstance(key, str) and _is_bare(key) else write_value(key) for key in path)


def _read_key(text: str, at: int) -> tuple[tuple[str, ...], int]:
    """The dotted key that starts at a position, and the position after it."""
    parts = []
    while True:
        token = _KEY.match(text, at)
        if not token:
            raise ValueError(f"no TOML key at character {at}")
        key = token.group()
        parts.append(key if _is_bare(key) else next(iter(tomllib.loads(f"{key} = 0"))))
        dot = _DOT.match(text, token.end())
        if not dot:
            return tuple(parts), token.end()
        at = dot.end()


class _Scan:
    """One pass over the text; `at` is the position, `lines` the line of every path.

    statements  headers and pairs, in order; `pairs` by path, those in inline tables left out
    tails       where the last key of each table with a header ends, or the header of one without keys
    """

    def __init__(self, text: str):
        self.text, self.at = text, 0
        self.newlines = [found.start() for found in re.finditer("\n", text)]
        self.lines: dict[KeyPath, int] = {(): 1}
        self.counts: dict[KeyPath, int] = {}  # entries so far of each [[array]]
        self.statements: list[_Statement] = []
        self.pairs: dict[KeyPath, _Statement] = {}
        self.tails: dict[KeyPath, int] = {(): 0}
        table: KeyPath = ()
        self.skip(_SPACE)
        while self.at < len(text):
            begin = self.at
            if text[begin] == "[":
                table = self.header()
                self.statements.append(_Statement(table, begin, begin, self.at))
            else:
                path, value = self.pair(table)
                end = value + len(text[value : self.at].rstrip())
                self.pairs[path] = _Statement(path, begin, value, end)
                self.statements.append(self.pairs[path])
            self.tails[table] = self.statements[-1].end
            self.skip(_SPACE)

    def line_end(self, at: int) -> int:
        """Where the line of a position ends, before its newline; 0 for 0, the top of the text."""
        end = self.text.find("\n", at) if at else 0
        return len(self.text) if end < 0 else end

    def skip(self, pattern: re.Pattern) -> None:
        found = pattern.match(self.text, self.at)
        if not found:
            raise ValueError(f"cannot read TOML at character {self.at}")
        self.at = found.end()

    def mark(self, path: KeyPath, table: KeyPath = ()) -> None:
        """The current line for `path`, and for those parents below `table` that have none yet. Raises TooDeep."""
        line = self.line()
        if len(path) > DEEPEST:
            raise TooDeep(line)
        for end in range(len(table) + 1, len(path)):
            self.lines.setdefault(path[:end], line)
        self.lines[path] = line

    def line(self) -> int:
        return bisect_right(self.newlines, self.at) + 1

    def key(self) -> tuple[str, ...]:
        path, self.at = _read_key(self.text, self.at)
        if len(path) > DEEPEST:
            raise TooDeep(self.line())
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

    def pair(self, table: KeyPath) -> tuple[KeyPath, int]:
        """The path of the key, and where its value begins."""
        path = (*table, *self.key())
        self.mark(path, table)
        self.skip(_EQUALS)
        begin = self.at
        self.value(path)
        return path, begin

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
