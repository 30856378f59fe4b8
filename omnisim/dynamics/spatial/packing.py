"""From a scene to the numbers that kernels know of a machine free in space: a Space."""

import math

import numpy as np

from omnisim.base.records import Record, blank, single
from omnisim.base.trigonometry import exact_cos_sin
from omnisim.contact.floor import floor_of
from omnisim.contact.support import MOST_ARCS, NO_ENVELOPE, SHAPE
from omnisim.dynamics.ground import floor_of_scene
from omnisim.dynamics.inertia import central_inertia
from omnisim.dynamics.spatial.records import (
    BODY,
    CARRIER,
    CHANGES,
    HELD,
    HUB,
    MOTION,
    SLOTS,
    STAND,
    TOUCH,
    Holding,
    Space,
)
from omnisim.scene import rollers
from omnisim.scene.generatrix import edge, ends, generatrix, thickest
from omnisim.scene.ground_schema import Rocker
from omnisim.scene.lobes import Lobe, lobes
from omnisim.scene.masses import chassis_box, common_centre, point_masses, row_shift, wheel_mass
from omnisim.scene.schema import Config, Wheel
from omnisim.scene.solids import outline, profile
from omnisim.scene.wheel_schema import WheelType

Rigid = tuple[float, np.ndarray, np.ndarray, np.ndarray]  # mass, centre, inertia about it, what of it leans
PLANE = floor_of(np.zeros((0, 4)), np.zeros((0, 6)), np.zeros((0, 0)), (0.0, 0.0), (1.0, 1.0))
BEYOND = 2.0  # no tilt is
DIRECTIONS = 257  # across the axle, over half a turn
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def pack_space(config: Config, wheels: list[dict], machine: dict) -> Space:
    """The Space of a scene whose wheels have these values of WHEEL records, and whose machine these of MACHINE."""
    types = [config.type_of(wheel) for wheel in config.wheels]
    masses, points = point_masses(config)
    centre = np.array(common_centre(masses, points))
    standing = carried_wheels(config)
    inertias = [wheel_inertia(*each) for each in zip(types, config.wheels, strict=True)]
    assert config.chassis is not None
    rolling = [
        (masses[w], points[w] - centre, inertias[w], lean(wheel, wheels[w])) for w, wheel in enumerate(config.wheels)
    ]
    carriers = [carrier_values(config, one, [rolling[w] for w in one], centre) for one in standing]
    taken = {w for one in standing for w in one}
    fixed = [one for w, one in enumerate(rolling) if w not in taken]
    chassis = masses[-1], points[-1] - centre, np.diag(config.chassis.inertia), np.zeros((3, 3))
    mass, moment, inner, whole = united([*fixed, chassis])
    counts = [kind.rollers for kind in types]
    mounted = zip(types, config.wheels, wheels, strict=True)
    shapes = [shape_values(kind, wheel) for kind, wheel in zip(types, wheels, strict=True)]
    first = np.cumsum([0, *map(len, shapes)]).tolist()
    floor = floor_of_scene(config)
    body = {
        "uneven": floor is not None,
        "mass": math.fsum(masses),
        "mobility": 1.0 / math.fsum(masses),
        "base_mass": mass,
        "moment": moment if carriers else np.zeros(3),
        "inertia": whole,
        "turning": np.linalg.inv(whole),
        "inner_inertia": inner,
        "gravity": (*machine["downhill"], -machine["gravity"]),
        "chassis": np.array(config.chassis.center_of_mass) - centre,
        "origin": -centre,
        **hull(config, centre),
    }
    return Space(
        body=record(BODY, body),
        hubs=array_of(
            HUB,
            [
                hub_values(*each, centre)
                | {"carrier": carrier_of(standing, w), "first_lobe": first[w], "lobes": len(shapes[w])}
                | {"reach": reach_of(types[w], shapes[w]), "girth": girth_of(types[w])}
                for w, each in enumerate(mounted)
            ],
        ),
        shapes=array_of(SHAPE, [values for each in shapes for values in each]),
        disk=disk_places(types, config.wheels, max(counts)),
        floor=floor or PLANE,
        carriers=array_of(CARRIER, carriers),
        stands=blank(STAND, len(wheels)),
        touches=blank(TOUCH, SLOTS * len(wheels)),
        motions=blank(MOTION, len(carriers)),
        pushes=np.zeros((1 + len(carriers), 6)),
        balance=np.zeros((6 + len(carriers), 6 + len(carriers))),
        answer=np.zeros(6 + len(carriers)),
        shifted=np.zeros(machine["places"].rho),
        bent=np.zeros(machine["places"].rho),
        last=np.zeros(machine["places"].rho),
        changes=np.zeros((1 + CHANGES * len(wheels), 3), np.int64),
        holding=holding(len(wheels), len(carriers)) if config.friction.law == "coulomb" else None,
    )


