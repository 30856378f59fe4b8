"""A machine as a library of C: a folder with all that a C++ project needs of it."""

import re

from omnisim.native.building import build, shared_library, source
from omnisim.scene.scene import Scene

COPIED = "example.cpp", "CMakeLists.txt"


def prefix_of(name: str) -> str:
    """What the public names of the library of a scene of this name begin with: the same as a name of C."""
    found = re.sub(r"\W", "_", name, flags=re.ASCII)
    return found if found[:1].isalpha() else f"machine_{found}"


def file_names(prefix: str) -> tuple[str, ...]:
    return f"lib{prefix}.so", f"{prefix}.h", *COPIED, "scene.toml"


def files(scene: Scene, prefix: str, cpu: str) -> dict[str, bytes]:
    """The files of the folder by name: the library, its header, an example for CMake, and the scene.

    Raises SceneError and NativeError as `build` does.
    """
    title = scene.config.title.replace("*/", "* /").replace("\n", " ")
    header = source("machine.h", prefix).replace("@TITLE@", title)
    texts = [header, *(source(name, prefix) for name in COPIED), scene.text]
    images = [shared_library(build(scene, prefix, cpu)), *(text.encode() for text in texts)]
    return dict(zip(file_names(prefix), images, strict=True))
