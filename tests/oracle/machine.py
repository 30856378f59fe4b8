r"""A bare wheel or a vehicle as free rigid bodies held together by multipliers: the equations of the oracle.

They follow from the Newton-Euler equations and the constraints alone, import nothing of omnisim and share none of
its reductions: no generalized coordinates, no normal force known beforehand, no composite inertia.
It is the model of Kosenko and Gerasimov, "Dynamical model of a vehicle with omni wheels", with z up.
SI units, radians.

        n (up)                    R wheel radius, R1 roller distance, psi roller angle, alpha = pi / N_r
        |                         k = n x h, into the page: spin phi > 0 rolls the wheel towards h
       .|----.                    q = gamma_i - phi      azimuth of roller i from straight down towards h
      / |     \                   d = -cos q n + sin q h   from wheel centre O to roller centre O_i = O + R1 d
     |  O------|--> h (heading)   t = k x d                   rows: O_i = O + R1 d + offset k
      \  \    /                   a = cos(psi) t + sin(psi) k      roller axis
       '--d--'                    P contact point,  p = P - O_i
    =====P========  floor         w angular velocity,  alpha_b = w_b' angular acceleration of body b

Bodies: the chassis, if there is one; then of every wheel the disk and its N_r rollers. Body 0 is the base: the
chassis, with axes x forward, y left, z up, or the disk of a bare wheel, whose y is its axle k.
State of a body: centre of mass x [m], rotation matrix Q [1] whose second column is k of a disk, a of a roller,
y of the chassis, velocity v [m/s], angular velocity w [rad/s], in world axes:

    x' = v     Q' = w x Q     m v' = force     I w' + w x (I w) = torque     I = Q diag(I_1, I_2, I_3) Q^T

Constraints g = 0, imposed as g'' = 0 (the initial state has g = g' = 0), and what their multipliers are. A joint
lets body i, with axis a, turn about a in body j: a roller in its disk, a disk (a = k) in the chassis.

  joint, 3 rows   x_i - x_j - r = 0,  r fixed in j: R1 d; wheel centre from the chassis' centre     force [N]
                  v_i' - v_j' - alpha_j x r = w_j x (w_j x r)
  joint, 2 rows   e . a = 0  for two e fixed in j: d, a x d; h, n of the wheel.  b = a x e          torque [N m]
                  (alpha_i - alpha_j) . b = -(w_i - w_j) . b'
  floor, 1 row    n . x_c - S(s) = 0,  s = a . n: the lowest point of roller c has height 0         N [N]
  for a wheel     n . v_c' + (p x n) . alpha_c = S' n . (w x (w x a)) + S'' s'^2
  servo, 1 row    k . n = 0; for a chassis 2 rows, y . n = 0 and -x . n = 0                         torque [N m]
                  alpha_0 . b = -w_0 . b',  b = y x n (about x), n x x (about y)

c is the roller in contact. S(s), how far a roller reaches below its centre, is the support function of its
profile u(q), r(q) (axial, radial): S = max over q of -u s + r sqrt(1 - s^2), at sin q = -s / cos(psi). There

    S = R - R1 cos q      S' = -R1 tan(q) / cos(psi) = -(u + r s / sqrt(1 - s^2))
    S'' = R1 / (cos(psi)^2 cos(q)^3)

The second form of S', the derivative of a maximum, makes g' the normal velocity n . (v_c + w_c x p) of the
MATERIAL point at p = u a - r (n - s a) / sqrt(1 - s^2). Hence the row (n, p x n), with the reaction at P; and
g'' = 0 is the paper's "zero relative acceleration at the contact": the rate of that normal velocity, taken
along the moving contact.

The floor takes heave, and without a servo roll and pitch, from the machine; any more rows would repeat these. So
the normal forces are N = B beta, and B^T g'' = 0 takes the place of the rows g'': the reactions do no work.

    servo       B = 1               one beta, all wheels carry the same
    contacts    B = (1, X, Y)       N is affine in the place (X, Y) of P on the floor: a rigid chassis on equal springs

All joints held, the rows of the floor are affine in (X, Y) too: B^T g'' = 0 leaves g'' = 0 at every wheel. For three
wheels B is invertible, which is no assumption on the forces at all.

Rubber that creeps (brush) also asks for v_r = v_P - v, with v_P the velocity of the point of contact over the floor,
v_c + p', whose p' is taken by differences of the lowest point as the axis turns.

Rolling resistance is a moment on the roller at P against the part of w_c along the floor, in proportion to N.

Friction on the roller at P, slip v = v_c + w_c x p: F = -mu N g(v) is proportional to the unknown N and so
belongs to the column of N, whose wrench is (f, p x f), f = n - mu g(v). All accelerations and multipliers come from
ONE dense solve of 6 N_bodies + 5 N_joints + 2 (bare wheel) or 3 (vehicle) equations:

    [ M  -W^T ] [ v', alpha_b ]   [ applied forces and torques, -w x (I w) ]      W = J, but for the friction
    [ J    0  ] [ multipliers ] = [ right sides of the rows above          ]      in the columns of beta

Nothing is stabilized: how well g = 0 still holds (`constraint_residual`) measures the integration.
"""

