"""What is drawn: arrows of a recording are the forces and the slip of the trajectory, its rollers the exact profile.

Measured values stand beside the bounds.
"""

import math

import numpy as np
import pytest
from recorded_machines import UPRIGHT
from recordings import in_world, matrices, records

from omnisim.cad.mesh import roller
from omnisim.dynamics.ground import floor_of_scene
from omnisim.pictures.ground import heights

pytest.importorskip("mcap", reason="needs mcap")
pytest.importorskip("rosbags", reason="needs rosbags")


def markers_by_row(messages):
    """{(kind, wheel): marker} of every row."""
    return [
        {(marker.ns, marker.text): marker for marker in said.message.markers} for said in messages["/contact_markers"]
    ]


def arrow(marker):
    tail, tip = (np.array([point.x, point.y, point.z]) for point in marker.points)
    return tail, tip - tail


def scales_of(path):
    told = {record.name: record.metadata for record in records(path) if type(record).__name__ == "Metadata"}["omnisim"]
    return {"normal": float(told["m_per_N"]), "friction": float(told["m_per_N"]), "slip": float(told["m_per_m/s"])}


@pytest.mark.parametrize("name", UPRIGHT)
def test_arrows_are_the_forces_and_the_slip_at_the_contact_points(recorded, name):
    run, config, path, messages = recorded(name)
    lengths, shown = scales_of(path), 0
    for row, markers in enumerate(markers_by_row(messages)):
        assert len(markers) == 3 * len(run.wheels)
        for wheel in config.wheels:
            heading = run["body/yaw"][row] + math.radians(wheel.heading_deg)
            cos, sin = math.cos(heading), math.sin(heading)
            h, k = np.array([cos, sin, 0.0]), np.array([-sin, cos, 0.0])
            part = f"wheels/{wheel.name}"
            friction, slip = (run[f"{part}/{key}"][row] for key in ("friction_force", "slip_velocity"))
            expected = {
                "normal": [0.0, 0.0, run[f"{part}/normal_force"][row]],
                "friction": friction[0] * h + friction[1] * k,
                "slip": slip[0] * h + slip[1] * k,
            }
            for kind, vector in expected.items():
                marker = markers[kind, wheel.name]
                assert (marker.header.frame_id, marker.frame_locked, marker.lifetime.sec) == ("world", False, 0)
                if marker.action == 2:
                    assert np.linalg.norm(vector) * lengths[kind] <= 0.01 * config.type_of(wheel).radius
                    continue
                tail, way = arrow(marker)
                shown += 1
                assert tail.tolist() == run[f"{part}/contact_point"][row].tolist()
                np.testing.assert_allclose(
                    way, lengths[kind] * np.array(vector), rtol=0.0, atol=1e-15
                )  # measured 5e-17
                assert np.linalg.norm(way) <= 1.7 * config.type_of(wheel).radius + 1e-15 or kind == "friction"
    assert shown > len(run.time)


@pytest.mark.parametrize("name", ["mecanum", "bare wheel", "rockers"])
def test_the_machine_is_drawn_without_any_file(recorded, name):
    """Rollers as triangles on their exact surface, each in its own frame."""
    _, config, _, messages = recorded(name)
    drawn = {marker.header.frame_id: marker for marker in messages["/machine_markers"][0].message.markers}
    assert all(marker.frame_locked for marker in drawn.values())
    assert set(drawn) <= {stamped.child_frame_id for stamped in messages["/tf"][0].message.transforms}
    if config.chassis:
        assert drawn["chassis"].type == 1
    for wheel in config.wheels:
        assert drawn[f"{wheel.name}_wheel"].type == 3
        profile = roller(config.type_of(wheel), 9, 16).vertices
        for number in range(config.type_of(wheel).rollers):
            points = [[point.x, point.y, point.z] for point in drawn[f"{wheel.name}_roller_{number}"].points]
            assert drawn[f"{wheel.name}_roller_{number}"].type == 11 and len(points) % 3 == 0
            np.testing.assert_array_equal(np.unique(points, axis=0), np.unique(profile, axis=0))


def test_a_wheel_in_the_air_has_no_arrows(recorded):
    run, _, _, messages = recorded("falling")
    assert all(run[f"wheels/{wheel}/contact_roller"].max() == -1 for wheel in run.wheels)
    for markers in markers_by_row(messages):
        assert all((marker.action, marker.points) == (2, []) for marker in markers.values())


@pytest.mark.parametrize(("name", "least"), [("bumps", 1e-2), ("rockers", 5e-4)])
def test_on_uneven_ground_loads_stand_on_it_and_the_rest_lies_along_it(recorded, name, least):
    """h = axle x n, k = n x h; normals by differences of heights, twice as coarse as those of the export."""
    run, config, path, messages = recorded(name)
    floor, step, steep, lengths = floor_of_scene(config), 2e-5, 0.0, scales_of(path)
    for row, (markers, said) in enumerate(zip(markers_by_row(messages), messages["/tf"], strict=True)):
        placed = in_world(matrices(said.message.transforms))
        for wheel in run.wheels:
            if markers["normal", wheel].action == 2:
                continue
            tail, _ = arrow(markers["normal", wheel])
            x, y = tail[0] + step * np.array([1, -1, 0, 0]), tail[1] + step * np.array([0, 0, 1, -1])
            east, west, north, south = heights(floor, x, y)
            up = np.array([west - east, south - north, 2.0 * step])
            up /= np.linalg.norm(up)
            ahead = np.cross(placed[f"{wheel}_wheel"][:3, 1], up)
            ahead /= np.linalg.norm(ahead)
            steep = max(steep, math.hypot(up[0], up[1]))
            expected = {"normal": run[f"wheels/{wheel}/normal_force"][row] * up}
            for kind, key in (("friction", "friction_force"), ("slip", "slip_velocity")):
                h, k = run[f"wheels/{wheel}/{key}"][row]
                expected[kind] = h * ahead + k * np.cross(up, ahead)
            for kind, vector in expected.items():
                if markers[kind, wheel].action == 0:
                    tail, way = arrow(markers[kind, wheel])
                    assert tail.tolist() == run[f"wheels/{wheel}/contact_point"][row].tolist()
                    error = np.linalg.norm(way - lengths[kind] * vector)
                    assert error < 1e-8 * np.linalg.norm(way)  # measured 4e-10
    assert steep > least
