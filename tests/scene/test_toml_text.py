"""Where keys stand in a TOML text, and setting keys without losing comments."""

import tomllib

import pytest

from omnisim.scene.toml_text import (
    MISSING,
    assign,
    is_deeper,
    locate,
    long_key,
    rewrite,
    show_path,
    show_value,
    split_key,
    value_at,
)

pytestmark = pytest.mark.short

TEXT = """\
title = "a"              # line 1
"quoted key" = 1
'literal' . "b\\u0061se" = 2
text = '''
[not_a_table]
key = 1'''
basic = \"\"\"
a \\\"\"\" = b
\"\"\"
list = [
    1.0,  # [no_table]
    [2, 3],

    { deep = 4, other.part = "]" },
]

[a.b]
c = { d = [1, 2], e = 1979-05-27 07:32:00, f = {} }
[a]
z = 1
[[wheels]]
name = "x"
[wheels.drive]
kind = "free"
  [[wheels]]  # indented
  name = 'y'
  [[wheels.knots]]
  t = 0
  [[wheels.knots]]
  t = 1
"""
LINES = {
    (): 1,
    ("title",): 1,
    ("quoted key",): 2,
    ("literal",): 3,
    ("literal", "base"): 3,
    ("text",): 4,
    ("basic",): 7,
    ("list",): 10,
    ("list", 0): 11,
    ("list", 1): 12,
    ("list", 1, 1): 12,
    ("list", 2): 14,
    ("list", 2, "deep"): 14,
    ("list", 2, "other", "part"): 14,
    ("a", "b"): 17,
    ("a", "b", "c"): 18,
    ("a", "b", "c", "d", 1): 18,
    ("a", "b", "c", "e"): 18,
    ("a", "b", "c", "f"): 18,
    ("a",): 19,
    ("a", "z"): 20,
    ("wheels",): 21,
    ("wheels", 0): 21,
    ("wheels", 0, "name"): 22,
    ("wheels", 0, "drive"): 23,
    ("wheels", 0, "drive", "kind"): 24,
    ("wheels", 1): 25,
    ("wheels", 1, "name"): 26,
    ("wheels", 1, "knots", 0): 27,
    ("wheels", 1, "knots", 0, "t"): 28,
    ("wheels", 1, "knots", 1, "t"): 30,
}


def all_paths(value, path=()):
    """Paths of everything in a parsed document."""
    yield path
    entries = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, entry in entries:
        yield from all_paths(entry, (*path, key))


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_every_key_is_found_on_its_line(newline):
    lines = locate(TEXT.replace("\n", newline))
    assert {path: lines[path] for path in LINES} == LINES


def test_located_paths_are_exactly_those_of_the_parsed_document():
    assert set(locate(TEXT)) == set(all_paths(tomllib.loads(TEXT)))


@pytest.mark.parametrize("text", ["", "\n# nothing\n", "a = 1", "[t]", 'a = """"quoted""""', "a = ''''b'''''"])
def test_small_texts_locate_what_they_hold(text):
    assert set(locate(text)) == set(all_paths(tomllib.loads(text)))


def test_a_dotted_key_splits_at_its_dots_and_not_inside_quotes():
    assert split_key("""a . "b.c".'d'.e-1""") == ("a", "b.c", "d", "e-1")


@pytest.mark.parametrize("key", ["", ".", "a.", ".a", "a b", "a..b", "a]", "ä"])
def test_what_is_no_dotted_key_is_refused(key):
    with pytest.raises(ValueError, match="key"):
        split_key(key)


def test_paths_and_values_are_shown_as_a_user_writes_them():
    assert show_path(("wheels", 0, "drive", "times", 2)) == "wheels[0].drive.times[2]"
    assert show_path(("a b", "c")) == "'a b'.c"
    assert show_value({"a": [True, 1.5, "x"], "b c": float("nan")}) == "{a = [true, 1.5, 'x'], 'b c' = nan}"
    assert show_value("x" * 100) == "'" + "x" * 56 + "..."
    assert show_value(10**5000).startswith("0x")


def test_a_path_that_leads_nowhere_has_no_value():
    data = {"a": [{"b": 1}], "c": "text"}
    assert value_at(data, ("a", 0, "b")) == 1
    for path in (("x",), ("a", 1), ("a", "b"), ("a", 0, 0), ("c", 0), ("c", "t")):
        assert value_at(data, path) is MISSING


