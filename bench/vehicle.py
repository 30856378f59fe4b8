"""The authors' vehicle of three omni wheels against its ideal, whose rollers have no mass.

    python -m bench.vehicle 1000        as long as the authors ran it: about twenty minutes

The ideal. Axles are radial, rollers lie along the rim (psi = 0). Without slip along the axis of the roller in contact
wheel i, at distance rho, rolls forward as fast as it moves: r phi_i' = v . h_i + rho omega, h_i its heading. That holds
for real rollers as well, wherever on the roller the contact is: their axes lie in the plane of h_i and the normal, so a
turning roller moves its contact point along the axle alone, and cos(q) cancels. A roller without mass carries no force
along the axle. So F_i acts along h_i, J phi_i'' = -r F_i, and with sum h_i = 0 and sum h_i h_i^T = 3/2

    sum F_i h_i = -(3 J / 2 r^2) v'    v' in chassis axes        m (v' + omega x v) = sum F_i h_i
    sum F_i rho = -(3 J rho^2 / r^2) omega'                      I omega' = sum F_i rho

    omega' = 0        (m + 3 J / 2 r^2) v' = -m omega x v

|v| and omega are constant; the velocity turns in the world at Omega = omega (3 J / 2 r^2) / (m + 3 J / 2 r^2), and the
centre runs on a circle of radius |v| / Omega. m: mass of everything, kg; J: of a wheel about its axle with its rollers,
kg m^2; r: m; I: yaw inertia, kg m^2; v: m/s; omega: rad/s.

The share. Mass and inertia of the rollers times s; what they lose is added to the disk, so that m, J, I and every load
stay. What is left of a roller is its inertia about its own axis, s Ia: it takes a force to spin up, and energy to skid.
"""

import sys
from typing import NamedTuple

import numpy as np

import omnisim
from bench.common import Claim, table
from omnisim.results.comparison import energy_error
from omnisim.results.trajectory import Trajectory
from omnisim.scene.ideal_kinematics import wheel_rows
from omnisim.scene.schema import Config

SCENE, WHEEL = "authors_vehicle", "wheel_types.omni"
STARTS = {"in place": (0.0, 0.0, 1.0), "straight": (1.0, 0.0, 0.0), "both": (1.0, 0.0, 1.0)}  # twists: m/s, m/s, rad/s
COULOMB = "friction={law='coulomb', coefficient=0.85}"
# Overrides and step (s) of radau5. Viscous friction knows no load: on its wheels alone the vehicle tips at an exchange.
LAWS = {
    "coulomb": ((COULOMB,), 1e-3),
    "saturated": ((), 1e-2),
    "viscous": (("friction={law='viscous', viscosity=8.5e5}", "scene.upright='servo'"), 1e-2),
}
SYMMETRIC = {("viscous", "in place"): 1e-3, ("viscous", "straight"): 1e-3}  # s; at 1e-2 rounding tells the wheels apart
SHARES = (1.0, 0.3, 0.1, 0.03, 0.01, 0.003, 0.001)
SHORT = 20.0  # s, of the table of shares
PROPORTIONAL = 0.99  # least exponent of the share in the distance after SHORT
NOTES = """Method radau5. Energy: the largest imbalance in any row, relative to the initial kinetic energy. Distance:
from the ideal motion with the same twist at the start. The wheels start at rest on the chassis, or as if it yawed
alone, so that all but the first start begin with a skid, over at 1 s. Viscous friction: with upright = "servo"."""


class Ideal(NamedTuple):
    """Motion of the ideal vehicle: velocity (m/s, complex) at the start, its turning rate and the yaw rate (rad/s)."""

    velocity: complex
    turning: float
    yaw_rate: float

    @classmethod
    def of(cls, config: Config, twist: tuple[float, float, float]) -> "Ideal":
        (kind,) = config.wheel_types.values()
        roller, count = kind.roller, kind.roller_count
        axle = kind.disk.inertia_axle + count * (roller.mass * kind.roller_distance**2 + roller.inertia_transverse)
        mass = config.chassis.mass + 3 * (kind.disk.mass + count * roller.mass)
        spinning = 1.5 * axle / kind.radius**2
        return cls(complex(*twist[:2]), twist[2] * spinning / (mass + spinning), twist[2])

    def position(self, time: np.ndarray) -> np.ndarray:
        """On the circle, m (complex)."""
        if self.turning == 0.0:
            return self.velocity * time
        return self.velocity * np.expm1(1j * self.turning * time) / (1j * self.turning)


def vehicle(start: str, law: str, end: float) -> Trajectory:
    """The authors' own start and friction."""
    vx, _, yaw_rate = STARTS[start]
    overrides, step = LAWS[law]
    spins = [f"wheels.{name}.spin_rate={3.0 * yaw_rate!r}" for name in "abc"]  # omega rho / r
    motion = f"initial={{velocity=[{vx!r}, 0.0], yaw_rate={yaw_rate!r}}}"
    return run(end, "radau5", SYMMETRIC.get((law, start), step), motion, *spins, *overrides)


