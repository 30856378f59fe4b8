"""What the screen shows while kernels are compiled."""

import io
from types import SimpleNamespace

import pytest

from omnisim_cli import compiling, screen


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def kernels():
    return [SimpleNamespace(overloads={}, __hash__=None) for _ in range(4)]


def bar_of(kernels, monkeypatch, stream, patience=0.0):
    monkeypatch.setattr(compiling, "PATIENCE", patience)
    monkeypatch.setattr("sys.stderr", stream)
    return compiling.Bar(kernels)


def test_a_bar_counts_the_kernels_that_are_there(kernels, monkeypatch):
    stream = Terminal()
    bar = bar_of(kernels, monkeypatch, stream)
    for kernel in kernels[:3]:
        kernel.overloads["types"] = "code"
        bar.draw()
    assert screen.unfinished_lines == 1  # Ctrl-C begins a line of its own
    bar.end()
    assert screen.unfinished_lines == 0
    last = stream.getvalue().split("\r")[-1]
    assert last == f"  [{'#' * 27}{'-' * 9}] 3 of about 4 kernels\n"
    assert "\x1b" not in stream.getvalue()  # the cursor stays as it is


@pytest.mark.parametrize(("stream", "patience"), [(io.StringIO(), 0.0), (Terminal(), 60.0)])
def test_there_is_no_bar_in_a_file_or_for_a_moment(stream, patience, kernels, monkeypatch):
    bar = bar_of(kernels, monkeypatch, stream, patience)
    bar.draw()
    bar.end()
    assert stream.getvalue() == ""