def test_setting_keys_keeps_every_comment():
    text = "# top\n[t]\na = 1  # one\n[[w]]\nb = { c = 2 }  # two\n# end\n"
    data = {"t": {"a": 5}, "w": [{"b": {"c": 3, "d": 4}}], "new": {"e": [1]}}
    edits = [(("t", "a"), 5), (("w", 0, "b", "c"), 3), (("w", 0, "b", "d"), 4), (("new", "e"), [1])]
    edited = rewrite(text, edits, data)
    assert tomllib.loads(edited) == data
    assert all(comment in edited for comment in ("# top", "# one", "# two", "# end"))


def test_a_text_that_cannot_be_edited_loses_comments_and_no_value():
    data = {"a": 2, "b": 3}
    assert tomllib.loads(rewrite("a = 1 # c", [(("a", "impossible"), 2)], data)) == data
    assert tomllib.loads(rewrite("a = 1 # c", [(("a",), 99)], data)) == data


EDITED = """\
# top
title = "t"  # title

[friction]  # law
law = "none" # which
[[wheels]]
name = "a"
drive = { kind = "free" }  # drive
# between
[[wheels]]
name = "b"
drive.kind = "torque"
drive.torque = 1.0
[wheel_types.omni.disk]
mass = [
  1.0,  # kg
]
"""


@pytest.mark.parametrize(
    ("path", "value", "kept"),
    [
        (("title",), 'a "quoted" \\ µ\x7f\n', 7),
        (("time", "end"), 1e-5, 7),
        (("friction", "coefficient"), 0.5, 7),
        (("friction",), {"law": "viscous", "a b": [1, True, "x"]}, 7),
        (("wheels", 0, "drive", "kind"), "torque", 7),
        (("wheels", 0, "drive", "deep", "er"), [[1.0, -0.0], []], 7),
        (("wheels", 0, "spin_rate"), 2, 7),
        (("wheels", 1, "drive", "torque"), float("inf"), 7),
        (("wheels", 1, "drive", "times"), [0.0, 1.0], 7),
        (("wheels", 1, "drive"), {"kind": "free"}, 7),
        (("wheel_types", "omni", "disk", "mass"), 3.0, 6),  # the comment within the value goes
        (("wheel_types", "omni", "radius"), 0.1, 7),
        (("wheel_types", "a.b", "radius"), 0.1, 7),
        (("friction", "law"), MISSING, 7),
        (("wheels", 1, "drive"), MISSING, 7),
        (("friction",), MISSING, 7),
    ],
    ids=lambda value: "missing" if value is MISSING else str(value),
)
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_every_layout_is_edited_in_place(path, value, kept, newline):
    text = EDITED.replace("\n", newline)
    data = tomllib.loads(text)
    assign(data, path, value)
    edited = rewrite(text, [(path, value)], data)
    assert tomllib.loads(edited) == data
    assert edited.count("# ") == kept
    assert text.splitlines()[0] == edited.splitlines()[0]


def test_several_edits_do_not_get_in_each_others_way():
    data = tomllib.loads(EDITED)
    edits = [(("time", "end"), 1), (("time", "step"), 0.1), (("time",), {"end": 2, "step": 3}), (("title",), "x"),
             (("title",), "y"), (("friction", "a"), 1), (("friction", "b"), 2)]  # fmt: skip
    for path, value in edits:
        assign(data, path, value)
    edited = rewrite(EDITED, edits, data)
    assert tomllib.loads(edited) == data and edited.count("# ") == 7


def test_depth_is_that_of_the_longest_path():
    nested = {"a": [1, {"b": {"c": 2}}]}  # a[1].b.c
    assert not is_deeper(nested, 4) and is_deeper(nested, 3) and not is_deeper(1, 0) and is_deeper(1, -1)


@pytest.mark.parametrize("text", ["a." * 101 + "a = 1", "x = 1\n [ " + "'b' . " * 101, "x = {" + '"c".' * 101, " " * 9])
def test_a_key_of_very_many_parts_is_found_before_it_is_parsed(text):
    assert long_key(text) == (text.count("\n") + 1 if "." in text else None)
