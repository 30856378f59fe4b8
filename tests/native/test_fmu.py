"""Machines as Functional Mock-up Units: inputs, parameters and states act, and no caller brings them down."""

import numpy as np
import pytest
from commands import command
from memory import resident

import omnisim

fmpy, fmi2, fmi3 = (
    pytest.importorskip(f"fmpy{part}", reason="needs fmpy: pip install -e '.[test]'") for part in ("", ".fmi2", ".fmi3")
)
pytestmark = pytest.mark.long
DISCARD, ERROR = 2, 3


class Unit:
    """An instance of a file, as an importer has it."""

    def __init__(self, path, folder, token=None):
        told = fmpy.read_model_description(str(path))
        standard = told.fmiVersion[0]
        self.references = {variable.name: variable.valueReference for variable in told.modelVariables}
        self.said = []
        unzipped = folder / path.stem
        if not unzipped.exists():
            fmpy.extract(str(path), str(unzipped))
        given = {
            "guid": token or told.guid,
            "unzipDirectory": str(unzipped),
            "modelIdentifier": told.coSimulation.modelIdentifier,
            "instanceName": "one",
        }
        if standard == "3":
            self.unit = fmi3.FMU3Slave(**given)
            self.unit.instantiate(logMessage=lambda _, status, category, text: self.said.append(text.decode()))
            self.get_float, self.set_float = self.unit.getFloat64, self.unit.setFloat64
            self.unit.enterInitializationMode(startTime=0.0)
        else:
            self.unit = fmi2.FMU2Slave(**given)
            self.unit.instantiate()
            self.get_float, self.set_float = self.unit.getReal, self.unit.setReal
            self.unit.setupExperiment(startTime=0.0)
            self.unit.enterInitializationMode()
        self.time = 0.0

    def start(self):
        self.unit.exitInitializationMode()
        return self

    def give(self, name, value):
        self.set_float([self.references[name]], [value])

    def step(self, seconds):
        self.unit.doStep(self.time, seconds)
        self.time += seconds

    def row(self, *names):
        return self.get_float([self.references[name] for name in names])


SEEN = "body/position.x", "body/yaw", "wheels/front_left/spin_rate", "wheels/front_left/normal_force"


def rows(unit, count):
    found = []
    for _ in range(count):
        unit.step(0.01)
        found.append(unit.row(*SEEN))
    return np.array(found)


@pytest.mark.parametrize("standard", ["3", "2"])
def test_inputs_act_as_those_of_a_loop_and_start_values_leave_the_command(fmu_file, tmp_path, standard):
    unit, loop = Unit(fmu_file("youbot", standard), tmp_path), omnisim.Loop("youbot")
    unit.give("wheels/front_left/rate", 0.0)  # its start value, which importers may set
    unit.start()
    for i in range(100):
        if i == 60:
            unit.give("wheels/front_left/rate", 0.0)
            loop.drive("front_left", 0.0)
        if i == 80:
            unit.give("wrench/force.y", 5.0)
            loop.wrench((0.0, 5.0, 0.0))
        unit.step(0.01)
        loop.advance(0.01)
        expected = loop.position[0], loop.yaw, loop.spin_rates[0], loop.normal_forces[0]
        assert unit.row(*SEEN) == pytest.approx(expected, rel=1e-11, abs=1e-11)


@pytest.mark.parametrize("standard", ["3", "2"])
def test_a_state_taken_back_repeats_the_run_bit_for_bit_in_this_instance_and_another(fmu_file, tmp_path, standard):
    one, other = (Unit(fmu_file("youbot", standard), tmp_path).start() for _ in range(2))
    named = "State" if standard == "3" else "state"
    get, put, free, pack = (getattr(one.unit, f"{what}FMU{named}") for what in ("get", "set", "free", "serialize"))
    back = getattr(other.unit, f"{'deserialize' if standard == '3' else 'deSerialize'}FMU{named}")
    one.give("wheels/rear_left/rate", 2.0)
    rows(one, 37)
    state, time = get(), one.time
    kept = pack(state)
    once = rows(one, 40)
    put(state)
    one.time = time
    assert np.array_equal(rows(one, 40), once)
    free(state)
    getattr(other.unit, f"setFMU{named}")(back(kept))
    other.time = time
    assert np.array_equal(rows(other, 40), once)


