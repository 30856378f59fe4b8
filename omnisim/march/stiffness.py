"""How stiff a scene is, and what method "auto" makes of it."""

import math

from omnisim.base.methods import AUTO, EXPLICIT, IMPLICIT, METHODS
from omnisim.base.status import SAFE_STEP
from omnisim.contact.frame import Slip
from omnisim.contact.friction import friction_factor
from omnisim.contact.rolling_resistance import rolling_relaxation
from omnisim.dynamics.parameters import Parameters
from omnisim.dynamics.spatial.swings import fastest_swing
from omnisim.dynamics.static_loads import static_loads
from omnisim.march.validity import roller_mobility
from omnisim.scene.schema import Config

SAFE = 0.5  # of the stability limit of the explicit tableau, up to which "auto" is explicit throughout


def relaxation_rate(config: Config, parameters: Parameters) -> float:
    """Largest rate at which friction relaxes slip, or rolling resistance stops a roller, anywhere in the scene, 1/s;
    infinite for coulomb."""
    return max(slip_rate(config, parameters), rolling_rate(config, parameters))


def slip_rate(config: Config, parameters: Parameters) -> float:
    """The same of slip."""
    machine = parameters.machine
    normal = heaviest_load(config, parameters)
    if config.friction.law == "coulomb":
        return math.inf if machine.friction * normal > 0.0 else 0.0
    mobility = max(roller_mobility(machine, wheel, parameters.roller_rows) for wheel in parameters.wheels)
    still = Slip(machine.slip_layer, 0.0)  # set-valued friction is as steep at the edge of the layer as within
    return friction_factor(machine, 0, normal, still, still) * mobility


def rolling_rate(config: Config, parameters: Parameters) -> float:
    """The same of rolling resistance."""
    rolling = max(rolling_relaxation(wheel, 0.0, 0.0) for wheel in parameters.wheels)
    return heaviest_load(config, parameters) * rolling


def heaviest_load(config: Config, parameters: Parameters) -> float:
    """Largest normal force on any wheel at standstill, N."""
    lowest = min(force[2] for force in config.wrench.table[1])
    return float(static_loads(parameters, lowest, math.radians(config.initial.yaw_deg)).max())


def resolve(config: Config, parameters: Parameters) -> int:
    """Which steps are explicit: as the method says, and for "auto" all of them if no step can be too stiff."""
    method = METHODS[config.solver.method]
    if method.choice == AUTO:
        limit = SAFE * method.tableau.stability_limit
        machine = parameters.machine
        relaxed = machine.slip_layer > 0.0
        rubbing = (rolling_rate if relaxed else relaxation_rate)(config, parameters)
        fastest = max(rubbing, machine.bearing_relaxation, machine.current_relaxation)
        if fastest * config.time.step <= limit:
            return EXPLICIT
    return method.choice


def method_used(name: str, choice: int) -> str:
    """Name of a method, for "auto" of what it has become by the resolved `choice`."""
    method = METHODS[name]
    if method.choice != AUTO:
        return name
    return method.tableau.name if choice == EXPLICIT else f"{method.tableau.name} + radau5"


def explanation(config: Config, parameters: Parameters) -> str:
    """What steps are taken and why, for people: for friction, for what settles the currents of motors, for rubber."""
    return _of_friction(config, parameters) + _of_currents(config, parameters) + _of_rubber(config, parameters)


def _of_currents(config: Config, parameters: Parameters) -> str:
    """How fast currents with an inductance settle, and whether explicit steps can follow; empty if there are none."""
    rate = parameters.machine.current_relaxation
    if rate == 0.0:
        return ""
    told = f"; currents of motors settle at up to {rate:.2g} 1/s"
    return told + _too_fast(config, rate, resolve(config, parameters) == EXPLICIT, "auto")


def _of_rubber(config: Config, parameters: Parameters) -> str:
    """The same of a machine free in space on its rubber and springs: "auto" does not look at them."""
    if parameters.space is None:
        return ""
    rate = fastest_swing(parameters)
    explicit = METHODS[config.solver.method].choice != IMPLICIT
    return f"; it swings on its rubber at up to {rate:.2g} 1/s" + _too_fast(config, rate, explicit, "radau5")


def _too_fast(config: Config, rate: float, explicit: bool, instead: str) -> str:
    """What to do about a rate (1/s) that explicit steps cannot follow; empty if they can, or if there are none."""
    limit = METHODS[config.solver.method].tableau.stability_limit
    if not explicit or rate * (config.time.step or 0.0) <= limit:
        return ""
    return f", too fast for this step: time.step < {SAFE_STEP * limit / rate:.2g} s or method = '{instead}' would do"


def _of_friction(config: Config, parameters: Parameters) -> str:
    """The same for friction, of the floor and of bearings."""
    method = METHODS[config.solver.method]
    step = config.time.step
    rate = relaxation_rate(config, parameters)
    assert step is not None, "of a scene whose step is picked there is nothing to say yet"
    choice = resolve(config, parameters)
    limit = method.tableau.stability_limit / step
    used = method_used(method.name, choice)
    bearings = parameters.machine.bearing_relaxation
    if max(rate, bearings) == 0.0:
        return used
    slip = f"friction relaxes slip at up to {rate:.2g} 1/s"
    if bearings > rate:
        slip = f"bearings stop rollers at up to {bearings:.2g} 1/s"
        rate = bearings
    elif config.friction.law == "coulomb":
        slip = "coulomb friction turns slow slip at mu N A / |v|"
    if parameters.machine.slip_layer > 0.0:
        return f"{used}: {slip} within slip_speed, at once for this step"
    if method.name == "radau5":
        return f"{used}: every step implicit; {slip}"
    name = method.tableau.name
    if choice == AUTO:
        return f"{used}: {slip}; {name} follows {limit:.2g} 1/s with this step, steps beyond are implicit"
    if method.choice == AUTO or rate <= limit:
        return f"{used}: {slip}, and {name} follows {limit:.2g} 1/s with this step"
    if config.friction.law == "coulomb":
        return f"{used}: {slip}, and steps are parted to follow; 'auto' takes slow slip in implicit steps"
    return (
        f"{used}: {slip}, but {name} follows {limit:.2g} 1/s with this step, and the run stops where it must: "
        f"time.step < {SAFE_STEP * method.tableau.stability_limit / rate:.2g} s or method = 'auto' would do"
    )
