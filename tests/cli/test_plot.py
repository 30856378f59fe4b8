"""The command `omnisim plot`: files, messages, windows."""

import builtins
import os
from pathlib import Path

import h5py
import pytest
from commands import command
from helpers.stages import either
from synthetic import synthetic_trajectory

from omnisim_cli import plot

MAGIC = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}


@pytest.fixture(autouse=True)
def folder(folder):
    """Every command runs in a folder with two trajectories, a foreign and a damaged file."""
    synthetic_trajectory().save("a.h5")
    synthetic_trajectory(title="another").save("b.h5")
    with h5py.File("foreign.h5", "w") as file:
        file["x"] = [1.0]
    Path("damaged.h5").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(500))
    return folder


def test_views_of_the_command_are_those_of_the_package():
    plots = pytest.importorskip("omnisim.pictures.plots")
    assert tuple(plots.VIEWS) == plot.VIEWS


@pytest.mark.parametrize("suffix", either(plot.FORMATS, [".png"]))
def test_the_suffix_says_the_format_and_the_same_data_give_the_same_file(suffix):
    pytest.importorskip("matplotlib")
    result = command("plot", "a.h5", "-o", f"a{suffix}")
    assert (result.exit_code, result.stdout) == (0, f"a{suffix} (story)\n"), result.stderr
    written = Path(f"a{suffix}").read_bytes()
    assert written.startswith(MAGIC[suffix])
    again = command("plot", "a.h5", "-o", f"a{suffix}")
    assert again.exit_code == 2 and "exists already; --force" in again.stderr
    assert command("plot", "a.h5", "-o", f"a{suffix}", "--force").exit_code == 0
    assert Path(f"a{suffix}").read_bytes() == written


def test_several_files_are_named_by_title_or_by_file(monkeypatch):
    pytest.importorskip("matplotlib")
    assert list(plot.read_all(["a.h5", "b.h5"])) == ["rollers µ", "another"]
    synthetic_trajectory().save("c.h5")
    assert list(plot.read_all(["a.h5", "c.h5"])) == ["a.h5", "c.h5"]
    assert command("plot", "a.h5", "b.h5", "a.h5", "--view", "slip", "-o", "slip.png").exit_code == 0


def test_without_an_output_a_window_opens(monkeypatch):
    pyplot = pytest.importorskip("matplotlib.pyplot")
    shown = []
    monkeypatch.setattr(plot, "has_window", lambda: True)
    monkeypatch.setattr(pyplot, "show", lambda: shown.append(pyplot.gcf()))
    assert command("plot", "a.h5").exit_code == 0
    assert len(shown) == 1 and shown[0].get_suptitle() == "rollers µ"


BAD = [
    (["a.h5"], "no display to open a window on; -o FILE"),
    (["a.h5", "-o", "a.jpg"], ".png, .svg, .pdf"),
    (["a.h5", "-o", "nowhere/a.png"], "there is no folder"),
    (["nowhere.h5", "-o", "a.png"], "nowhere.h5: No such file"),
    (["foreign.h5", "-o", "a.png"], "foreign.h5: HDF5, but no omnisim trajectory"),
    (["a.h5", "damaged.h5", "-o", "a.png"], "damaged.h5: truncated or damaged"),
    (["a.h5", "--view", "odometry", "-o", "a.png"], "no odometry"),
    (["a.h5", "--view", "bearings", "-o", "a.png"], "output.bearing_loads = true"),
    (["a.h5", "--view", "trackings", "-o", "a.png"], "two files"),
    (["a.h5", "--view", "storry", "-o", "a.png"], "'story'"),
    ([], "FILE..."),
]


@pytest.mark.parametrize(("arguments", "part"), BAD, ids=lambda value: " ".join(value)[:40])
def test_bad_input_is_a_line_and_writes_nothing(arguments, part, monkeypatch):
    pytest.importorskip("matplotlib").use("agg")
    before = sorted(os.listdir())
    result = command("plot", *arguments)
    assert result.exit_code == 2 and result.stdout == ""
    message = result.stderr[result.stderr.index("Error: ") :]
    assert part in message and message.count("\n") == 1
    assert sorted(os.listdir()) == before


def test_without_matplotlib_a_line_says_what_to_install(monkeypatch):
    def absent(name, *rest, original=builtins.__import__):
        if name.startswith("matplotlib"):
            raise ModuleNotFoundError(f"No module named '{name}'", name=name)
        return original(name, *rest)

    monkeypatch.setattr(builtins, "__import__", absent)
    result = command("plot", "a.h5", "-o", "a.png")
    assert (result.exit_code, result.stderr) == (
        2, "Error: plots need matplotlib: pip install 'omnisim-engine[plot]'\n"
    )  # fmt: skip
