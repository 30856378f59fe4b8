"""Facts for people stay in their columns."""

import pytest

from omnisim.base.formatting import WIDTH, aligned, columns, hanging, visible

pytestmark = pytest.mark.short


def test_facts_stand_in_a_column_and_empty_ones_are_left_out():
    assert aligned({"mass": "2 kg", "title": "", "height": "1 m"}, indent=" ") == " mass    2 kg\n height  1 m"


def test_long_text_is_wrapped_below_its_beginning():
    lines = hanging("why  ", "word " * 50).splitlines()
    assert len(lines) == 3 and max(map(len, lines)) <= WIDTH
    assert all(line.startswith("     word") for line in lines[1:])


def test_a_word_that_is_too_long_stays_whole():
    path = "folder/" * 40
    assert hanging("file  ", f"{path} (3 rows)") == f"file  {path}\n      (3 rows)"


def test_columns_are_as_wide_as_their_longest_cell():
    assert columns([("a", "bb", "c"), ("aaa", "b", "ccc")]) == "a    bb  c\naaa  b   ccc"


def test_a_table_without_rows_is_empty():
    assert columns([]) == ""


def test_what_would_act_on_a_terminal_is_written_out():
    assert visible("a\x00\x1b[31m\x7f\x9b\r\n\t\u202e\udcff\ud800 µ 漢 e\u0301") == (
        "a\\x00\\x1b[31m\\x7f\\x9b\\x0d\\x0a\\x09\\u202e\\xff\\ud800 µ 漢 e\u0301"
    )
    assert visible("a\n\tb\r", but="\n\t") == "a\n\tb\\x0d"
