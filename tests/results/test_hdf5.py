"""What is in the file, as HDF5 and as netCDF, and what happens when writing or reading goes wrong."""

import os
import shutil
import subprocess
import sys
import textwrap

import h5py
import numpy as np
import pytest
import synthetic
from synthetic import SCENE, synthetic_attributes, synthetic_trajectory

from omnisim.base.trajectory_file import TrajectoryError
from omnisim.results.trajectory import open_trajectory

# The contract, written out by hand on purpose: path, axes, units of a bare wheel called "wheel".
SCALES = {
    "time": "s", "axis": "1", "tangent": "1", "wheels/wheel/rollers/roller": "1", "events/event": "1",
}  # fmt: skip
CONTRACT = """
    body/position                            time axis         m
    body/velocity                            time axis         m/s
    body/acceleration                        time axis         m/s^2
    body/yaw                                 time              rad
    body/yaw_rate                            time              rad/s
    body/yaw_acceleration                    time              rad/s^2
    wheels/wheel/spin_angle                  time              rad
    wheels/wheel/spin_rate                   time              rad/s
    wheels/wheel/spin_acceleration           time              rad/s^2
    wheels/wheel/drive_torque                time              N m
    wheels/wheel/drive_power                 time              W
    wheels/wheel/normal_force                time              N
    wheels/wheel/contact_angle               time              rad
    wheels/wheel/contact_roller              time              1
    wheels/wheel/contact_point               time axis         m
    wheels/wheel/slip_velocity               time tangent      m/s
    wheels/wheel/friction_force              time tangent      N
    wheels/wheel/contact_share               time              1
    wheels/wheel/contact_torque              time              N m
    wheels/wheel/servo_torque                time              N m
    wheels/wheel/rollers/axial_rate          time roller       rad/s
    wheels/wheel/rollers/joint_rate          time roller       rad/s
    wheels/wheel/rollers/center_position     time roller axis  m
    wheels/wheel/rollers/center_velocity     time roller axis  m/s
    wheels/wheel/rollers/center_acceleration time roller axis  m/s^2
    energy/kinetic                           time              J
    energy/friction_loss                     time              J
    energy/bearing_loss                      time              J
    energy/drive_work                        time              J
    energy/wrench_work                       time              J
    energy/balance                           time              J
    events/time                              event             s
    events/kind                              event             1
    events/wheel                             event             1
    events/roller_from                       event             1
    events/roller_to                         event             1
"""
INTEGERS = {"wheels/wheel/contact_roller", "wheels/wheel/rollers/roller", "events/event",
            "events/roller_from", "events/roller_to"}  # fmt: skip
STRINGS = {"axis", "tangent", "events/kind", "events/wheel"}
ATTRIBUTES = {"format", "format_version", "omnisim_version", "title", "scene", "wheels", "model", "tracking",
              "method", "step", "steps", "rhs_evaluations", "wall_time", "status", "stop_time",
              "stop_wheel"}  # fmt: skip
STORED = ATTRIBUTES | {"scene_crc32"}


def contract():
    """{path: (axes, units)} of every dataset that is no scale."""
    rows = (line.split() for line in CONTRACT.strip().splitlines())
    axes = ("time", "axis", "tangent", "roller", "event")
    return {
        path: (
            tuple(word for word in rest if word in axes),
            " ".join(word for word in rest if word not in axes),
        )
        for path, *rest in rows
    }


def datasets(path):
    """{path: (shape, dtype, attributes)} of a whole file."""
    found = {}

    def visit(name, item):
        if isinstance(item, h5py.Dataset):
            found[name] = (item.shape, item.dtype, dict(item.attrs))

    with h5py.File(path, "r") as file:
        file.visititems(visit)
    return found


@pytest.fixture
def saved(tmp_path):
    trajectory = synthetic_trajectory()
    trajectory.save(tmp_path / "run.h5")
    return tmp_path / "run.h5"


# Contents


def test_a_file_holds_exactly_the_datasets_of_the_contract(saved):
    found = datasets(saved)
    assert found.keys() == contract().keys() | SCALES.keys()
    units = {path: attributes["units"] for path, (_, _, attributes) in found.items()}
    assert units == SCALES | {path: units for path, (_, units) in contract().items()}
    assert all(len(attributes["description"]) > 5 for _, _, attributes in found.values())


