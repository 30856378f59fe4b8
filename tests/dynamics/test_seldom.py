"""What few machines have is in the type of the record of those that may have it, and costs no others anything."""

import numpy as np
import pytest
from scenes import REFERENCE

import omnisim
from omnisim.base import status
from omnisim.base.records import LeanRecord, Record, lean, packer, records, single, without
from omnisim.dynamics.packing import pack
from omnisim.dynamics.parameters import MACHINE, PLAIN, SELDOM
from omnisim.march.initial_state import begin
from omnisim.run.marching import Marching

BRUSHED = {"kind": "dc_motor", "resistance": 1.0, "torque_constant": 0.05}
MOTOR = BRUSHED | {"inductance": 1e-3, "voltage": 1.0}
SAMPLED = BRUSHED | {"proportional": 0.5, "rate": 2.0, "sample_time": 0.01}
FOLLOW = {"kind": "follow", "times": [0.0, 2.0], "angle": [0.0, 4.0]}
BEARINGS = {"bearing_viscosity": 1e-6, "bearing_torque": 1e-5, "bearing_rate": 1.0}
HAVING = [
    ({"solver.tracking": "implicit"}, {"implicit_tracking"}),
    ({"solver.formulation": "multibody"}, {"every_rate"}),
    ({"friction": {"law": "viscous", "viscosity": 3.0}}, {"viscous"}),
    ({"friction": {"law": "brush", "coefficient": 0.4, "creep_stiffness": 5.0, "slip_speed": 0.05}}, {"brush"}),
    ({"friction.contact_torque": "contensou", "friction.patch_radius": 1e-3}, {"patch_radius"}),
    ({"wheel_types.omni.roller.rolling_resistance": 1e-3, "wheel_types.omni.roller.rolling_rate": 1.0}, {"rolling"}),
    (
        {f"wheel_types.omni.roller.{key}": value for key, value in BEARINGS.items()},
        {"bearing_friction", "bearing_relaxation", "every_rate"},
    ),
    ({"wheels.wheel.drive": MOTOR}, {"motors", "currents", "current_relaxation"}),
    ({"wheels.wheel.drive": SAMPLED}, {"motors", "sampled"}),
    ({"wheels.wheel.drive": FOLLOW, "wheels.wheel.spin_rate": 2.0, "wheels.wheel.spin_angle_deg": 0.0}, {"follows"}),
]


def packed_with(changes):
    return pack(omnisim.load(REFERENCE / "testbench_psi0.toml", changes).config)


@pytest.mark.short
@pytest.mark.parametrize(("changes", "having"), HAVING, ids=lambda part: min(part) if isinstance(part, set) else "")
def test_a_machine_with_any_of_it_has_records_that_may_have_all_of_it(changes, having):
    machine = packed_with(changes).machine
    assert {name for name in SELDOM if machine[name]} == having
    assert type(machine) is Record and not lean(machine.dtype)


@pytest.mark.short
def test_these_are_all_that_few_machines_have_and_one_without_has_plain_records():
    assert set().union(*(having for _, having in HAVING)) == set(SELDOM)
    machine = packed_with({}).machine
    assert type(machine) is LeanRecord and lean(machine.dtype)
    assert not any(machine[name] for name in SELDOM) and machine.dtype.names == MACHINE.names


@pytest.mark.short
def test_records_with_known_zeros_have_the_bytes_of_the_others():
    pair = np.dtype([("number", "f8"), ("three", "f8", 3), ("count", "i8"), ("seed", "u4")], align=True)
    row = {"number": 0.0, "three": [0.1, -0.0, 2.0], "count": 0, "seed": 3}
    known = without(pair, "number", "count")
    assert records(known, [row, row]).tobytes() == records(pair, [row, row]).tobytes()
    assert packer(known).bytes.size == known.itemsize == pair.itemsize and known != pair
    record = single(known, records(known, [row]))
    assert record.tobytes() == records(pair, [row]).tobytes() and (record.number, record.seed) == (0.0, 3)


def moved(scene, kind):
    """The march of a scene whose machine has a record of this kind."""
    parameters = pack(scene.config)
    machine = single(kind, bytearray(parameters.machine.tobytes()))
    marching = Marching(scene.config, start=(parameters._replace(machine=machine), begin(scene.config, parameters)))
    assert marching.march() == status.COMPLETE
    return marching


@pytest.mark.parametrize(
    ("scene", "bound"),
    [
        ("six_rollers", 1e-13),  # measured: 0
        ("coulomb_wheel", 1e-12),  # measured: 1.3e-14
        pytest.param("youbot", 1e-12, marks=pytest.mark.long),  # measured: 3e-15
        pytest.param("kiwi_ramp", 1e-11, marks=pytest.mark.long),  # measured: 2.4e-13
    ],
)
def test_a_plain_machine_moves_as_one_that_might_have_all_of_it(scene, bound):
    scene = omnisim.load(scene, {"time.end": 1.0})
    plain, other = (moved(scene, kind) for kind in (PLAIN, MACHINE))
    size = np.abs(plain.rows.y).max(axis=0)
    differences = np.abs(plain.rows.y - other.rows.y) / np.maximum(size, 1.0)
    assert differences.max() < bound
    logs = [np.asarray(each.log)[: each.run.clock.events] for each in (plain, other)]
    assert np.array_equal(*(np.sort(log[["kind", "wheel"]]) for log in logs))  # those of one instant in either order
