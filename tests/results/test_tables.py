"""What other tools read is what the trajectory holds, to the last bit; and what happens when exporting goes wrong."""

import builtins
import csv
import json
import os
import re
import signal
import sys

import h5py
import numpy as np
import pytest
from commands import command
from synthetic import synthetic_attributes, synthetic_data, synthetic_trajectory

import omnisim
from omnisim.exports.formats import ExportError, write
from omnisim.results.layout import LABELS, layout
from omnisim.results.tables import field_names
from omnisim.results.trajectory import Trajectory

WHEELS, ROLLERS = ("front-left", "rear"), (6, 8)


def whole_machine():
    """Every dataset that there can be, the optional ones too."""
    data = synthetic_data(rollers=ROLLERS, wheels=WHEELS)
    sizes = {"time": 11} | {axis: len(labels) for axis, labels in LABELS.items()}
    for wheel, count in zip(WHEELS, ROLLERS, strict=True):
        sizes |= {f"{group}wheels/{wheel}/rollers/roller": count for group in ("", "interval_max/", "interval_min/")}
    random = np.random.default_rng(1)
    for path, row in layout(WHEELS).items():
        if path not in data and not row.is_scale:
            data[path] = random.standard_normal([sizes[axis] for axis in row.axes])
    return Trajectory(synthetic_attributes(wheels=WHEELS), data)


TRAJECTORIES = {
    "bare wheel": synthetic_trajectory,
    "machine": whole_machine,
    "no rows": lambda: synthetic_trajectory(rows=0, events=0),
    "run": lambda: omnisim.simulate(omnisim.load("kiwi", ["time.end=0.1", "output.bearing_loads=true"])),
}


@pytest.fixture(params=["bare wheel", "machine", "no rows", pytest.param("run", marks=pytest.mark.long)])
def trajectory(request):
    return TRAJECTORIES[request.param]()


@pytest.fixture
def saved(folder):
    """A trajectory file in the current folder."""
    synthetic_trajectory().save("run.h5")
    return folder


def by_time(trajectory):
    """{column: (units, values)} of the table by time, written out by hand on purpose."""
    found = {}
    for row in trajectory.quantities:
        array = trajectory[row.path]
        if row.axes[0] == "time":
            for index in np.ndindex(array.shape[1:]):
                axes = zip(row.axes[1:], index, strict=True)
                parts = [LABELS[axis][i] if axis in LABELS else str(i) for axis, i in axes]
                found[".".join([row.path, *parts])] = row.units, array[(slice(None), *index)]
    return found


def same(first, second):
    """Bit for bit, -0.0 and 0.0 told apart."""
    return first.dtype == second.dtype and first.shape == second.shape and first.tobytes() == second.tobytes()


# --- tables ---------------------------------------------------------------------------------------


def test_columns_are_named_by_path_and_component(tmp_path):
    names = list(by_time(whole_machine()))
    for name in ("time", "body/position.x", "wheels/front-left/slip_velocity.k", "wheels/rear/rollers/axial_rate.7",
                 "wheels/rear/rollers/center_velocity.7.z", "wheels/rear/rollers/bearing_force.0.axial"):  # fmt: skip
        assert name in names
    write(whole_machine(), tmp_path / "run.csv")
    assert (tmp_path / "run.csv").read_text().partition("\n")[0].split(",") == names


def test_csv_is_the_table_to_the_last_bit(trajectory, tmp_path):
    assert write(trajectory, tmp_path / "run.csv") == (tmp_path / "run.csv", tmp_path / "run.events.csv")
    with open(tmp_path / "run.csv", newline="") as file:
        names, units, *rows = csv.reader(file)
    columns = by_time(trajectory)
    assert names == list(columns)
    assert units == ["# s", *(units for units, _ in list(columns.values())[1:])]
    for (_, values), texts in zip(columns.values(), zip(*rows, strict=True), strict=False):
        assert same(np.array(texts).astype(values.dtype), values)