def test_numbers_are_float64_or_int64_and_strings_utf8(saved):
    for path, (_, dtype, _) in datasets(saved).items():
        if path in STRINGS:
            assert h5py.check_string_dtype(dtype) == ("utf-8", None)
        else:
            assert dtype == (np.int64 if path in INTEGERS else np.float64), path


def test_every_axis_of_every_dataset_carries_its_scale(saved):
    with h5py.File(saved, "r") as file:
        for path, (axes, _) in contract().items():
            carried = [tuple(scale.name for scale in dimension.values()) for dimension in file[path].dims]
            local = {"roller": "/wheels/wheel/rollers/roller", "event": "/events/event"}
            assert carried == [(local.get(axis, f"/{axis}"),) for axis in axes], path
        assert all(file[path].is_scale for path in SCALES)
        assert file["axis"].asstr()[...].tolist() == ["x", "y", "z"]
        assert file["tangent"].asstr()[...].tolist() == ["h", "k"]
        assert file["wheels/wheel/rollers/roller"][...].tolist() == [0, 1, 2, 3, 4, 5]


def test_root_attributes_are_those_of_the_contract(saved):
    with h5py.File(saved, "r") as file:
        assert set(file.attrs) == STORED
        assert file.attrs["format"] == "omnisim-trajectory"
        assert file.attrs["format_version"] == 1
        assert file.attrs["wheels"].tolist() == ["wheel"]
        assert file.attrs["scene"] == SCENE
        assert file.attrs["step"].dtype == np.float64 and file.attrs["steps"].dtype == np.int64


# Round trip


@pytest.mark.parametrize(("rows", "events"), [(11, 3), (11, 0), (1, 1), (0, 0)])
def test_a_trajectory_comes_back_bit_for_bit(tmp_path, rows, events):
    wheels = ("front_left", "rear-right")
    written = synthetic_trajectory(rows=rows, rollers=(6, 8), events=events, wheels=wheels)
    written.save(tmp_path / "run.h5")
    back = open_trajectory(tmp_path / "run.h5")
    assert back.attributes == written.attributes
    assert list(back.data) == list(written.data)
    for path, array in written.data.items():
        assert np.array_equal(back[path], array), path
        assert back[path].dtype.kind == array.dtype.kind
        assert array.dtype.kind == "U" or back[path].tobytes() == array.tobytes(), path


def test_a_scene_of_a_megabyte_is_kept_whole(tmp_path):
    scene = "# µ\n" * 250_000  # HDF5 keeps attributes below 64 kB, except variable-length strings
    synthetic_trajectory(scene=scene).save(tmp_path / "run.h5")
    assert open_trajectory(tmp_path / "run.h5").attributes["scene"] == scene


def test_what_a_later_version_adds_is_left_alone(saved):
    with h5py.File(saved, "r+") as file:
        file["body/temperature"] = np.zeros(11)
        file.attrs["colour"] = "red"
    assert "body/temperature" not in open_trajectory(saved)


# Checksums


def chunks(path):
    """{dataset of numbers: (where its first chunk begins, its size in the file)}"""
    found = {}

    def visit(name, item):
        if isinstance(item, h5py.Dataset) and item.chunks:
            assert item.fletcher32, name
            chunk = item.id.get_chunk_info(0)
            found[name] = chunk.byte_offset, chunk.size

    with h5py.File(path, "r") as file:
        file.visititems(visit)
    return found


