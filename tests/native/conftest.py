"""What tests of Functional Mock-up Units share."""

import pytest

import omnisim
from omnisim.native.building import build
from omnisim.native.fmu import fmu
from omnisim.native.library import prefix_of


@pytest.fixture(scope="session")
def fmu_file(tmp_path_factory):
    """The file of a scene in a standard, made when a test asks for it first."""
    there, built = {}, {}

    def ask(name, standard="3"):
        if (name, standard) not in there:
            scene = omnisim.load(name)
            if name not in built:
                built[name] = build(scene, prefix_of(scene.name), "generic")
            path = tmp_path_factory.getbasetemp() / f"{name}_{standard}.fmu"
            path.write_bytes(fmu(scene, built[name], standard))
            there[name, standard] = path
        return there[name, standard]

    return ask
