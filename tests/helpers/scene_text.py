"""Scenes as text with something changed, and what is said of their defects."""

import pytest

from omnisim.scene.scene import SceneError, parse


def replaced(text: str, *pairs: str) -> str:
    """A scene with each old text replaced by the new one after it."""
    for old, new in zip(pairs[::2], pairs[1::2], strict=True):
        assert old in text
        text = text.replace(old, new, 1)
    return text


# of the libraries behind, which no message shows
THEIR_WORDS = (
    "pydantic", "input should", "traceback", "tuple", "nonetype", "none required", "errors.pydantic", "value_error",
)  # fmt: skip


def message(text: str) -> str:
    with pytest.raises(SceneError) as error:
        parse(text, "s.toml")
    shown = str(error.value)
    assert not [word for word in THEIR_WORDS if word in shown.lower()]
    return shown


def assert_one_line(good: str, old: str, new: str, line: int, key: str, allowed: str) -> None:
    """The defect `new` in place of `old` gives one line with file, line, key and value, and what is allowed."""
    text = message(replaced(good, old, new))
    assert "\n" not in text
    assert text.startswith(f"s.toml:{line}: ")
    assert key in text.split(": ", 2)[1]
    assert allowed in text