def test_csv_is_read_by_pandas(trajectory, tmp_path):
    pandas = pytest.importorskip("pandas")
    write(trajectory, tmp_path / "run.csv")
    exact = {} if int(pandas.__version__.partition(".")[0]) > 2 else {"float_precision": "round_trip"}
    frame = pandas.read_csv(tmp_path / "run.csv", comment="#", **exact)
    assert list(frame) == list(by_time(trajectory))
    for name, (_, values) in by_time(trajectory).items():
        assert same(frame[name].to_numpy().astype(values.dtype), values), name
    events = pandas.read_csv(tmp_path / "run.events.csv", comment="#", na_filter=False)
    assert list(events) == ["event", "time", "kind", "wheel", "roller_from", "roller_to"]
    for name in set(events) - {"time"}:
        assert events[name].tolist() == trajectory[f"events/{name}"].tolist()


def test_parquet_has_the_table_with_units_and_attributes(trajectory, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    write(trajectory, tmp_path / "run.parquet")
    table = parquet.read_table(tmp_path / "run.parquet")
    columns = by_time(trajectory)
    assert table.column_names == list(columns)
    for name, (units, values) in columns.items():
        assert same(table[name].to_numpy(), values), name
        assert table.schema.field(name).metadata[b"units"].decode() == units
    metadata = {name.decode(): value.decode() for name, value in table.schema.metadata.items()}
    assert metadata["scene"] == trajectory.attributes["scene"]
    assert json.loads(metadata["wheels"]) == list(trajectory.wheels)
    assert json.loads(metadata["step"]) == trajectory.attributes["step"]
    events = parquet.read_table(tmp_path / "run.events.parquet").to_pydict()
    assert events == {name: trajectory[f"events/{name}"].tolist() for name in events} and "kind" in events


def test_a_data_frame_has_the_same_columns_by_time(trajectory):
    pytest.importorskip("pandas")
    frame = trajectory.to_pandas()
    columns = by_time(trajectory)
    assert frame.index.name == "time" and ["time", *frame] == list(columns)
    assert same(frame.index.to_numpy(), trajectory.time)
    assert all(same(frame[name].to_numpy(), columns[name][1]) for name in frame)
    assert frame.attrs["units"] == {name: units for name, (units, _) in columns.items()}
    assert frame.attrs["scene"] == trajectory.attributes["scene"]


# --- trees ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("engine", ["h5netcdf", "netcdf4"])
def test_to_xarray_is_what_xarray_opens_from_the_file(trajectory, tmp_path, engine):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip({"h5netcdf": "h5netcdf", "netcdf4": "netCDF4"}[engine])
    trajectory.save(tmp_path / "run.h5")
    with xarray.open_datatree(tmp_path / "run.h5", engine=engine) as opened:
        tree = trajectory.to_xarray()
        xarray.testing.assert_identical(tree, opened)  # names, dimensions, coordinates, values, attributes
        for node in opened.subtree:
            assert set(tree[node.path].coords) == set(node.coords)
            for name, variable in node.to_dataset(inherit=False).variables.items():
                assert tree[node.path][name].dtype.kind == variable.dtype.kind


def test_mat_has_the_tree_the_attributes_and_the_units(trajectory, tmp_path):
    scipy_io = pytest.importorskip("scipy.io")
    assert write(trajectory, tmp_path / "run.mat") == (tmp_path / "run.mat",)
    loaded = scipy_io.loadmat(tmp_path / "run.mat", simplify_cells=True, chars_as_strings=True)
    exact = scipy_io.loadmat(tmp_path / "run.mat", struct_as_record=False)
    for row in trajectory.quantities:
        array = trajectory[row.path]
        first, *rest = row.path.replace("-", "_").split("/")
        value, units = exact[first], loaded["units"][first]
        for part in rest:
            value, units = getattr(value[0, 0], part), units[part]
        assert units == row.units
        if row.dtype == "str":
            assert ["".join(cell) for cell in value.ravel().tolist()] == array.tolist()
        else:
            empty = value.size == array.size == 0  # SciPy reads and writes it as 0 x 0
            assert empty or same(value, array[:, None] if array.ndim == 1 else array), row.path
    for name, value in trajectory.attributes.items():
        read = loaded["attributes"][name]
        assert (np.atleast_1d(read).tolist() == list(value) if name == "wheels" else "".join(read) == value
                if isinstance(value, str) else read == value), name  # fmt: skip


def test_wheels_whose_names_differ_in_a_dash_keep_their_data_apart(tmp_path):
    scipy_io = pytest.importorskip("scipy.io")
    trajectory = synthetic_trajectory(wheels=("spin-rate", "spin_rate"))
    write(trajectory, tmp_path / "run.mat")
    wheels = scipy_io.loadmat(tmp_path / "run.mat", simplify_cells=True)["wheels"]
    for name, wheel in zip(("spin_rate", "spin_rate_2"), trajectory.wheels, strict=True):
        assert np.array_equal(wheels[name]["spin_rate"], trajectory[f"wheels/{wheel}/spin_rate"])


def test_field_names_are_legal_in_matlab_and_unique():
    wheels = ("left", "a-b", "a_b", "end", "w" * 70, "w" * 71, "W")
    names = field_names(wheels)
    assert list(names) == list(wheels) and len(set(names.values())) == len(wheels)
    assert all(re.fullmatch(r"[A-Za-z]\w{0,62}", name) for name in names.values())
    assert names["left"] == "left" and names["a-b"] == "a_b" and names["a_b"] == "a_b_2" and names["end"] == "end_2"


# --- the command ----------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", ["csv", "parquet", "mat", "CSV"])
def test_export_writes_what_the_suffix_says_and_tells_so(saved, suffix):
    result = command("export", "run.h5", f"out.{suffix}")
    assert result.exit_code == 0, result.stderr
    written = ["out.mat"] if suffix == "mat" else [f"out.{suffix}", f"out.events.{suffix}"]
    assert sorted(os.listdir()) == sorted(["run.h5", *written])
    assert all(name in result.stdout for name in written)


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (("run.h5", "out.xlsx"), ("out.xlsx", "'.xlsx'", ".csv, .parquet, .mat, .mcap")),
        (("run.h5", "out"), ("out", "''", ".csv, .parquet, .mat, .mcap")),
        (("run.h5", "nowhere/out.csv"), ("nowhere/out.csv", "no folder")),
        (("run.h5", "folder.csv"), ("folder.csv", "a folder")),
        (("nowhere.h5", "out.csv"), ("nowhere.h5", "No such file")),
        (("text.h5", "out.csv"), ("text.h5", "not an HDF5 file")),
        (("foreign.h5", "out.csv"), ("foreign.h5", "no omnisim trajectory")),
        (("damaged.h5", "out.csv"), ("damaged.h5", "truncated or damaged")),
        (("old.csv", "old.csv", "--force"), ("old.csv", "the input itself")),
    ],
)
def test_bad_input_is_one_line_and_touches_nothing(saved, arguments, parts):
    (saved / "folder.csv").mkdir()
    (saved / "text.h5").write_text("time,position\n")
    (saved / "damaged.h5").write_bytes((saved / "run.h5").read_bytes()[:9000])
    (saved / "old.csv").write_bytes((saved / "run.h5").read_bytes())
    with h5py.File("foreign.h5", "w") as file:
        file["x"] = 1.0
    before = sorted(os.listdir())
    result = command("export", *arguments)
    assert result.exit_code == 2 and result.stdout == ""
    assert len(result.stderr.splitlines()) == 1 and all(part in result.stderr for part in parts), result.stderr
    assert sorted(os.listdir()) == before