def test_a_flipped_bit_is_reported_with_the_name_of_its_dataset(saved):
    whole, found = saved.read_bytes(), chunks(saved)
    assert found.keys() == (contract().keys() | SCALES.keys()) - STRINGS
    for name, (begin, size) in found.items():
        for place, bit in ((0, 1), (size // 2, 16), (size - 5, 128)):
            flipped = bytearray(whole)
            flipped[begin + place] ^= bit
            saved.write_bytes(flipped)
            assert refusal(saved) == f"truncated or damaged (dataset {name}: it does not match its checksum)"


@pytest.mark.parametrize(
    ("text", "name"),
    [("exchange", "dataset events/kind"), ("x", "dataset axis"), ("h", "dataset tangent"), ("rollers", "scene")],
)
def test_so_is_one_in_a_text(saved, text, name):
    whole = saved.read_bytes()
    pattern = text.encode() + (b"" if name.endswith("kind") else b"\0" if name != "scene" else b' \xc2\xb5"')
    places = [place for place in range(len(whole)) if whole.startswith(pattern, place)]
    names = []
    for place in places:
        flipped = bytearray(whole)
        flipped[place] ^= 1
        saved.write_bytes(flipped)
        try:
            open_trajectory(saved)
        except TrajectoryError as error:
            names.append(str(error))
    assert any(f"{name}: it does not match its checksum" in message for message in names), names


@pytest.mark.parametrize("count", [100, pytest.param(1000, marks=pytest.mark.long)])
def test_of_so_many_flipped_bits_none_changes_a_number_or_the_scene_in_silence(saved, count):
    written, whole = open_trajectory(saved), saved.read_bytes()
    places = np.random.default_rng(5).integers(8 * len(whole), size=count).tolist()
    seen = 0
    for place in places:
        flipped = bytearray(whole)
        flipped[place // 8] ^= 1 << place % 8
        saved.write_bytes(flipped)
        try:
            back = open_trajectory(saved)
        except TrajectoryError:
            seen += 1
        else:
            assert all(np.array_equal(back[path], written[path]) for path in written)
            assert back.attributes["scene"] == SCENE
    assert seen > count // 2  # the others: room that holds nothing, text that only describes


def test_a_large_dataset_is_in_chunks_of_rows_and_a_file_hardly_larger(tmp_path):
    trajectory = synthetic_trajectory(rows=40_001)
    trajectory.save(tmp_path / "run.h5")
    with h5py.File(tmp_path / "run.h5") as file:
        assert file["body/yaw"].chunks == (40_001,)
        assert file["wheels/wheel/rollers/center_position"].chunks == (6667, 6, 3)  # 0.96 MB
    data = sum(array.nbytes for array in trajectory.data.values() if array.dtype.kind != "U")
    assert os.path.getsize(tmp_path / "run.h5") - data < 130_000  # 118 kB: the rest of the file and what fills chunks
    assert all(np.array_equal(open_trajectory(tmp_path / "run.h5")[path], trajectory[path]) for path in trajectory)


def test_files_written_before_there_were_checksums_are_read(saved):
    written = synthetic_trajectory()
    with h5py.File(saved, "r+") as file:
        del file.attrs["scene_crc32"]
        for path in STRINGS:
            del file[path].attrs["crc32"]
        for path in ("body/yaw", "energy/kinetic", "wheels/wheel/contact_roller"):
            del file[path]
            file[path] = written[path]
    back = open_trajectory(saved)
    assert all(np.array_equal(back[path], written[path]) for path in written)


# xarray and HDF5 tools


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("events", [3, 11, 0], ids="events={}".format)
@pytest.mark.parametrize("engine", ["h5netcdf", "netcdf4"])
def test_xarray_sees_a_tree_with_dimensions_coordinates_and_units(tmp_path, engine, events):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip({"h5netcdf": "h5netcdf", "netcdf4": "netCDF4"}[engine])
    written = synthetic_trajectory(rows=11, rollers=(6, 8), events=events, wheels=("wheel", "other"))
    written.save(tmp_path / "run.h5")
    with xarray.open_datatree(tmp_path / "run.h5", engine=engine) as tree:
        paths = {"/", "/body", "/wheels", "/wheels/wheel", "/wheels/wheel/rollers", "/wheels/other",
                 "/wheels/other/rollers", "/energy", "/events"}  # fmt: skip
        assert {node.path for node in tree.subtree} == paths
        for path, (axes, units) in contract().items():
            assert tree[path].dims == axes, path
            assert tree[path].attrs["units"] == units
            assert np.array_equal(tree[path].values, written[path]), path
        assert np.array_equal(tree["time"].values, written.time)
        assert tree["axis"].values.tolist() == ["x", "y", "z"]
        sizes = {"time": 11, "roller": 8, "axis": 3}
        assert dict(tree["wheels/other/rollers"].to_dataset(inherit=False).sizes) == sizes
        assert dict(tree["events"].to_dataset(inherit=False).sizes) == {"event": events}
        coordinates = tree["wheels/wheel/rollers"].coords
        assert {"time", "axis", "roller"} <= set(coordinates)
        assert coordinates["roller"].attrs["units"] == "1"
        assert set(tree.attrs) == STORED


def test_h5dump_shows_paths_and_values(saved):
    if shutil.which("h5dump") is None:
        pytest.skip("h5dump (hdf5-tools) is not installed")
    done = subprocess.run(["h5dump", str(saved)], capture_output=True, text=True, check=True)
    for text in ('DATASET "center_position"', 'GROUP "wheels"', '"exchange", "stick", "slip"', '"rad/s^2"'):
        assert text in done.stdout


# Writing that goes wrong


def untouched(folder, before):
    return {path.name: path.read_bytes() for path in folder.iterdir()} == before


@pytest.mark.parametrize("error", [KeyboardInterrupt, MemoryError])
@pytest.mark.parametrize("place", ["h5py.Dataset.make_scale", "os.fsync", "os.replace"])
def test_an_interrupted_write_leaves_the_old_file_and_nothing_else(saved, monkeypatch, place, error):
    before = {saved.name: saved.read_bytes()}

    def interrupted(*arguments):
        raise error

    monkeypatch.setattr(place, interrupted)
    with pytest.raises(error):
        synthetic_trajectory(rows=5).save(saved, overwrite=True)
    assert untouched(saved.parent, before)


def test_a_file_that_is_not_yet_whole_does_not_bear_the_name(tmp_path, monkeypatch):
    seen = []
    monkeypatch.setattr("os.fsync", lambda number: seen.extend(path.name for path in tmp_path.iterdir()))
    synthetic_trajectory().save(tmp_path / "run.h5")
    assert len(seen) == 1 and seen[0].endswith(".tmp")
    assert [path.name for path in tmp_path.iterdir()] == ["run.h5"]


@pytest.mark.skipif(os.name != "posix", reason="file size limits are POSIX")
@pytest.mark.parametrize("limit", [100, 3000, 100_000], ids="limit={}".format)
def test_a_full_disk_is_one_clear_error_and_leaves_the_old_file(saved, limit):
    before = {saved.name: saved.read_bytes()}
    code = """
        import resource, sys
        from synthetic import synthetic_trajectory
        trajectory = synthetic_trajectory(rows=1001)
        resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]), resource.RLIM_INFINITY))
        try:
            trajectory.save(sys.argv[1], overwrite=True)
        except OSError as error:
            print(error.errno, error)
    """
    command = [sys.executable, "-c", textwrap.dedent(code), str(saved), str(limit)]
    environment = os.environ | {"PYTHONPATH": os.path.dirname(synthetic.__file__)}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0 and done.stderr == ""
    assert done.stdout == f"27 [Errno 27] File too large: '{saved}'\n"
    assert untouched(saved.parent, before)


def test_nan_that_came_in_after_construction_does_not_reach_a_file(saved):
    before = {saved.name: saved.read_bytes()}
    trajectory = synthetic_trajectory()
    trajectory["body/yaw"][3] = np.nan
    with pytest.raises(ValueError, match=r"dataset body/yaw is nan at index \(3,\)"):
        trajectory.save(saved, overwrite=True)
    assert untouched(saved.parent, before)


def test_a_second_write_replaces_the_first_only_if_told(saved):
    before = {saved.name: saved.read_bytes()}
    with pytest.raises(FileExistsError, match=r"exists already; overwrite=True replaces it: '.*run\.h5'$"):
        synthetic_trajectory(rows=5).save(saved)
    assert untouched(saved.parent, before)
    synthetic_trajectory(rows=5).save(saved, overwrite=True)
    assert len(open_trajectory(saved).time) == 5
    assert [path.name for path in saved.parent.iterdir()] == [saved.name]


def test_writing_to_a_link_replaces_the_file_behind_it(saved, tmp_path):
    link = tmp_path / "latest.h5"
    link.symlink_to(saved)
    synthetic_trajectory(rows=5).save(link, overwrite=True)
    assert link.is_symlink()
    assert len(open_trajectory(saved).time) == 5


@pytest.mark.parametrize(("name", "reason"), [("missing/run.h5", "No such file"), (".", "not a regular file")])
def test_a_place_that_cannot_be_written_is_one_line_with_its_path(tmp_path, name, reason):
    with pytest.raises(OSError, match=reason) as caught:
        synthetic_trajectory().save(tmp_path / name)
    assert str(tmp_path) in str(caught.value) and "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not os.path.exists("/dev/null"), reason="no /dev/null here")
def test_a_device_is_not_replaced_by_a_file():
    with pytest.raises(OSError, match="not a regular file: '/dev/null'"):
        synthetic_trajectory().save("/dev/null")


def test_a_read_only_folder_is_one_line_with_the_path(tmp_path):
    tmp_path.chmod(0o500)
    if os.access(tmp_path, os.W_OK):
        pytest.skip("this user (root) may write everywhere")
    with pytest.raises(PermissionError, match=r"Permission denied: '.*run\.h5'$"):
        synthetic_trajectory().save(tmp_path / "run.h5")
    assert list(tmp_path.iterdir()) == []


# Reading that goes wrong


def refusal(path):
    """The one line that read() refuses a file with, without the path it starts with."""
    with pytest.raises(TrajectoryError) as caught:
        open_trajectory(path)
    line = str(caught.value)
    assert "\n" not in line
    assert line.startswith(f"{path}: ")
    return line.removeprefix(f"{path}: ")


def test_a_missing_file_and_a_folder_are_said_to_be_just_that(tmp_path):
    assert refusal(tmp_path / "run.h5") == "No such file or directory"
    assert refusal(tmp_path) == "Is a directory"


@pytest.mark.parametrize("content", [b"", b"schema = 1\n", b"\x89HDF"])
def test_a_file_that_is_not_hdf5_is_said_to_be_none(tmp_path, content):
    (tmp_path / "run.h5").write_bytes(content)
    assert refusal(tmp_path / "run.h5") == "not an HDF5 file"


@pytest.mark.parametrize("name", [None, "another-format", 3, ["omnisim-trajectory", "x"]])
def test_hdf5_of_others_is_told_from_ours(tmp_path, name):
    with h5py.File(tmp_path / "run.h5", "w") as file:
        if name is not None:
            file.attrs["format"] = name
    assert refusal(tmp_path / "run.h5").startswith("HDF5, but no omnisim trajectory")


def test_a_newer_format_is_refused(saved):
    with h5py.File(saved, "r+") as file:
        file.attrs["format_version"] = 2
    assert refusal(saved) == "format version 2, but this omnisim reads up to 1"


@pytest.mark.parametrize("part", [0.02, 0.3, 0.7, 0.999])
def test_a_truncated_file_is_refused(saved, part):
    whole = saved.read_bytes()
    saved.write_bytes(whole[: int(part * len(whole))])
    assert refusal(saved).startswith("truncated or damaged (")


def test_a_missing_dataset_or_attribute_is_named(saved):
    with h5py.File(saved, "r+") as file:
        del file["energy/drive_work"]
    assert "dataset energy/drive_work is missing" in refusal(saved)
    with h5py.File(saved, "r+") as file:
        del file.attrs["method"]
    assert "attribute method is missing" in refusal(saved)
    with h5py.File(saved, "r+") as file:
        del file.attrs["wheels"]
    assert "attribute wheels is missing" in refusal(saved)


def test_nan_in_a_file_is_refused(saved):
    with h5py.File(saved, "r+") as file:
        file["body/yaw"][2] = np.nan
    assert "dataset body/yaw is nan at index (2,)" in refusal(saved)


def test_a_dataset_of_the_wrong_type_is_refused(saved):
    with h5py.File(saved, "r+") as file:
        del file["body/yaw"]
        file["body/yaw"] = np.zeros(11, dtype=np.float32)
        del file["events/kind"]
        file["events/kind"] = np.zeros(3)
    assert refusal(saved).startswith("truncated or damaged (")


def test_what_a_search_adds_is_kept_and_may_be_absent(tmp_path):
    for added in ({}, {"error_target": 1e-6}, {"error_target": 1e-6, "error_estimate": 2.5e-7}):
        synthetic_trajectory(**added).save(tmp_path / "run.h5", overwrite=True)
        back = open_trajectory(tmp_path / "run.h5").attributes
        assert {name: value for name, value in back.items() if name.startswith("error")} == added
        with h5py.File(tmp_path / "run.h5", "r") as file:
            assert set(file.attrs) == STORED | added.keys()


def test_the_factory_of_these_tests_gives_all_attributes_but_the_format():
    assert synthetic_attributes().keys() | {"format", "format_version"} == ATTRIBUTES
