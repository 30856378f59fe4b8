"""Machines as Functional Mock-up Units in other people's tools, which read, check and step them."""

import json
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from native_machine import columns

import omnisim

fmpy, validation = (
    pytest.importorskip(f"fmpy{part}", reason="needs fmpy: pip install -e '.[test]'") for part in ("", ".validation")
)
pytestmark = pytest.mark.long
SEEN = "body/position.x", "body/yaw", "wheels/front_left/spin_rate", "wheels/front_left/normal_force"
# Simulates a file with FMPy where importing omnisim or Numba is an error, and writes all outputs at every 10 ms.
ALONE = """
import json, sys
sys.modules.update(dict.fromkeys(["omnisim", "numba", "llvmlite"]))
import fmpy
found = fmpy.simulate_fmu(sys.argv[1], output_interval=float(sys.argv[2]))
json.dump({"names": found.dtype.names, "rows": found.tolist()}, sys.stdout)
"""


@pytest.mark.parametrize("standard", ["3", "2"])
@pytest.mark.parametrize("name", ["coulomb_wheel", "kiwi", "youbot"])
def test_fmpy_finds_nothing_and_moves_a_machine_as_omnisim_run_does(fmu_file, name, standard):
    path = fmu_file(name, standard)
    assert validation.validate_fmu(str(path)) == []
    trajectory = omnisim.simulate(name)
    program = [sys.executable, "-c", ALONE, str(path), str(trajectory.time[1])]
    found = json.loads(subprocess.run(program, capture_output=True, text=True, check=True).stdout)
    names, values = found["names"], np.array(found["rows"])
    expected = columns(trajectory, names)
    assert values.shape == expected.shape and names[0] == "time" and len(names) > 25
    error = np.abs(values - expected) / np.maximum(np.abs(expected).max(axis=0), 1.0)
    assert error.max() < 1e-12, names[np.argmax(error.max(axis=0))]  # measured 2e-14


def test_libcosim_steps_it(fmu_file):
    pytest.importorskip("libcosimpy", reason="needs libcosimpy: pip install -e '.[test]'")
    program = """
import sys
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave
execution = CosimExecution.from_step_size(step_size=10_000_000)
slave = execution.add_local_slave(CosimLocalSlave(fmu_path=sys.argv[1], instance_name="one"))
observer = CosimObserver.create_last_value()
execution.add_observer(observer)
there = {variable.name.decode(): variable.reference for variable in execution.slave_variables(slave)}
execution.step(300)
print("found", *observer.last_real_values(slave, [there["body/position.x"], there["wheels/front_left/spin_rate"]]))
"""
    said = subprocess.run(
        [sys.executable, "-c", program, str(fmu_file("youbot", "2"))], capture_output=True, text=True, check=True
    ).stdout
    trajectory = omnisim.simulate("youbot")
    expected = trajectory["body/position"][-1, 0], trajectory["wheels/front_left/spin_rate"][-1]
    found = [float(text) for text in re.search("^found (.*)", said, re.MULTILINE)[1].split()]
    assert found == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("standard", ["3", "2"])
def test_every_function_of_the_standard_is_there(fmu_file, standard, tmp_path):
    header = Path(fmpy.__file__).parent / f"c-code/fmi{standard}Functions.h"
    exchange = r"Functions for FMI2 for Model Exchange.*?Functions for FMI2 for Co-Simulation"
    declared = re.sub(exchange, "", header.read_text(), flags=re.DOTALL)
    wanted = set(re.findall(rf"TYPE\s+(fmi{standard}\w+);", declared))
    with zipfile.ZipFile(fmu_file("youbot", standard)) as archive:
        library = next(name for name in archive.namelist() if name.endswith(".so"))
        archive.extract(library, tmp_path)
    shown = subprocess.run(
        ["nm", "-D", "--defined-only", tmp_path / library], capture_output=True, text=True, check=True
    )
    assert len(wanted) > 20 and {line.split()[-1] for line in shown.stdout.splitlines()} == wanted


def toolbox(part):
    return pytest.importorskip(
        f"fmu_manipulation_toolbox.{part}", reason="needs fmu-manipulation-toolbox: pip install -e '.[test]'"
    )


@pytest.mark.parametrize("name", ["coulomb_wheel", "youbot"])
@pytest.mark.parametrize("standard", ["3", "2"])
def test_a_checker_of_the_rules_of_the_standard_finds_nothing(fmu_file, name, standard):
    """The schema, and what it cannot say: kinds of variables, start values, lists of outputs."""
    checker = toolbox("checker")
    schema, rules = checker.OperationGenericCheck(), checker.OperationSemanticCheck()
    with toolbox("operations").FMU(str(fmu_file(name, standard))) as unit:
        unit.apply_operation(schema)
        unit.apply_operation(rules)
    assert schema.compliant_with_version == f"{standard}.0" and rules.errors == []


def test_a_container_in_c_steps_units_of_both_standards_side_by_side(fmu_file, tmp_path):
    """The container is an importer of its own, and a unit that FMPy steps."""
    for standard in "32":
        (tmp_path / f"{standard}.fmu").write_bytes(fmu_file("youbot", standard).read_bytes())
    container = toolbox("container").FMUContainer("both", tmp_path)
    container.get_fmu("3.fmu")
    container.get_fmu("2.fmu")
    for standard in "32":
        for name in SEEN:
            container.add_output(f"{standard}.fmu", name, f"{standard}/{name}")
    container.make_fmu("both.fmu", step_size=0.01)
    found = fmpy.simulate_fmu(str(tmp_path / "both.fmu"), output_interval=0.01)
    expected = columns(omnisim.simulate("youbot"), SEEN)
    for standard in "32":
        values = np.array([found[f"{standard}/{name}"] for name in SEEN]).T
        assert np.abs(values - expected).max() < 1e-11  # of 60 N


@pytest.mark.parametrize("standard", ["3", "2"])
@pytest.mark.parametrize("name", ["coulomb_wheel", "youbot"])
def test_every_variable_has_a_unit_that_the_file_defines_or_is_a_ratio(fmu_file, name, standard):
    told = fmpy.read_model_description(str(fmu_file(name, standard)), validate=True)
    defined = {unit.name for unit in told.unitDefinitions}
    without = {one.name.rpartition("/")[2].rpartition(".")[2] for one in told.modelVariables if one.unit is None}
    assert {one.unit for one in told.modelVariables if one.unit} == defined
    whole = {one.name.rpartition("/")[2] for one in told.modelVariables if one.type in ("Int64", "Integer")}
    assert without - whole == {"contact_share", "coefficient"}
    units = {one.name: one.unit for one in told.modelVariables if one.causality == "parameter"}
    if name == "youbot":
        assert units["wheels.front_left.drive.proportional"] == "N m s/rad"
        assert units["wheels.front_left.drive.torque_limit"] == "N m"