from math import cos, radians, sin, sqrt, tan
from typing import NamedTuple

import numpy as np

from oracle.vectors import AXIS, FLAT, OMEGA, POSITION, ROTATION, UP, VELOCITY, along_turning, cross, skew
from oracle.wheel import Wheel, rolling_resistance


class Mode(NamedTuple):
    """What is frozen between two restarts: the rollers on the floor, and loads = value + slope * (t - begin).

    The loads: drive torque of every wheel about k [N m], force at the centre of mass of the base [N] in world or
    body axes ((h, k, n) of a bare wheel, x, y, z of a chassis), yaw torque [N m].
    """

    contacts: tuple[int, ...]  # by wheel; counted on beyond N_r, as phi is beyond 2 pi
    begin: float
    value: np.ndarray
    slope: np.ndarray


class Touch(NamedTuple):
    """One wheel on the floor."""

    columns: slice  # of v' and w' of its roller in contact
    p: np.ndarray  # contact point from the centre of that roller
    point: np.ndarray  # contact point
    bias: float  # right side of the floor row
    slip: np.ndarray
    per_normal: np.ndarray  # friction over N
    resisting: np.ndarray  # moment of rolling resistance over N, m
    free: np.ndarray  # friction that does not depend on N

    def push(self, force: np.ndarray) -> np.ndarray:
        """Wrench at the centre of the roller of a force at the contact point."""
        return np.concatenate([force, cross(self.p, force)])


class Reactions(NamedTuple):
    acceleration: np.ndarray  # v' and w' of every body, (N_bodies, 6)
    normal_force: np.ndarray  # by wheel
    servo_torque: np.ndarray  # on the base, about h of a bare wheel, or about x and y of a chassis
    friction: np.ndarray  # by wheel, on the roller, world axes
    touches: list[Touch]
    joints: np.ndarray  # force and moment of the joint on each body that hangs on one, at its centre (N_joints, 6)