@pytest.mark.parametrize("present", ["out.csv", "out.events.csv"])
def test_existing_files_are_replaced_with_force_only(saved, present):
    (saved / present).write_text("precious")
    result = command("export", "run.h5", "out.csv")
    assert result.exit_code == 2 and f"{present}: exists already; --force" in result.stderr
    assert sorted(os.listdir()) == sorted(["run.h5", present]) and (saved / present).read_text() == "precious"
    assert command("export", "run.h5", "out.csv", "--force").exit_code == 0
    assert (saved / present).read_text() != "precious"


LIBRARIES = {"parquet": "pyarrow", "mat": "scipy", "mcap": "mcap", "pandas": "pandas", "xarray": "xarray"}


@pytest.fixture
def bare(monkeypatch):
    """Without any optional library."""

    def absent(name, *rest, original=builtins.__import__):
        package = name.partition(".")[0]
        if package in LIBRARIES.values():
            raise ModuleNotFoundError(f"No module named {package!r}", name=package)
        return original(name, *rest)

    monkeypatch.setattr(builtins, "__import__", absent)
    monkeypatch.setitem(sys.modules, "mcap", None)  # that one is asked for before anything is imported from it


@pytest.mark.parametrize("suffix", ["parquet", "mat", "mcap"])
def test_a_missing_library_is_one_line_that_says_what_to_install(saved, bare, suffix):
    result = command("export", "run.h5", f"out.{suffix}")
    assert result.exit_code == 2 and len(result.stderr.splitlines()) == 1
    assert f"{LIBRARIES[suffix]} is not installed: pip install 'omnisim-engine[{suffix}]'" in result.stderr
    assert os.listdir() == ["run.h5"]


