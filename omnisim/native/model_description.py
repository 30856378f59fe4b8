"""modelDescription.xml: what a Functional Mock-up Unit says of itself, in FMI 3.0 or 2.0."""

import re
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement

from omnisim.base.version import VERSION
from omnisim.native.building import Built
from omnisim.native.parameters import Parameter
from omnisim.native.units import base_units
from omnisim.native.variables import Input, Output
from omnisim.scene.schema import Config


class Standard(NamedTuple):
    """What a standard calls things, and its folders of libraries by processor."""

    token: str
    state: str
    real: str
    whole: str
    folders: dict[str, str]


STANDARDS = {
    "3": Standard(
        "instantiationToken", "FMUState", "Float64", "Int64", {"x86_64": "x86_64-linux", "aarch64": "aarch64-linux"}
    ),
    "2": Standard("guid", "FMUstate", "Real", "Integer", {"x86_64": "linux64"}),
}
ONE = "1"  # unit of a ratio or a number


def description(
    standard: str, config: Config, built: Built, inputs: list[Input], outputs: list[Output], token: str
) -> Element:
    """The root. Value references are as fmi.h has them."""
    words = STANDARDS[standard]
    known = [*map(of_input, inputs), *map(of_output, outputs), *map(of_parameter, built.parameters)]
    timed = [TIME] if standard == "3" else []
    root = Element("fmiModelDescription", about(config, built.prefix), fmiVersion=f"{standard}.0")
    root.set(words.token, token)
    SubElement(root, "CoSimulation", interface(built.prefix, words.state))
    add_units(root, {one.typed["unit"] for one in (*timed, *known) if "unit" in one.typed})
    add_experiment(root, config)
    variables = SubElement(root, "ModelVariables")
    for reference, (whole, told, typed) in enumerate([*timed, *known], 1 - len(timed)):
        kind, told = words.whole if whole else words.real, told | {"valueReference": str(reference)}
        if standard == "3":
            SubElement(variables, kind, told | typed)
        else:
            SubElement(SubElement(variables, "ScalarVariable", told), kind, typed)
    add_structure(root, standard, range(1 + len(inputs), 1 + len(inputs) + len(outputs)))
    return root


def about(config: Config, name: str) -> dict[str, str]:
    return {
        "modelName": name,
        "description": plain(config.title),
        "generationTool": f"omnisim {VERSION}",
        "variableNamingConvention": "flat",
    }


def interface(name: str, state: str) -> dict[str, str]:
    return {
        "modelIdentifier": name,
        "canHandleVariableCommunicationStepSize": "true",
        "canBeInstantiatedOnlyOncePerProcess": "false",
        f"canGetAndSet{state}": "true",
        f"canSerialize{state}": "true",
    }


def add_experiment(root: Element, config: Config) -> None:
    time = config.time
    step = {"startTime": "0.0", "stopTime": repr(time.end), "stepSize": repr(time.output_interval)}
    SubElement(root, "DefaultExperiment", step)


def add_units(root: Element, units: set[str]) -> None:
    there = SubElement(root, "UnitDefinitions")
    for unit in sorted(units):
        SubElement(SubElement(there, "Unit", name=unit), "BaseUnit", base_units(unit))


def add_structure(root: Element, standard: str, outputs: range) -> None:
    """Outputs, all of which are computed at the start."""
    structure = SubElement(root, "ModelStructure")
    for name in ("Output", "InitialUnknown"):
        listed = structure if standard == "3" else SubElement(structure, f"{name}s")
        for reference in outputs:
            if standard == "3":
                SubElement(listed, name, valueReference=str(reference))
            else:
                SubElement(listed, "Unknown", index=str(reference))


# --- variables: whether it is a whole number, what it is, and what goes with its type -----------------


class Told(NamedTuple):
    whole: bool
    told: dict[str, str]
    typed: dict[str, str]


TIME = Told(
    False,
    {"name": "time", "description": "time", "causality": "independent", "variability": "continuous"},
    {"unit": "s"},
)


def of_input(one: Input) -> Told:
    told = named(one) | {"causality": "input", "variability": "continuous"}
    return Told(False, told, unit(one) | {"start": repr(one.start)})


def of_output(one: Output) -> Told:
    told = {"causality": "output", "variability": "discrete" if one.whole else "continuous", "initial": "calculated"}
    return Told(one.whole, named(one) | told, {} if one.whole else unit(one))


def of_parameter(one: Parameter) -> Told:
    told = {"causality": "parameter", "variability": "fixed", "initial": "exact"}
    bounds = {"start": repr(one.start), "min": repr(one.least), "max": repr(one.most)}
    return Told(False, named(one) | told, unit(one) | bounds)


def named(one: Input | Output | Parameter) -> dict[str, str]:
    return {"name": one.name, "description": one.description}


def unit(one: Input | Output | Parameter) -> dict[str, str]:
    return {} if one.unit == ONE else {"unit": one.unit}


def plain(text: str) -> str:
    """A text without what XML has no letters for."""
    return re.sub(r"[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]", " ", text)