class Machine:
    """Bodies, joints, floor and loads of a scene, with the defaults of the scene format."""

    def __init__(self, scene: dict) -> None:
        general, friction = scene.get("scene", {}), scene["friction"]
        self.chassis, self.initial = scene.get("chassis"), scene.get("initial", {})
        self.upright = general.get("upright", "contacts" if self.chassis else "servo")
        if not self.chassis and (len(scene["wheels"]) != 1 or self.upright != "servo"):
            raise ValueError("without a chassis the oracle knows one wheel that a servo keeps upright")
        if self.upright == "contacts" and len(scene["wheels"]) < 3:
            raise ValueError("fewer than three contacts carry no vehicle")
        if friction["law"] not in ("regularized", "saturated", "viscous", "brush", "none"):
            raise ValueError(f"the oracle has no friction law {friction['law']!r}")
        slope, uphill = (radians(scene.get("floor", {}).get(f"{key}_deg", 0.0)) for key in ("slope", "uphill"))
        down = np.array([-sin(slope) * cos(uphill), -sin(slope) * sin(uphill), -cos(slope)])
        self.gravity = general.get("gravity", 9.81) * down  # in axes of the floor
        self.law, self.slip_speed = friction["law"], friction.get("slip_speed", 1e-6)
        self.mu = friction["coefficient"] if self.law in ("regularized", "saturated", "brush") else 0.0
        self.creep_stiffness = friction.get("creep_stiffness", 0.0)
        self.viscosity = friction["viscosity"] if self.law == "viscous" else 0.0
        self.wheels, disk = [], 1 if self.chassis else 0
        for entry in scene["wheels"]:
            self.wheels.append(Wheel(entry, scene["wheel_types"][entry["type"]], disk))
            disk = self.wheels[-1].rollers.stop
        self.build()
        self.load(scene.get("wrench", {}))
        self.lay_out()

    @property
    def betas(self) -> int:
        return 1 if self.upright == "servo" else 3

    def build(self) -> None:
        """Masses and principal inertias of the bodies; the joints: parent j, child i, r and the two e in axes of j."""
        masses, inertias, joints = [], [], []
        self.centre = np.array([0.0, 0.0, self.wheels[0].radius])  # of mass of the base, from where its origin stands
        if self.chassis:
            self.centre = np.array(self.chassis["center_of_mass"], dtype=float)
            masses, inertias = [self.chassis["mass"]], [self.chassis["inertia"]]
        for wheel in self.wheels:
            disk, roller = wheel.kind["disk"], wheel.kind["roller"]
            across, along = roller["inertia_transverse"], roller["inertia_axial"]
            masses += [disk["mass"]] + wheel.count * [roller["mass"]]
            inertias += [[disk["inertia_diameter"], disk["inertia_axle"], disk["inertia_diameter"]]]
            inertias += wheel.count * [[across, along, across]]
            if self.chassis:
                arm = np.array([*wheel.entry["position"], wheel.radius]) - self.centre
                heading = radians(wheel.entry.get("heading_deg", 0.0))
                joints.append((0, wheel.disk, arm, [[cos(heading), sin(heading), 0.0], UP]))
            for i, (d, a) in enumerate(zip(wheel.d, wheel.a, strict=True)):
                joints.append((wheel.disk, wheel.rollers.start + i, wheel.place[i], [d, cross(a, d)]))
        self.mass, self.inertia = np.array(masses), np.array(inertias)
        self.parent, self.child, self.arm, self.e = (np.array(column) for column in zip(*joints, strict=True))

    def load(self, wrench: dict) -> None:
        """Tables as (times, values, the loads that they fill); a constant is a table of one point."""
        self.tables = []
        for index, wheel in enumerate(self.wheels):
            drive = wheel.entry["drive"] if wheel.entry.get("drive", {}).get("kind") == "torque" else {"torque": 0.0}
            table = np.array(drive.get("times", [0.0])), np.reshape(drive["torque"], (-1, 1)), slice(index, index + 1)
            self.tables.append(table)
        times = np.array(wrench.get("times", [0.0]))
        force = np.broadcast_to(wrench.get("force", 0.0), (len(times), 3))
        yaw_torque = np.broadcast_to(wrench.get("yaw_torque", 0.0), len(times))
        self.tables.append((times, np.column_stack([force, yaw_torque]), slice(len(self.wheels), None)))
        self.wrench_turns = wrench.get("frame", "world") == "body"

    def mode(self, time: float, contacts: list[int]) -> Mode:
        """The mode that begins at `time`: loads linear between points, held outside; two equal times jump."""
        value, slope = np.zeros((2, len(self.wheels) + 4))
        for times, values, columns in self.tables:
            after = int(np.searchsorted(times, time, side="right"))
            value[columns] = values[max(after - 1, 0)]
            if 0 < after < len(times):
                slope[columns] = (values[after] - values[after - 1]) / (times[after] - times[after - 1])
                value[columns] += slope[columns] * (time - times[after - 1])
        return Mode(tuple(contacts), time, value, slope)

    def lay_out(self) -> None:
        """Where the blocks of the linear system lie, and its constant entries."""
        xyz, bodies, joints = np.arange(3), len(self.mass), len(self.child)
        self.moves = 6 * bodies
        self.turn = 6 * np.arange(bodies)[:, None] + 3 + xyz  # columns of alpha_b
        # rows x_i - x_j - r, rows e . a, rows of beta, rows of the servo
        self.hinge = 5 * np.arange(joints)[:, None] + xyz
        self.align = 5 * np.arange(joints)[:, None] + np.array([3, 4])
        self.floor = slice(5 * joints, 5 * joints + self.betas)
        # y, and -x of a chassis, in axes of the base: a servo keeps them horizontal
        held = 0 if self.upright == "contacts" else 2 if self.chassis else 1
        self.held = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])[:held]
        self.servo = slice(self.floor.stop, self.floor.stop + held)
        self.matrix = np.zeros((self.moves + self.servo.stop,) * 2)
        self.matrix[self.turn - 3, self.turn - 3] = self.mass[:, None]
        self.matrix[self.moves + self.hinge, self.turn[self.child] - 3] = 1.0
        self.matrix[self.moves + self.hinge, self.turn[self.parent] - 3] = -1.0

    def friction(self, slip: np.ndarray, stream: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Force on the roller: what is multiplied by N [1], and what is not [N]; stream: v_r."""
        speed = sqrt(slip @ slip)
        if self.law == "brush":
            by_slip = self.creep_stiffness / sqrt(stream @ stream + self.slip_speed**2)
            theta = by_slip * speed / (3.0 * self.mu)
            if theta >= 1.0:
                return -self.mu * slip / speed, 0.0 * slip
            return -by_slip * (1.0 - theta + theta**2 / 3.0) * slip, 0.0 * slip
        smooth = sqrt(speed**2 + self.slip_speed**2)
        scale = max(speed, self.slip_speed) if self.law == "saturated" else smooth
        return -self.mu * slip / scale, -self.viscosity * slip

    def solve(self, time: float, bodies: np.ndarray, mode: Mode) -> Reactions:
        matrix, right = self.matrix.copy(), np.zeros(len(self.matrix))
        jacobian, bias = matrix[self.moves :], right[self.moves :]
        applied = right[: self.moves].reshape(-1, 6)
        self.add_bodies(bodies, matrix, applied)
        self.add_loads(time, bodies, mode, applied)
        self.add_joints(bodies, jacobian, bias)
        self.add_servo(bodies, jacobian, bias)
        touches = self.touches(bodies, mode.contacts)
        shares = self.shares(bodies, touches)
        for touch, share in zip(touches, shares, strict=True):
            jacobian[self.floor, touch.columns] = np.outer(share, touch.push(UP))
            bias[self.floor] += share * touch.bias
        matrix[: self.moves, self.moves :] = -jacobian[:, : self.moves].T
        forces = matrix[:, self.moves :][:, self.floor]
        for touch, share in zip(touches, shares, strict=True):
            wrench = touch.push(touch.per_normal) + np.concatenate([np.zeros(3), touch.resisting])
            forces[touch.columns] -= np.outer(wrench, share)
            right[touch.columns] += touch.push(touch.free)
        found = np.linalg.solve(matrix, right)
        multipliers = found[self.moves :]
        normal = shares @ multipliers[self.floor]
        friction = np.array([n * touch.per_normal + touch.free for n, touch in zip(normal, touches, strict=True)])
        held = self.joint_wrenches(time, bodies, mode, jacobian, multipliers)
        accelerations = found[: self.moves].reshape(-1, 6)
        return Reactions(accelerations, normal, multipliers[self.servo], friction, touches, held)

    def joint_wrenches(
        self, time: float, bodies: np.ndarray, mode: Mode, jacobian: np.ndarray, multipliers: np.ndarray
    ) -> np.ndarray:
        """What the joints do to the bodies that hang on them: multipliers, and about the axle the drive."""
        rows = np.concatenate([self.hinge, self.align], axis=1)
        columns = np.concatenate([self.turn - 3, self.turn], axis=1)[self.child]
        blocks = jacobian[rows[:, :, None], columns[:, None, :]]
        wrenches = np.einsum("jrc,jr->jc", blocks, multipliers[rows])
        drives = (mode.value + mode.slope * (time - mode.begin))[: len(self.wheels)]
        for wheel, drive in zip(self.wheels, drives, strict=True):
            wrenches[self.child == wheel.disk, 3:] += drive * bodies[wheel.disk, AXIS]
        return wrenches

    def add_bodies(self, bodies: np.ndarray, matrix: np.ndarray, applied: np.ndarray) -> None:
        """Inertia, weight, and the gyroscopic torque -w x (I w)."""
        turned, w = bodies[:, ROTATION].reshape(-1, 3, 3), bodies[:, OMEGA]
        inertia = (turned * self.inertia[:, None, :]) @ turned.transpose(0, 2, 1)
        matrix[self.turn[:, :, None], self.turn[:, None, :]] = inertia
        applied[:, :3] = self.mass[:, None] * self.gravity
        applied[:, 3:] = -cross(w, (inertia @ w[..., None])[..., 0])

    def add_loads(self, time: float, bodies: np.ndarray, mode: Mode, applied: np.ndarray) -> None:
        """Drives turn the disks, and the chassis back; the wrench acts on the base."""
        *drives, along, across, lift, yaw_torque = mode.value + mode.slope * (time - mode.begin)
        for wheel, drive in zip(self.wheels, drives, strict=True):
            torque = drive * bodies[wheel.disk, AXIS]
            applied[wheel.disk, 3:] += torque
            if self.chassis:
                applied[0, 3:] -= torque
        force, y = np.array([along, across, lift]), bodies[0, AXIS]
        if self.wrench_turns:
            force = along * cross(y, UP) + across * y + lift * UP
        applied[0, :3] += force
        applied[0, 3:] += yaw_torque * UP

    def add_joints(self, bodies: np.ndarray, jacobian: np.ndarray, bias: np.ndarray) -> None:
        turned = bodies[self.parent, ROTATION].reshape(-1, 3, 3)
        about, w_j = skew(bodies[self.parent, OMEGA]), bodies[self.parent, None, OMEGA]
        r = turned @ self.arm[..., None]
        jacobian[self.hinge[:, :, None], self.turn[self.parent, None]] = skew(r[..., 0])
        bias[self.hinge] = (about @ about @ r)[..., 0]
        axis, w, e = bodies[self.child, None, AXIS], bodies[self.child, None, OMEGA], self.e @ turned.transpose(0, 2, 1)
        b = cross(axis, e)
        b_rate = cross(cross(w, axis), e) + cross(axis, cross(w_j, e))
        jacobian[self.align[:, :, None], self.turn[self.child, None]] = b
        jacobian[self.align[:, :, None], self.turn[self.parent, None]] = -b
        bias[self.align] = -np.sum((w - w_j) * b_rate, axis=2)

    def add_servo(self, bodies: np.ndarray, jacobian: np.ndarray, bias: np.ndarray) -> None:
        """Rows that keep y, and -x of a chassis, horizontal: torques about x and y."""
        w, held = bodies[0, OMEGA], self.held @ bodies[0, ROTATION].reshape(3, 3).T
        jacobian[self.servo, 3:6] = cross(held, UP)
        bias[self.servo] = -cross(cross(w, held), UP) @ w

    def touches(self, bodies: np.ndarray, contacts: tuple[int, ...]) -> list[Touch]:
        return [self.touch(wheel, bodies, roller) for wheel, roller in zip(self.wheels, contacts, strict=True)]

    def touch(self, wheel: Wheel, bodies: np.ndarray, roller: int) -> Touch:
        """The floor row of a wheel, with and without N the friction on its roller."""
        index = wheel.rollers.start + roller % wheel.count
        body = bodies[index]
        axis, w = body[AXIS], body[OMEGA]
        p, q = wheel.lowest_point(axis)
        axis_rate = cross(w, axis)
        slope = -wheel.roller_distance * tan(q) / wheel.cos_psi
        curvature = wheel.roller_distance / (wheel.cos_psi**2 * cos(q) ** 3)
        bias = slope * cross(w, axis_rate)[2] + curvature * axis_rate[2] ** 2
        slip = (body[VELOCITY] + cross(w, p)) * FLAT
        columns = slice(6 * index, 6 * index + 6)
        stream = (body[VELOCITY] + along_turning(lambda axis: wheel.lowest_point(axis)[0], axis, w)) * FLAT - slip
        per_normal, free = self.friction(slip, stream)
        resisting = rolling_resistance(wheel.kind["roller"], w * FLAT)
        return Touch(columns, p, body[POSITION] + p, bias, slip, per_normal, resisting, free)

    def shares(self, bodies: np.ndarray, touches: list[Touch]) -> np.ndarray:
        """B of N = B beta, (wheels, beta): places on the floor are reckoned from the base."""
        if self.upright == "servo":
            return np.ones((len(touches), 1))
        places = np.array([touch.point for touch in touches]) - bodies[0, POSITION]
        return np.column_stack([np.ones(len(touches)), places[:, :2]])

    def derivative(self, time: float, state: np.ndarray, mode: Mode) -> np.ndarray:
        """Of 18 numbers a body, then every phi and theta: integrated too, as Q knows them only to full turns."""
        bodies = self.bodies(state)
        rate = np.empty_like(bodies)
        rate[:, POSITION] = bodies[:, VELOCITY]
        rate[:, ROTATION] = (skew(bodies[:, OMEGA]) @ bodies[:, ROTATION].reshape(-1, 3, 3)).reshape(-1, 9)
        rate[:, VELOCITY.start :] = self.solve(time, bodies, mode).acceleration
        turning = [wheel.spin_rate(bodies) for wheel in self.wheels]
        return np.concatenate([rate.ravel(), turning, [bodies[0, OMEGA][2]]])

    def bodies(self, state: np.ndarray) -> np.ndarray:
        return state[: 18 * len(self.mass)].reshape(-1, 18)

    def kinetic_energy(self, bodies: np.ndarray) -> float:
        along = (bodies[:, None, OMEGA] @ bodies[:, ROTATION].reshape(-1, 3, 3))[:, 0]
        travel = np.sum(bodies[:, VELOCITY] ** 2, axis=1) @ self.mass
        return 0.5 * float(travel + np.sum(self.inertia * along**2))

    def constraint_residual(self, bodies: np.ndarray, contacts: tuple[int, ...]) -> float:
        """Largest |g| of all constraints, lengths over the radius of the first wheel."""
        turned = bodies[self.parent, ROTATION].reshape(-1, 3, 3)
        gap = bodies[self.child, POSITION] - bodies[self.parent, POSITION] - (turned @ self.arm[..., None])[..., 0]
        tilt = (self.e @ turned.transpose(0, 2, 1) @ bodies[self.child, AXIS, None])[..., 0]
        touches = self.touches(bodies, contacts)
        heights = [touch.point[2] for touch in touches]
        lean = (self.held @ bodies[0, ROTATION].reshape(3, 3).T)[:, 2]
        return max(np.abs(gap).max() / self.wheels[0].radius, np.abs(heights).max() / self.wheels[0].radius,
                   np.abs(tilt).max(), np.abs(lean).max(initial=0.0))  # fmt: skip
