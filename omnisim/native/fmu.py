"""A machine as a Functional Mock-up Unit for Co-Simulation, FMI 3.0 or 2.0: one zip with library and description."""

import io
import json
import platform
import zipfile
from xml.etree.ElementTree import Element, indent, tostring

from omnisim.base.version import VERSION
from omnisim.native.building import Built, NativeError, shared_library
from omnisim.native.model_description import STANDARDS, description
from omnisim.native.variables import inputs_of, outputs_of
from omnisim.scene.scene import Scene

ZIP_TIME = (1980, 1, 1, 0, 0, 0)  # of all files in it: what is the same is the same, whenever it was made


def fmu(scene: Scene, built: Built, standard: str) -> bytes:
    """The file. standard: "3" or "2". Raises NativeError for a processor that FMI 2.0 has no name for."""
    inputs = inputs_of(scene.config, built.machine)
    outputs = outputs_of(scene.config, built.machine, built.memory)
    folder = binaries(standard)
    token = f"omnisim-{VERSION}-{built.identity}"
    counts = {"INPUTS": len(inputs), "OUTPUTS": len(outputs), "PARAMETERS": len(built.parameters)}
    known = counts | {"TOKEN": json.dumps(token)}
    variables = "".join(f"#define {name} {value}\n" for name, value in known.items())
    files = {
        "modelDescription.xml": written(description(standard, scene.config, built, inputs, outputs, token)),
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
    folder = STANDARDS[standard].folders.get(platform.machine())
    if folder is None:
        raise NativeError(f"FMI {standard}.0 has no name for libraries of {platform.machine()}")
    return folder


def written(root: Element) -> bytes:
    indent(root)
    return tostring(root, encoding="utf-8", xml_declaration=True)