@pytest.mark.parametrize("extra", ["pandas", "xarray"])
def test_a_missing_library_is_told_in_python_too(bare, extra):
    with pytest.raises(ExportError, match=rf"{extra} is not installed: pip install 'omnisim-engine\[{extra}\]'"):
        getattr(synthetic_trajectory(), f"to_{extra}")()


def test_csv_needs_no_library(saved, bare):
    assert command("export", "run.h5", "out.csv").exit_code == 0


@pytest.mark.parametrize("suffix", ["csv", "parquet", "mat"])
@pytest.mark.parametrize("place", ["os.fsync", "os.replace"])
def test_a_write_that_fails_leaves_the_old_files_and_nothing_else(saved, monkeypatch, place, suffix):
    def full(*_):
        raise OSError(28, "No space left on device")

    assert command("export", "run.h5", f"out.{suffix}").exit_code == 0
    before = {path.name: path.read_bytes() for path in saved.iterdir()}
    synthetic_trajectory(rows=5).save("run.h5", overwrite=True)
    before["run.h5"] = (saved / "run.h5").read_bytes()
    monkeypatch.setattr(place, full)
    result = command("export", "run.h5", f"out.{suffix}", "--force")
    assert result.exit_code == 1
    assert re.fullmatch(rf"Error: out\S*{suffix}: cannot be written: No space left on device\n", result.stderr)
    assert {path.name: path.read_bytes() for path in saved.iterdir()} == before


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_write_leaves_nothing(saved, monkeypatch, number):
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # tests in the background may ignore it
    monkeypatch.setattr("os.fsync", lambda _: signal.raise_signal(number))
    result = command("export", "run.h5", "out.csv")
    signal.signal(signal.SIGINT, before)
    assert result.exit_code == 1 and result.stderr == "Error: interrupted; nothing was written\n"
    assert os.listdir() == ["run.h5"]


def test_numbers_that_came_to_be_nan_are_not_exported(tmp_path):
    trajectory = synthetic_trajectory()
    trajectory["body/yaw"][3] = np.nan
    with pytest.raises(ValueError, match=r"dataset body/yaw is nan"):
        write(trajectory, tmp_path / "run.csv")
    assert os.listdir(tmp_path) == []