@pytest.mark.parametrize("standard", ["3", "2"])
def test_parameters_set_before_initialization_ends_are_those_of_the_scene(fmu_file, tmp_path, standard):
    unit = Unit(fmu_file("youbot", standard), tmp_path)
    unit.give("wheels/front_left/rate", 2.0)
    unit.give("friction.coefficient", 0.35)
    unit.start()
    loop = omnisim.Loop(omnisim.load("youbot", ["friction.coefficient=0.35"]))
    loop.drive("front_left", 2.0)
    found = rows(unit, 50)
    loop.advance(0.5)
    expected = loop.position[0], loop.yaw, loop.spin_rates[0], loop.normal_forces[0]
    assert found[-1] == pytest.approx(expected, rel=1e-11, abs=1e-11)
    assert unit.row("friction.coefficient") == [0.35]
    with pytest.raises(fmpy.fmi1.FMICallException) as failure:
        unit.give("friction.coefficient", 0.5)
    assert failure.value.status == DISCARD
    other = Unit(fmu_file("youbot", standard), tmp_path)
    with pytest.raises(fmpy.fmi1.FMICallException):
        other.give("friction.coefficient", -1.0)
    if standard == "3":
        assert unit.said[-1] == "friction.coefficient is fixed after initialization"
        assert other.said[-1] == "friction.coefficient must be within 0.15 and 2.4, not -1"
    assert other.row("friction.coefficient") == [0.6]


def test_instances_side_by_side_do_not_see_each_other(fmu_file, tmp_path):
    alone = rows(Unit(fmu_file("youbot"), tmp_path).start(), 30)
    pair = [Unit(fmu_file("youbot"), tmp_path).start() for _ in range(2)]
    pair[1].give("wrench/force.x", 3.0)
    found = np.array([[rows(unit, 1)[0] for unit in pair] for _ in range(30)])
    assert np.array_equal(found[:, 0], alone) and not np.array_equal(found[-1, 1], alone[-1])


def test_what_cannot_be_meant_is_discarded_and_told(fmu_file, tmp_path):
    unit = Unit(fmu_file("youbot"), tmp_path).start()
    for seconds in (1.2e-4, -0.01, float("nan")):
        with pytest.raises(fmpy.fmi1.FMICallException) as failure:
            unit.step(seconds)
        assert failure.value.status == DISCARD and "is no multiple of the scene's time.step, 0.0005 s" in unit.said[-1]
    unit.time = 0.0
    with pytest.raises(fmpy.fmi1.FMICallException):
        unit.give("wheels/front_left/rate", float("nan"))
    assert unit.said[-1] == "wheels/front_left/rate must be a finite number, not nan"
    with pytest.raises(fmpy.fmi1.FMICallException):
        unit.unit.getBoolean([1])
    assert unit.said[-1] == "a machine for Co-Simulation has no fmi3GetBoolean"
    with pytest.raises(fmpy.fmi1.FMICallException):
        unit.get_float([10_000])
    assert unit.said[-1] == "there is no variable with value reference 10000"
    unit.step(0.01)
    with pytest.raises(Exception, match=r"[Ii]nstantiate"):
        Unit(fmu_file("youbot"), tmp_path, token="another")


@pytest.mark.parametrize("standard", ["3", "2"])
def test_a_machine_that_is_stopped_says_so_and_takes_nobody_with_it(fmu_file, tmp_path, standard):
    unit, loop = Unit(fmu_file("youbot", standard), tmp_path).start(), omnisim.Loop("youbot")
    unit.step(0.01)
    loop.advance(0.01)
    unit.give("wrench/force.z", 1000.0)
    loop.wrench((0.0, 0.0, 1000.0))
    loop.advance(0.01)
    for _ in range(2):
        with pytest.raises(fmpy.fmi1.FMICallException) as failure:
            unit.step(0.01)
        assert failure.value.status == (ERROR if standard == "3" else DISCARD)
    if standard == "3":
        assert unit.said[-1] == loop.status and "leaves the floor" in loop.status
    else:
        assert unit.unit.getBooleanStatus(3) and unit.unit.getRealStatus(2) == pytest.approx(0.01)
    assert np.all(np.isfinite(unit.row(*SEEN)))
    unit.unit.reset()


def test_the_command_writes_a_file_that_is_the_same_every_time(folder):
    for name in ("one", "two"):
        result = command("fmu", "coulomb_wheel", "-o", f"{name}.fmu", "--fmi", "2")
        assert result.exit_code == 0, result.output
    assert (folder / "one.fmu").read_bytes() == (folder / "two.fmu").read_bytes()
    assert fmpy.read_model_description("one.fmu").fmiVersion == "2.0"


@pytest.mark.parametrize("standard", ["3", "2"])
def test_ten_million_steps_and_a_thousand_instances_take_no_more_memory(fmu_file, tmp_path, standard):
    path = fmu_file("coulomb_wheel", standard)
    unit = Unit(path, tmp_path).start()
    unit.step(100.0)
    opened(path, tmp_path, 1000)  # after the first few hundred Python takes 3 MB, once
    before = resident()
    for _ in range(100):
        unit.give("wrench/yaw_torque", 1e-9)
        unit.step(100.0)
    assert unit.time == 10_100.0 and np.isfinite(unit.row("body/yaw")).all()
    opened(path, tmp_path, 1000)
    assert resident() - before < 2.0  # MB, measured 0.0


def opened(path, folder, count):
    """So many instances, one after the other, each with a step."""
    for _ in range(count):
        unit = Unit(path, folder).start()
        unit.step(0.01)
        unit.unit.terminate()
        unit.unit.freeInstance()