def holding(wheels: int, carriers: int) -> Holding:
    """Workspace for all contacts that a machine of so many wheels and carriers may have at rest."""
    contacts = SLOTS * wheels
    count = 2 * contacts
    levers = np.zeros((2, contacts, 2, 6 + carriers))
    equations = np.zeros((2, count, count))
    return Holding(blank(HELD, contacts), levers[0], levers[1], equations[0], equations[1], np.zeros(count))


def record(dtype: np.dtype, values: dict) -> Record:
    return single(dtype, array_of(dtype, [values]))


def array_of(dtype: np.dtype, rows: list[dict]) -> np.recarray:
    """Records whose fields may be arrays."""
    found = blank(dtype, len(rows))
    for one, values in zip(found, rows, strict=True):
        for name, value in values.items():
            one[name] = value
    return found


def carried_wheels(config: Config) -> list[tuple[int, ...]]:
    """The wheels of each carrier: of suspensions, then of rockers."""
    names = [wheel.name for wheel in config.wheels]
    hubs = [(w,) for w, wheel in enumerate(config.wheels) if wheel.suspension is not None]
    return [*hubs, *(tuple(names.index(name) for name in rocker.wheels) for rocker in config.axles)]


def heading_of(wheel: Wheel) -> tuple[np.ndarray, np.ndarray]:
    """h and k in chassis axes."""
    cos, sin = exact_cos_sin(wheel.heading_deg)
    return np.array([cos, sin, 0.0]), np.array([-sin, cos, 0.0])


def wheel_inertia(kind: WheelType, wheel: Wheel) -> np.ndarray:
    """Of a wheel with its rollers, and of the hub of a suspension, about their common centre of mass; without the
    inertia about the axle, which turns on its own."""
    _, k = heading_of(wheel)
    across = np.eye(3) - np.outer(k, k)
    if wheel.suspension is None:
        return central_inertia(kind) * across
    hub, mass = wheel.suspension, wheel_mass(kind)
    apart = hub.mass * mass / (hub.mass + mass) * row_shift(kind) ** 2
    return (central_inertia(kind) + apart) * across + hub.inertia * np.eye(3)


def lean(wheel: Wheel, values: dict) -> np.ndarray:
    """The part of rotor and disk that turns with what carries them, about k."""
    _, k = heading_of(wheel)
    return leaning(values) * np.outer(k, k)


def leaning(values: dict) -> float:
    disk, rotor = values["axle_inertia"], values["rotor_inertia"]
    return disk if values["follows"] else disk * rotor / (disk + rotor)


def united(bodies: list[Rigid]) -> tuple[float, np.ndarray, np.ndarray, np.ndarray]:
    """Mass, first moment and inertia about the origin of bodies (mass, centre, inertia about it, what leans), without
    and with what leans."""
    mass = math.fsum(m for m, *_ in bodies)
    moment = np.array([math.fsum(m * r[i] for m, r, *_ in bodies) for i in range(3)])
    inner = sum(inertia + m * (r @ r * np.eye(3) - np.outer(r, r)) for m, r, inertia, _ in bodies)
    return mass, moment, inner, inner + sum(leaning for *_, leaning in bodies)


def carrier_values(config: Config, wheels: tuple[int, ...], bodies: list[Rigid], centre: np.ndarray) -> dict:
    """Values of a CARRIER record of these wheels, which are bodies about C, `centre` in chassis axes."""
    own = math.fsum(mass for mass, *_ in bodies)
    middle = sum(mass * place for mass, place, *_ in bodies) / own
    _, _, inner, whole = united([(mass, place - middle, inertia, leans) for mass, place, inertia, leans in bodies])
    found = {"mass": own, "centre": middle, "inertia": whole, "inner_inertia": inner}
    spring = config.wheels[wheels[0]].suspension
    if spring is not None:
        return found | {
            "turns": 0,
            "axis": AXES["z"],
            "point": np.zeros(3),
            "stiffness": spring.stiffness,
            "damping": spring.damping,
            "preload": spring.preload,
        }
    rocker = rocker_of(config, wheels)
    point = np.array(rocker.point) - centre
    still = {"stiffness": 0.0, "damping": 0.0, "preload": 0.0}
    return found | still | {"turns": 1, "axis": AXES[rocker.about], "point": point}


def rocker_of(config: Config, wheels: tuple[int, ...]) -> Rocker:
    names = {config.wheels[w].name for w in wheels}
    return next(rocker for rocker in config.axles if set(rocker.wheels) == names)


def carrier_of(standing: list[tuple[int, ...]], w: int) -> int:
    return next((j for j, one in enumerate(standing) if w in one), -1)


def hub_values(kind: WheelType, wheel: Wheel, values: dict, centre: np.ndarray) -> dict:
    """Values of a HUB record, but for its carrier and its lobes."""
    assert kind.contact is not None
    h, k = heading_of(wheel)
    disk, rotor = values["axle_inertia"], values["rotor_inertia"]
    return {
        "centre": np.array([*wheel.position, kind.radius]) - centre,
        "h": h,
        "k": k,
        "stiffness": kind.contact.stiffness,
        "damping": kind.contact.damping,
        "coupled": 0.0 if values["follows"] else disk / (disk + rotor),
        "lean": leaning(values),
        "row_count": len(kind.rows),
    }


