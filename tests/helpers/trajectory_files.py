"""The contract of trajectory files, written out by hand on purpose; what such a file holds, and how one is refused."""

import h5py
import pytest

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


def refusal(path):
    """The one line that read() refuses a file with, without the path it starts with."""
    with pytest.raises(TrajectoryError) as caught:
        open_trajectory(path)
    line = str(caught.value)
    assert "\n" not in line
    assert line.startswith(f"{path}: ")
    return line.removeprefix(f"{path}: ")
