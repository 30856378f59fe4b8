"""An MCAP file is the run: other readers find the same messages and events, and the command writes it whole or not."""

import pytest
import tomlkit
from commands import command, refused
from oracle.spatial.states import SCENES as FREE
from recorded_machines import SHORT, run_of
from recordings import by_mcap, by_rosbags, plain, records
from synthetic import synthetic_trajectory

import omnisim
from omnisim.exports.formats import write
from omnisim.scene.scene import parse

pytest.importorskip("mcap", reason="needs mcap")
pytest.importorskip("rosbags", reason="needs rosbags")


@pytest.mark.parametrize("name", ["mecanum", "bare wheel"])
def test_three_readers_find_the_same_messages(recorded, name):
    """Types of Humble and of Jazzy, and the definitions in the file alone; all floats are 64 bits but colours."""
    _, _, path, messages = recorded(name)
    jazzy, alone = by_rosbags(path, "ROS2_JAZZY"), by_mcap(path)
    for topic, said in messages.items():
        assert (
            [one[:2] for one in said] == [one[:2] for one in jazzy[topic]] == [one[:2] for one in alone.get(topic, [])]
        )
        for one, other, third in zip(said, jazzy[topic], alone.get(topic, []), strict=True):
            assert plain(one.message) == plain(other.message) == plain(third.message)


def test_checksums_indexes_and_summary_are_those_of_the_records(recorded):
    _, _, path, messages = recorded("mecanum")
    found = records(path)
    assert (found[0].profile, found[0].library) == ("ros2", f"omnisim {omnisim.__version__}")
    channels = {record.topic: record for record in found if type(record).__name__ == "Channel"}
    schemas = {record.id: record for record in found if type(record).__name__ == "Schema"}
    assert set(channels) == set(messages)
    for channel in channels.values():
        assert (channel.message_encoding, schemas[channel.schema_id].encoding) == ("cdr", "ros2msg")


def test_a_flipped_bit_is_noticed(recorded, tmp_path):
    _, _, path, _ = recorded("mecanum")
    image = bytearray(path.read_bytes())
    image[len(image) // 3] ^= 1
    (tmp_path / "damaged.mcap").write_bytes(image)
    with pytest.raises(Exception, match=r"(?i)crc|decompress|corrupt"):
        by_mcap(tmp_path / "damaged.mcap")


def test_rosbag2_is_told_which_topics_to_keep_for_those_who_come_later(recorded):
    from rosbags.highlevel import AnyReader

    with AnyReader([recorded("mecanum")[2]]) as reader:
        qos = {connection.topic: connection.ext.offered_qos_profiles for connection in reader.connections}
    kept = {topic for topic, found in qos.items() if found and found[0].durability.name == "TRANSIENT_LOCAL"}
    assert kept == {"/robot_description", "/tf_static", "/machine_markers"}
    assert not any(qos[topic] for topic in set(qos) - kept)


def test_the_same_run_is_the_same_file(recorded):
    run, _, path, _ = recorded("omni")
    before = path.read_bytes()
    write(run, path, overwrite=True)
    assert path.read_bytes() == before


def test_events_are_a_log_with_levels(recorded):
    run, _, _, messages = recorded("mecanum")
    assert len(messages["/events"]) == len(run["events/time"]) > 1
    rows = zip(*(run[f"events/{key}"].tolist() for key in ("time", "kind", "wheel", "roller_to")), strict=True)
    for (time, _, log), (seconds, kind, wheel, second) in zip(messages["/events"], rows, strict=True):
        assert time == round(seconds * 1e9) == log.stamp.sec * 10**9 + log.stamp.nanosec
        assert log.name == wheel and log.msg.split()[0] == kind
        assert log.level == {"exchange": 10, "stick": 20, "slip": 20}[kind]
        assert kind != "exchange" or log.msg.endswith(f"to roller {second}")


def test_a_run_that_stops_early_says_so_and_has_its_rows(tmp_path):
    run = omnisim.simulate(parse(tomlkit.dumps(FREE["short shapes"]), overrides=SHORT))
    path = write(run, tmp_path / "run.mcap")[0]
    messages = by_rosbags(path, "ROS2_JAZZY")
    assert not run.complete
    last = messages["/events"][-1].message
    assert (last.level, last.msg) == (40, f"stop: {run.attributes['status']}")
    assert len(messages["/tf"]) == len(run.time)


# --- the command ----------------------------------------------------------------------------------


def test_the_command_writes_the_recording_the_urdf_and_the_meshes(folder):
    run_of("omni").save("kiwi.h5")
    result = command("export", "kiwi.h5", "kiwi.mcap")
    names = ["kiwi.mcap", "kiwi.urdf", "kiwi_omni_roller.stl"]
    assert result.exit_code == 0 and all(name in result.stdout for name in names), result.stderr
    assert sorted(path.name for path in folder.iterdir()) == sorted(["kiwi.h5", *names])
    refused(command("export", "kiwi.h5", "kiwi.mcap"), "kiwi.mcap: exists already; --force")
    for name in names[:2]:
        (folder / name).unlink()
    assert command("export", "kiwi.h5", "kiwi.mcap").exit_code == 0  # the mesh is that of the same wheel, and stays
    for name in names[:2]:
        (folder / name).unlink()
    (folder / names[2]).write_text("precious")
    refused(command("export", "kiwi.h5", "kiwi.mcap"), f"{names[2]}: exists already; --force")
    assert (folder / names[2]).read_text() == "precious" and not (folder / names[0]).exists()
    assert command("export", "kiwi.h5", "kiwi.mcap", "--force").exit_code == 0
    assert (folder / names[2]).stat().st_size > 1e5


def test_a_scene_that_cannot_be_read_is_told_and_nothing_written(folder):
    synthetic_trajectory().save("made.h5")
    result = command("export", "made.h5", "made.mcap")
    assert result.exit_code == 2 and result.stderr.startswith("Error: made.h5: scene of the file:1: time: missing")
    assert [path.name for path in folder.iterdir()] == ["made.h5"]


def test_a_run_goes_into_a_recording_at_once(folder):
    result = command("run", "kiwi", "-o", "kiwi.mcap", "--set", "time.end=0.02")
    assert result.exit_code == 0, result.stderr
    assert (folder / "kiwi.urdf").exists() and len(by_rosbags(folder / "kiwi.mcap", "ROS2_HUMBLE")["/tf"]) == 2