def reach_of(kind: WheelType, shapes: list[dict]) -> float:
    """Radius of a sphere about O that holds all rollers of a wheel with these SHAPE records, m."""
    away = math.hypot(kind.roller_distance, max(abs(row.offset) for row in kind.rows))
    return away + max(values["reach"] for values in shapes)


def girth_of(kind: WheelType) -> float:
    """Radius of a cylinder about the axle that holds them, m: how far they reach at most in directions across it. What
    reaches as far as h in two directions 2 a apart reaches h / cos(a) between them."""
    q = np.linspace(-0.5 * np.pi, 0.5 * np.pi, DIRECTIONS)
    cos = math.cos(math.radians(kind.roller_angle_deg))
    far = kind.roller_distance * np.cos(q) + rollers.reach(kind, cos * np.sin(q))
    return float(far.max()) / math.cos(0.5 * (q[1] - q[0]))


def shape_values(kind: WheelType, values: dict) -> list[dict]:
    """Values of the SHAPE records of a roller: of its lobes."""
    if kind.profile.kind == "exact":
        return [exact_values(kind, values)]
    arcs = generatrix(kind.profile)
    half, radius = max(map(abs, ends(arcs))), thickest(arcs)
    sizes = {"radius": radius, "distance": 0.0, "cos_psi": 1.0, "sec_psi": 1.0, "envelope": NO_ENVELOPE}
    return [
        sizes | lobe_values(lobe, half, radius) | {"longest": max(arc.radius for arc in lobe)} for lobe in lobes(arcs)
    ]


def exact_values(kind: WheelType, values: dict) -> dict:
    """Of the exact profile: the envelope between two edges."""
    cos, radius, distance = values["cos_psi"], kind.radius, kind.roller_distance
    tilt = cos * math.sin(kind.covered)
    half, end = map(float, profile(outline(kind), np.array(kind.covered)))
    chain = [edge(-half, end, 1.0, tilt), edge(0.0, 0.0, tilt, -tilt), edge(half, end, -tilt, -1.0)]
    sizes = {"radius": radius, "distance": distance, "cos_psi": cos, "sec_psi": 1.0 / cos, "envelope": 1}
    # in the middle; towards the ends it is a little more
    longest = radius - distance + distance / (cos * cos)
    return sizes | lobe_values(chain, half, radius - distance) | {"longest": longest}


def lobe_values(lobe: Lobe, half: float, radius: float) -> dict:
    """Of a chain of arcs."""
    arcs, tilts = np.zeros((MOST_ARCS, 3)), np.full(MOST_ARCS + 1, -BEYOND)
    arcs[: len(lobe)] = [(arc.u, arc.r, arc.radius) for arc in lobe]
    tilts[: len(lobe)] = [BEYOND, *(arc.start for arc in lobe[1:])]
    reach = math.sqrt(half * half + radius * radius)
    sizes = {"half_length": half, "thickest": radius, "reach": reach, "regions": len(lobe)}
    return sizes | {"arcs": arcs, "tilts": tilts}


def disk_places(types: list[WheelType], wheels: tuple[Wheel, ...], most: int) -> np.ndarray:
    """(W, 3, N): cosine and sine of the angle of each roller on its disk, and its offset; rows take turns."""
    places = np.zeros((len(wheels), 3, most))
    for own, kind, wheel in zip(places, types, wheels, strict=True):
        rows = len(kind.rows)
        rings = kind.rings
        for i in range(kind.rollers):
            row = rings[i % rows]
            angle = math.radians(wheel.phase_deg + row.phase_deg) + 2.0 * math.pi * (i // rows) / kind.roller_count
            own[:, i] = math.cos(angle), math.sin(angle), row.offset
    return places


def mobility_bound(space: Space, values: dict) -> float:
    """Upper bound of the slip acceleration that a unit force causes anywhere on a roller of a wheel with these values
    of its WHEEL record, 1/kg: no lever is longer than the machine, the wheel and the roller."""
    shapes, radius = space.shapes, values["radius"]
    thick = float(shapes.thickest.max())
    reach = np.linalg.norm(space.hubs.centre, axis=1).max() + radius + shapes.half_length.max()
    turning = float(np.linalg.eigvalsh(np.asarray(space.body.turning))[-1])
    machine = 1.0 / space.body.mass + turning * reach**2
    spin = values["spin_mobility"] * (radius + thick) ** 2
    return machine + spin + values["axial_mobility"] * thick**2


def hull(config: Config, centre: np.ndarray) -> dict:
    """Corners of the chassis that must not touch the ground; its centre of mass where the scene gives no size."""
    assert config.chassis is not None
    corners = np.zeros((8, 3))
    box = chassis_box(config)
    if box is None:
        corners[:] = np.array(config.chassis.center_of_mass) - centre
        return {"hull": corners, "corners": 1}
    low, high = box
    corners[:] = [[(low, high)[(i >> j) & 1][j] - centre[j] for j in range(3)] for i in range(8)]
    return {"hull": corners, "corners": 8}
