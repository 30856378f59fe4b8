"""What a Loop shows of its machine at this instant: each a number or an array of its own, W wheels in scene order.

Looking changes nothing: forces are evaluated once for each instant somebody asks for them, in memory of their own, with
the inputs that have acted up to now. What is set after the last step acts, and shows, from the next one on.
"""

from collections.abc import Mapping
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from omnisim.base.copying import copied
from omnisim.base.records import plain
from omnisim.contact.set_valued import STICK
from omnisim.dynamics.parameters import Parameters
from omnisim.dynamics.state import YAW, Places, Run, X, Y, places_in
from omnisim.march.initial_state import blank_rows
from omnisim.march.observation import Observed, observed_rows
from omnisim.results.observables import body
from omnisim.results.spatial import body_in_space
from omnisim.scene.scene import Scene

Vector = NDArray[np.float64]


class Sensors:
    """Motion, forces and contacts of a run where it stands."""

    scene: Scene
    parameters: Parameters
    run: Run
    names: Mapping[str, int]  # of the wheels, to where they stand in the arrays
    _dt: float
    _seen: Observed | None = None  # of this instant, once somebody asked

    @cached_property
    def _at(self) -> Places:
        return places_in(self.parameters)

    @property
    def time(self) -> float:
        """s"""
        return int(self.run.clock["step"]) * self._dt

    @property
    def yaw(self) -> float:
        """rad; of a machine free in space within -pi and pi"""
        return float(self._in_space["body/yaw"][0] if self._free else self.run.y[YAW])

    @property
    def yaw_rate(self) -> float:
        """rad/s"""
        return float(self._in_space["body/yaw_rate"][0] if self._free else self.run.y[self._at.yaw_rate])

    @property
    def yaw_acceleration(self) -> float:
        """rad/s^2"""
        if self._free:
            return float(self._in_space["body/yaw_acceleration"][0])
        return float(self._observed.slopes[0, self._at.yaw_rate])

    @property
    def height(self) -> float:
        """Of the chassis origin over the base plane, m: 0 of a machine that is held upright."""
        return float(self._in_space["body/position"][0, 2]) if self._free else 0.0

    @property
    def orientation(self) -> Vector:
        """Unit quaternion w, x, y, z from chassis axes to world axes."""
        if self._free:
            return self._in_space["body/orientation"][0].copy()
        return np.array([np.cos(0.5 * self.yaw), 0.0, 0.0, np.sin(0.5 * self.yaw)])

    @property
    def angular_velocity(self) -> Vector:
        """Of the chassis, world axes, rad/s."""
        if self._free:
            return self._in_space["body/angular_velocity"][0].copy()
        return np.array([0.0, 0.0, self.yaw_rate])

    @property
    def position(self) -> Vector:
        """Of the chassis origin or the centre of a bare wheel: x, y, m."""
        return self._in_space["body/position"][0, :2].copy() if self._free else self.run.y[[X, Y]] - self._to_centre()

    @property
    def velocity(self) -> Vector:
        """Of the same point: x, y, m/s, world axes."""
        if self._free:
            return self._in_space["body/velocity"][0, :2].copy()
        x, y = self._to_centre()
        v = self._at.velocity
        return self.run.y[v : v + 2] + self.yaw_rate * np.array([y, -x])

    @property
    def acceleration(self) -> Vector:
        """Of the same point: x, y, m/s^2, world axes."""
        if self._free:
            return self._in_space["body/acceleration"][0, :2].copy()
        parameters = self.parameters._replace(machine=plain(self.parameters.machine))
        bare = self.scene.config.chassis is None
        return body(parameters, self.run.y[None], self._observed.slopes, bare)["body/acceleration"][0, :2]

    @property
    def spin_angles(self) -> Vector:
        """(W,), rad"""
        return self.run.y[self._at.spin_angle :][: len(self.names)].copy()

    @property
    def spin_rates(self) -> Vector:
        """(W,), rad/s"""
        return self.run.y[self._at.spin_rate :][: len(self.names)].copy()

    @property
    def spin_accelerations(self) -> Vector:
        """(W,), rad/s^2"""
        return self._observed.slopes[0, self._at.spin_rate :][: len(self.names)].copy()

    @property
    def drive_torques(self) -> Vector:
        """Of the drives on their disks about the axles (W,), N m."""
        return self._contacts("drive_torque")

    @property
    def normal_forces(self) -> Vector:
        """Of the floor on the wheels (W,), N; 0 of a wheel in the air."""
        return self._contacts("normal_force")

    @property
    def friction_forces(self) -> Vector:
        """Of the floor on the rollers in contact (W, 2), N: along each wheel's heading, and to the left."""
        return self._contacts("friction_force")

    @property
    def slip_velocities(self) -> Vector:
        """Of the rollers in contact at their contact points (W, 2), m/s, in the same directions."""
        return self._contacts("slip_velocity")

    @property
    def contact_rollers(self) -> NDArray[np.int64]:
        """Which roller of each wheel touches the floor (W,), counted from 0. In space: of several the one that carries
        most, -1 in the air."""
        if self._free:
            return np.asarray(self._observed.wheels)["roller"][0].copy()
        return np.asarray(self.run.mode)["roller"] % np.asarray(self.parameters.wheels)["rollers"]

    @property
    def contact_shares(self) -> Vector:
        """Of that roller in the load of its wheel (W,): 1, or less while the one behind it carries the rest."""
        return self._contacts("share")

    @property
    def sticking(self) -> NDArray[np.bool_]:
        """Whether that roller sticks to the floor (W,); under laws other than coulomb none ever does."""
        sticks = np.asarray(self.run.mode)["grip"][:, 0] == STICK
        return sticks & (self.parameters.machine.slip_layer == 0.0)

    @property
    def odometry(self) -> Vector:
        """Pose that ideal wheels without slip would report: x, y, yaw (m, rad).

        Raises ValueError for a machine whose wheels tell no pose.
        """
        if not self.parameters.machine.odometry:
            raise ValueError("the spin rates of this machine's wheels tell no pose")
        yaw = self.parameters.machine.odometry_yaw + self.spin_angles @ self.parameters.wheels.odometry[:, 2]
        return np.append(self.run.y[self._at.odometry : self._at.odometry + 2], yaw)

    def _to_centre(self) -> Vector:
        """C from the chassis origin, world axes, m."""
        (x, y), yaw = self.parameters.machine.centre, self.run.y[YAW]
        return np.array([x * np.cos(yaw) - y * np.sin(yaw), x * np.sin(yaw) + y * np.cos(yaw)])

    @property
    def _free(self) -> bool:
        """Whether the machine is free in space."""
        return self.parameters.space is not None

    @property
    def _in_space(self) -> dict[str, np.ndarray]:
        """Datasets of the body of a machine free in space at this instant."""
        return body_in_space(self.parameters, self.run.y[None], self._observed.slopes)

    def _contacts(self, field: str) -> Vector:
        return np.asarray(self._observed.wheels)[field][0].copy()

    @property
    def _observed(self) -> Observed:
        """Of a row that holds this instant; `workspace` is a copy, since searches in it begin where the last one
        ended."""
        if self._seen is None:
            rows = blank_rows(self.run, 1)
            run = self.run
            rows.y[0], rows.rates[0], rows.piece[0] = run.y, run.rates, run.clock.piece
            np.asarray(rows.mode)[0] = np.asarray(run.mode)  # quicker than as records
            parameters = self.parameters._replace(workspace=copied(self.parameters.workspace))
            self._seen = observed_rows(parameters, rows, np.array([self.time]))
        return self._seen
