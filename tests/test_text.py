"""Facts for people stay in their columns."""

import pytest

from omnisim.text import WIDTH, aligned, columns, hanging

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
