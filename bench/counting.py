"""Operations of omnisim's own kernels, run as plain Python on numbers that count what is done to them.

NUMBA_DISABLE_JIT=1 python -m bench.counting                    JSON: by scene, of one right-hand side and one step

What constants alone give is not counted, as in the C loops: they stay ordinary numbers.
"""

import json
import math
import sys
from collections.abc import Callable
from types import SimpleNamespace

import numpy as np

from bench.common import ready
from bench.limit import OPERATIONS
from bench.peers.c_loop import LOOPS
from omnisim.dynamics.right_hand_side import rhs
from omnisim.dynamics.state import Stage
from omnisim.march.runge_kutta import accept, explicit_step
from omnisim.scene.scene import Scene

COUNTS = dict.fromkeys(OPERATIONS, 0.0)


class Counted:
    """A number that counts operations on itself in COUNTS; sine and cosine make one between them."""

    def __init__(self, value: float):
        self.value = value

    def __neg__(self):
        return Counted(-self.value)

    def __abs__(self):
        return Counted(abs(self.value))

    def __float__(self):
        return self.value

    def __lt__(self, other):
        return float(self) < float(other)

    def __gt__(self, other):
        return float(self) > float(other)


def operator(kind: str, function: Callable[..., float], amount: float = 1.0) -> Callable[..., object]:
    def count(*numbers):
        result = function(*map(float, numbers))
        if not any(isinstance(number, Counted) for number in numbers):
            return result
        COUNTS[kind] += amount
        return Counted(result)

    return count


for name, kind, function in (
    ("add", "addition", lambda a, b: a + b),
    ("sub", "addition", lambda a, b: a - b),
    ("mul", "multiplication", lambda a, b: a * b),
    ("truediv", "division", lambda a, b: a / b),
):
    setattr(Counted, f"__{name}__", operator(kind, function))
    setattr(Counted, f"__r{name}__", operator(kind, lambda a, b, function=function: function(b, a)))


def count_in_kernels() -> None:
    """Let the modules of omnisim use counting roots, sines and cosines."""
    counting = {
        "sqrt": operator("root", math.sqrt),
        "cos": operator("sine and cosine", math.cos, 0.5),
        "sin": operator("sine and cosine", math.sin, 0.5),
    }
    for name, module in sys.modules.items():
        if name.startswith("omnisim.") and getattr(module, "math", None) is math:
            module.math = SimpleNamespace(**vars(math) | counting)
        if name.startswith("omnisim.") and hasattr(module, "cos_sin"):
            module.cos_sin = lambda x: (counting["cos"](x), counting["sin"](x))


def opened(record: np.void, wrap: Callable[[float], object]) -> SimpleNamespace:
    """A record with fields of any type: its floats wrapped, arrays as arrays of objects."""
    fields = {}
    for name in record.dtype.names:
        value = record[name]
        if isinstance(value, np.void):
            fields[name] = opened(value, wrap)
        elif np.issubdtype(value.dtype, np.floating):
            fields[name] = np.vectorize(wrap, otypes=[object])(value) if value.ndim else wrap(float(value))
        else:
            fields[name] = value if value.ndim else int(value)
    return SimpleNamespace(**fields)


def counted_array(values: np.ndarray) -> np.ndarray:
    return np.vectorize(Counted, otypes=[object])(values)


def counts_of(scene: Scene) -> dict[str, list[float]]:
    """Operations of one right-hand side, and of one step without an exchange, by OPERATIONS."""
    march = ready(scene)
    march.run.clock.steps = march.run.clock.goal = 10
    march.go()
    parameters, run = march.parameters, march.run
    workspace = parameters.workspace._replace(
        contacts=[opened(one, Counted) for one in parameters.workspace.contacts],
        parts=[opened(one, Counted) for one in parameters.workspace.parts],
        loads=opened(parameters.workspace.loads, Counted),
    )
    wheels = [opened(wheel, float) for wheel in parameters.wheels]
    parameters = parameters._replace(machine=opened(parameters.machine, float), wheels=wheels, workspace=workspace)
    arrays = ("y", "trial", "carry", "increment", "slopes")
    records = ("mode", "monitors", "monitors_end")
    run = run._replace(
        **{name: counted_array(getattr(run, name)) for name in arrays},
        **{name: [opened(one, Counted) for one in getattr(run, name)] for name in records},
    )
    t, dt = float(run.clock.step * run.clock.dt), float(run.clock.dt)
    taken()
    rhs(parameters, Stage(run.mode, 0, t, run.y, run.slopes[0], run.monitors, True))
    of_rhs = taken()
    explicit_step(parameters, march.stages, run, t, dt)
    accept(run)
    return {"rhs": of_rhs, "step": taken()}


def taken() -> list[float]:
    """COUNTS since the last time."""
    numbers = list(COUNTS.values())
    COUNTS.update(dict.fromkeys(OPERATIONS, 0.0))
    return numbers


if __name__ == "__main__":
    count_in_kernels()
    print(json.dumps({name: counts_of(loop.scene()) for name, loop in LOOPS.items()}))
