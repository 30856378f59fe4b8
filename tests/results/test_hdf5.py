"""What is in the file, as HDF5 and as netCDF."""

import os
import shutil
import subprocess

import h5py
import numpy as np
import pytest
from synthetic import SCENE, synthetic_trajectory
from trajectory_files import INTEGERS, SCALES, STORED, STRINGS, contract, datasets

from omnisim.results.trajectory import open_trajectory

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


def test_what_is_said_of_a_dataset_is_one_text_in_utf8_of_any_length(saved):
    with h5py.File(saved, "r") as file:
        for path in contract():
            for name in ("units", "description"):
                found = file[path].attrs.get_id(name)
                assert h5py.check_string_dtype(found.dtype) == ("utf-8", None) and found.shape == (), path


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


@pytest.mark.long
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
