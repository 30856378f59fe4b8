"""A machine as a Functional Mock-up Unit for Co-Simulation, FMI 3.0 or 2.0: one zip with library and description."""

import io
import json
import platform
import re
import zipfile
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from omnisim.base.version import VERSION
from omnisim.native.building import Built, NativeError, shared_library
from omnisim.native.parameters import Parameter
from omnisim.native.variables import Input, Output, inputs_of, outputs_of
from omnisim.scene.scene import Scene
from omnisim.scene.schema import Config

STANDARDS = ("3", "2")
MACHINES = {"x86_64": ("x86_64-linux", "linux64"), "aarch64": ("aarch64-linux", "")}  # folders of FMI 3.0 and 2.0
BASE_UNITS = {  # of units that are no base unit of SI themselves, exponents
    "m/s": {"m": 1, "s": -1},
    "rad/s": {"rad": 1, "s": -1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N m": {"kg": 1, "m": 2, "s": -2},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
}
ZIP_TIME = (1980, 1, 1, 0, 0, 0)  # of all files in it: what is the same is the same, whenever it was made


def fmu(scene: Scene, built: Built, standard: str) -> bytes:
    """The file. standard: "3" or "2". Raises NativeError for a processor that FMI 2.0 has no name for."""
    inputs = inputs_of(scene.config, built.machine)
    outputs = outputs_of(scene.config, built.machine, built.memory)
    parameters = built.parameters
    folder = binaries(standard)
    token = f"omnisim-{VERSION}-{built.identity}"
    described = description_3 if standard == "3" else description_2
    known = {"INPUTS": len(inputs), "OUTPUTS": len(outputs), "PARAMETERS": len(parameters), "TOKEN": json.dumps(token)}
    variables = "".join(f"#define {name} {value}\n" for name, value in known.items())
    files = {
        "modelDescription.xml": written(described(scene.config, built.prefix, token, inputs, outputs, parameters)),
        f"binaries/{folder}/{built.prefix}.so": shared_library(built, f"fmi{standard}.c", variables),
        "resources/scene.toml": scene.text.encode(),
    }
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, image in files.items():
            entry = zipfile.ZipInfo(name, ZIP_TIME)
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            archive.writestr(entry, image)
    return content.getvalue()


def binaries(standard: str) -> str:
    """The folder of libraries for this machine. Raises NativeError if the standard has no name for it."""
    names = MACHINES.get(platform.machine())
    folder = names and names[STANDARDS.index(standard)]
    if not folder:
        raise NativeError(f"FMI {standard}.0 has no name for libraries of {platform.machine()}")
    return folder


# --- what the description has -----------------------------------------------------------------------


def description_3(
    config: Config, name: str, token: str, inputs: list[Input], outputs: list[Output], parameters: list[Parameter]
) -> Element:
    """modelDescription.xml of FMI 3.0. Value references are as fmi.h has them."""
    root = Element("fmiModelDescription", about(config, name), fmiVersion="3.0", instantiationToken=token)
    SubElement(root, "CoSimulation", interface(name), canSerializeFMUState="true", canGetAndSetFMUState="true")
    add_units(root, inputs, outputs)
    add_experiment(root, config)
    variables = SubElement(root, "ModelVariables")
    SubElement(variables, "Float64", name="time", valueReference="0", causality="independent", variability="continuous",
               unit="s", description="time")  # fmt: skip
    for reference, given in enumerate(inputs, 1):
        own = SubElement(variables, "Float64", variable(given, reference), causality="input", start=repr(given.start))
        add_unit(own, given)
    structure = SubElement(root, "ModelStructure")
    references = range(1 + len(inputs), 1 + len(inputs) + len(outputs))
    for reference, output in zip(references, outputs, strict=True):
        kind = "Int64" if output.whole else "Float64"
        add_unit(SubElement(variables, kind, variable(output, reference) | causality(output)), output)
        SubElement(structure, "Output", valueReference=str(reference))
    for reference in references:
        SubElement(structure, "InitialUnknown", valueReference=str(reference))
    for reference, parameter in enumerate(parameters, references.stop):
        SubElement(variables, "Float64", fixed(parameter, reference) | bounds(parameter))
    return root


def description_2(
    config: Config, name: str, token: str, inputs: list[Input], outputs: list[Output], parameters: list[Parameter]
) -> Element:
    """The same of FMI 2.0, whose variables count from 1 and whose outputs are told twice."""
    root = Element("fmiModelDescription", about(config, name), fmiVersion="2.0", guid=token)
    SubElement(root, "CoSimulation", interface(name), canSerializeFMUstate="true", canGetAndSetFMUstate="true")
    add_units(root, inputs, outputs)
    add_experiment(root, config)
    variables = SubElement(root, "ModelVariables")
    for reference, one in enumerate(inputs, 1):
        scalar = SubElement(variables, "ScalarVariable", variable(one, reference), causality="input")
        scalar.set("variability", "continuous")
        add_unit(SubElement(scalar, "Real", start=repr(one.start)), one)
    structure = SubElement(root, "ModelStructure")
    lists = SubElement(structure, "Outputs"), SubElement(structure, "InitialUnknowns")
    for reference, output in enumerate(outputs, 1 + len(inputs)):
        scalar = SubElement(variables, "ScalarVariable", variable(output, reference) | causality(output))
        add_unit(SubElement(scalar, "Integer" if output.whole else "Real"), output)
        for listed in lists:
            SubElement(listed, "Unknown", index=str(reference))
    for reference, parameter in enumerate(parameters, 1 + len(inputs) + len(outputs)):
        SubElement(SubElement(variables, "ScalarVariable", fixed(parameter, reference)), "Real", bounds(parameter))
    return root


def about(config: Config, name: str) -> dict[str, str]:
    return {
        "modelName": name,
        "description": plain(config.title),
        "generationTool": f"omnisim {VERSION}",
        "variableNamingConvention": "flat",
    }


def interface(name: str) -> dict[str, str]:
    return {
        "modelIdentifier": name,
        "canHandleVariableCommunicationStepSize": "true",
        "canBeInstantiatedOnlyOncePerProcess": "false",
    }


def add_experiment(root: Element, config: Config) -> None:
    time = config.time
    step = {"startTime": "0.0", "stopTime": repr(time.end), "stepSize": repr(time.output_interval)}
    SubElement(root, "DefaultExperiment", step)


def add_units(root: Element, inputs: list[Input], outputs: list[Output]) -> None:
    units = SubElement(root, "UnitDefinitions")
    found = dict.fromkeys(["s", *(one.unit for one in inputs), *(one.unit for one in outputs)])
    for unit in found:
        if unit != "1":
            powers = BASE_UNITS.get(unit, {unit: 1})
            own = SubElement(units, "Unit", name=unit)
            SubElement(own, "BaseUnit", {base: str(power) for base, power in powers.items()})


def add_unit(element: Element, one: Input | Output) -> None:
    if one.unit != "1" and element.tag not in ("Int64", "Integer"):
        element.set("unit", one.unit)


def variable(one: Input | Output, reference: int) -> dict[str, str]:
    return {"name": one.name, "valueReference": str(reference), "description": one.description}


def causality(output: Output) -> dict[str, str]:
    return {
        "causality": "output",
        "variability": "discrete" if output.whole else "continuous",
        "initial": "calculated",
    }


def fixed(parameter: Parameter, reference: int) -> dict[str, str]:
    described = {"valueReference": str(reference), "description": f"{parameter.name} of the scene"}
    return {"name": parameter.name, "causality": "parameter", "variability": "fixed", "initial": "exact"} | described


def bounds(parameter: Parameter) -> dict[str, str]:
    return {"start": repr(parameter.start), "min": repr(parameter.least), "max": repr(parameter.most)}


def plain(text: str) -> str:
    """A text without what XML has no letters for."""
    return re.sub(r"[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]", " ", text)


def written(root: Element) -> bytes:
    indent(root)
    return tostring(root, encoding="utf-8", xml_declaration=True)
