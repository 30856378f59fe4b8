"""A library that omnisim made of a scene, called as C calls it."""

import ctypes
from ctypes import POINTER, c_char_p, c_double, c_int, c_size_t, c_void_p

import numpy as np

from omnisim.native.library import files, prefix_of

RUNNING, STOPPED, REFUSED = range(3)
SIGNATURES = {
    "open": (c_void_p,),
    "close": (None, c_void_p),
    "reset": (c_int, c_void_p),
    "step": (c_int, c_void_p, c_double),
    "grid": (c_double,),
    "time": (c_double, c_void_p),
    "find_input": (c_int, c_char_p),
    "find_output": (c_int, c_char_p),
    "find_parameter": (c_int, c_char_p),
    "set_parameter": (c_int, c_void_p, c_int, c_double),
    "get_parameter": (c_double, c_void_p, c_int),
    "set": (c_int, c_void_p, c_int, c_double),
    "command": (c_int, c_void_p, c_double, c_double, c_double),
    "get": (c_double, c_void_p, c_int),
    "state_size": (c_size_t,),
    "save": (None, c_void_p, c_void_p),
    "restore": (c_int, c_void_p, c_void_p),
    "message": (c_char_p, c_void_p),
}


class Variable(ctypes.Structure):
    _fields_ = (
        ("name", c_char_p),
        ("unit", c_char_p),
        ("description", c_char_p),
        ("start", c_double),
        ("whole", c_int),
    )


def make(scene, folder, cpu="generic"):
    """The folder with the library of a scene, and what its names begin with."""
    prefix = prefix_of(scene.name)
    folder.mkdir()
    for name, image in files(scene, prefix, cpu).items():
        (folder / name).write_bytes(image)
    return folder, prefix


class Library:
    def __init__(self, folder, prefix):
        loaded = ctypes.CDLL(str(folder / f"lib{prefix}.so"))
        for name, (returned, *taken) in SIGNATURES.items():
            function = getattr(loaded, f"{prefix}_{name}")
            function.restype, function.argtypes = returned, taken
            setattr(self, name, function)
        self.inputs, self.outputs = (self._variables(loaded, f"{prefix}_{kind}") for kind in ("input", "output"))
        self.names = [variable.name.decode() for variable in self.outputs]

    def _variables(self, loaded, name):
        function = getattr(loaded, name)
        function.restype, function.argtypes = POINTER(Variable), [c_int]
        found = []
        while variable := function(len(found)):
            found.append(variable.contents)
        return found


class Machine:
    """One that is open, as long as this object lives."""

    def __init__(self, library):
        self.library, self.handle = library, library.open()

    def __getattr__(self, name):
        function = getattr(self.library, name)
        return lambda *arguments: function(self.handle, *arguments)

    def __del__(self):
        self.library.close(self.handle)

    @property
    def said(self):
        return self.message().decode()

    def give(self, name, value):
        return self.set(self.library.find_input(name.encode()), value)

    def row(self):
        """All outputs."""
        return np.array([self.get(i) for i in range(len(self.library.names))])

    def rows(self, seconds, count):
        """All outputs as they are, and after each of so many steps that the machine survives."""
        found = [self.row()]
        for _ in range(count):
            if self.step(seconds) != RUNNING:
                break
            found.append(self.row())
        return np.array(found)

    def state(self):
        kept = ctypes.create_string_buffer(self.library.state_size())
        self.save(kept)
        return kept


def columns(trajectory, names):
    """The same outputs of a trajectory, a column for each; of events how many there were up to each row."""
    found = []
    for name in names:
        path, _, label = name.partition(".")
        if path.startswith("events/"):
            times = trajectory["events/time"][trajectory["events/kind"] == path.removeprefix("events/")]
            found.append(np.searchsorted(times, trajectory.time + 1e-12, side="right"))
            continue
        data = trajectory[path]
        if label:
            axis = next(q.axes[1] for q in trajectory.quantities if q.path == path)
            data = data[:, list(trajectory[axis]).index(label)]
        found.append(data)
    return np.array(found, float).T