def light(share: float, start: str, end: float) -> Trajectory:
    """The vehicle with a share of the rollers' mass, started without slip but of the rollers, Coulomb friction."""
    config = omnisim.load(SCENE).config
    (kind,) = config.wheel_types.values()
    disk, roller, moved = kind.disk, kind.roller, kind.roller_count * (1.0 - share)
    ring = moved * (roller.mass * kind.roller_distance**2 + roller.inertia_transverse)
    hub = (disk.mass + moved * roller.mass, disk.inertia_axle + ring, disk.inertia_diameter + ring / 2)
    scaled = tuple(share * value for value in (roller.mass, roller.inertia_axial, roller.inertia_transverse))
    vx, vy, yaw_rate = STARTS[start]
    spins = wheel_rows(config) @ STARTS[start]
    return run(
        end, "rk4", 1e-3, COULOMB,
        WHEEL + ".disk={{mass={!r}, inertia_axle={!r}, inertia_diameter={!r}}}".format(*hub),
        WHEEL + ".roller={{mass={!r}, inertia_axial={!r}, inertia_transverse={!r}}}".format(*scaled),
        f"initial={{velocity=[{vx!r}, {vy!r}], yaw_rate={yaw_rate!r}}}",
        *(f"wheels.{name}.spin_rate={float(rate)!r}" for name, rate in zip("abc", spins, strict=True)),
    )  # fmt: skip


def run(end: float, method: str, step: float, *overrides: str) -> Trajectory:
    """Trajectory of the vehicle that must reach its end, with a row every second."""
    solver = (f"time.end={end!r}", "time.output_interval=1.0", f"time.step={step!r}", f"solver.method={method}")
    found = omnisim.simulate(omnisim.load(SCENE, (*solver, *overrides)))
    if not found.complete:
        raise RuntimeError(found.attributes["status"])
    return found


def distance(found: Trajectory, start: str, row: int = -1) -> float:
    """From the ideal motion: of the centre, m; in place of the yaw, rad."""
    ideal, time = Ideal.of(omnisim.load(SCENE).config, STARTS[start]), found.time
    if start == "in place":
        return float(abs(found["body/yaw"][row] - ideal.yaw_rate * time[row]))
    return float(abs(found["body/position"][row, :2] @ [1.0, 1j] - ideal.position(time)[row]))


def slope(distances: dict[float, float]) -> float:
    """Exponent of the share in the distance, between the two smallest shares."""
    small, large = sorted(distances)[:2]
    return float(np.log(distances[large] / distances[small]) / np.log(large / small))


def measure(seconds: int) -> dict:
    """seconds: of the long motions."""
    motions = [motion(start, law, float(seconds)) for law in LAWS for start in STARTS]
    shares: dict[str, dict[str, dict[float, float]]] = {}
    for start in STARTS:
        found = {share: light(share, start, max(SHORT, float(seconds))) for share in SHARES}
        for end in sorted({SHORT, max(SHORT, float(seconds))}):
            column = {share: distance(trajectory, start, round(end)) for share, trajectory in found.items()}
            shares.setdefault(f"{end:g}", {})[start] = column
    return {"motions": motions, "shares": shares}


def motion(start: str, law: str, seconds: float) -> dict[str, object]:
    """A row of the first table."""
    found = vehicle(start, law, seconds)
    speed, yaw_rate = np.hypot(*found["body/velocity"][:, :2].T), found["body/yaw_rate"]
    return {
        "law": law,
        "start": start,
        "step": found.attributes["step"],
        "speeds": [float(value) for value in speed[[1, -1]]],
        "yaw_rates": [float(value) for value in yaw_rate[[1, -1]]],
        "distance": distance(found, start),
        "energy": energy_error(found).relative,
        "exchanges": int(np.sum(found["events/kind"] == "exchange")),
        "times_real_time": float(seconds / found.attributes["wall_time"]),
        "seconds": seconds,
    }


def report(result: dict) -> str:
    rows = [
        [row["law"], row["start"], f"{row['step']:g}", *(f"{value:z.6f}" for value in row["speeds"]),
         *(f"{value:z.6f}" for value in row["yaw_rates"]), f"{row['distance']:.3g} {unit(row['start'])}",
         f"{row['energy']:.0e}", row["exchanges"], f"{row['times_real_time']:.0f}"]
        for row in result["motions"]
    ]  # fmt: skip
    end = f"{result['motions'][0]['seconds']:g} s"
    header = ["friction", "start", "step, s", "speed at 1 s, m/s", f"at {end}", "yaw rate at 1 s, rad/s",
              f"at {end}", "distance from the ideal", "energy", "exchanges", "times real time"]  # fmt: skip
    return "\n\n".join([table(header, rows), NOTES, share_table(result["shares"])])


def unit(start: str) -> str:
    return "rad" if start == "in place" else "m"


def share_table(shares: dict[str, dict[str, dict[float, float]]]) -> str:
    """Distances by share, and the slope of the last two."""
    columns = [(f"{start}, {unit(start)}, after {end} s", found)
               for end, starts in shares.items() for start, found in starts.items()]  # fmt: skip
    rows = [[f"{share:g}", *(f"{found[share]:.3g}" for _, found in columns)] for share in SHARES]
    rows.append(["slope", *(f"{slope(found):.3f}" for _, found in columns)])
    title = "Distance from the ideal by the share of the rollers' mass; Coulomb friction, rk4, step 1e-3 s:"
    return f"{title}\n\n{table(['share', *(name for name, _ in columns)], rows)}"


def claims(result: dict) -> list[Claim]:
    least = min(slope(found) for found in result["shares"][f"{SHORT:g}"].values())
    text = f"exponent of the rollers' share of mass in the distance from the ideal vehicle after {SHORT:g} s"
    return [Claim(text, least, "at least", PROPORTIONAL, PROPORTIONAL)]


if __name__ == "__main__":
    print(report(measure(int(sys.argv[1]))))
