"""Files that are damaged, foreign or incomplete are refused with one line that says why."""

import struct

import h5py
import numpy as np
import pytest
from synthetic import SCENE, synthetic_attributes, synthetic_trajectory
from trajectory_files import ATTRIBUTES, SCALES, STORED, STRINGS, contract, refusal

from omnisim.base.trajectory_file import TrajectoryError
from omnisim.results.trajectory import open_trajectory

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


def test_a_heap_that_the_hdf5_library_would_read_for_ever_is_refused(saved):
    """The size of each object of a heap of texts set to 0, one after the other: where what follows then looks like free
    room of no size the library never returns."""
    whole, heaps = saved.read_bytes(), []
    place = whole.find(b"GCOL\x01")
    while place >= 0:
        heaps.append(place)
        place = whole.find(b"GCOL\x01", place + 1)
    messages = []
    for heap in heaps:
        (size,) = struct.unpack_from("<Q", whole, heap + 8)
        at = heap + 16
        while at + 16 <= heap + size:
            index, length = struct.unpack_from("<H6xQ", whole, at)
            damaged = whole[: at + 8] + bytes(8) + whole[at + 16 :]
            saved.write_bytes(damaged)
            try:
                open_trajectory(saved)
            except TrajectoryError as error:
                messages.append(str(error))
            at += length if index == 0 else 16 + -(-length // 8) * 8
    assert any("truncated or damaged (a heap of texts has no end)" in message for message in messages)
    saved.write_bytes(whole)
    assert open_trajectory(saved).complete


# Reading that goes wrong


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
