"""The mecanum machine of bump_scene.py over bumps in MuJoCo, as mujoco_ground.py builds it, at its best beside omnisim.

What helps is searched in turn: kinds of rollers, contacts and spacings of the heights; then the step of the best of
each kind; then integrators, friction and other spacings for the best of all.
"""

from collections.abc import Callable
from typing import NamedTuple

from bench import bump_scene
from bench.bump_scene import COLUMNS, NOTES, attempt, cells
from bench.common import Claim, table
from bench.peers import wheel_scene
from bench.peers.mujoco_ground import RUBBER, SHAPES, Running, Setup, creep
from bench.peers.mujoco_peer import MISSING, mujoco
from bench.peers.wheel_scene import LEVEL


class Plan(NamedTuple):
    """Which rollers x contacts x spacings are surveyed, and by which steps the best of each kind of rollers go on."""

    rollers: tuple[str, ...]
    contacts: tuple[str, ...]
    spacings: tuple[float, ...]
    steps: tuple[float, ...]


SURVEY = "implicitfast", 2e-4  # integrator and step, s, of the survey
HARD = "2 steps, hard"
FULL = Plan(tuple(SHAPES), ("4 ms", "2 steps", HARD, RUBBER), (0.04, 0.02, 0.01), (2e-3, 1e-3, 5e-4, 1e-4, 5e-5))
QUICK = Plan((LEVEL,), ("4 ms", RUBBER), (0.04,), (1e-3,))
FULL_ROUNDS = 5  # fewer rounds are for the quick plan


def measure(rounds: int) -> dict:
    """A survey, ladders of steps of the best of each kind of roller, options, and the best beside omnisim."""
    if mujoco is None:
        return {}
    full = rounds >= FULL_ROUNDS
    plan, (integrator, step) = FULL if full else QUICK, SURVEY
    survey = [
        attempt(Setup(rollers, contact, integrator, step, spacing), Running)
        for rollers in plan.rollers
        for contact in plan.contacts
        for spacing in plan.spacings
    ]
    ladders = []
    for rollers in plan.rollers:
        best = setup_of(wheel_scene.best_of([row for row in survey if row["rollers"] == rollers]))
        ladders += [attempt(best._replace(step=step), Running) for step in plan.steps]
    most_accurate = wheel_scene.best_of(survey + ladders)
    options = {name: attempt(setup_of(most_accurate)._replace(**change), Running) for name, change in tried().items()}
    judged = bump_scene.judged([*survey, *ladders, *options.values()], stepping, rounds, full)
    return {
        "version": mujoco.__version__,
        "survey": survey,
        "ladders": ladders,
        "options": {"as it is": most_accurate} | options,
    } | judged


def tried() -> dict[str, dict]:
    """Options for the best."""
    return {
        f"impratio {creep():.2g}: on the rubber, slip_speed of the scene": {"impratio": creep()},
        "impratio 100": {"impratio": 100.0},
        "RK4": {"integrator": "RK4"},
        "discrete": {"integrator": "discrete"},
        "heights every 30 mm": {"spacing": 0.03},
        "heights every 5 mm": {"spacing": 0.005},
    }


def setup_of(row: dict) -> Setup:
    return Setup(**{key: row[key] for key in Setup._fields})


def stepping(row: dict) -> Callable[[], None]:
    """A contestant: all steps in one call."""
    return Running(setup_of(row)).go


def report(result: dict) -> str:
    if not result:
        return MISSING
    survey = [[row["rollers"], row["contact"], f"{row['spacing'] * 1e3:g}", *cells(row)] for row in result["survey"]]
    ladders = [
        [row["rollers"], row["contact"], f"{row['spacing'] * 1e3:g}", f"{row['step']:g}", *cells(row)]
        for row in result["ladders"]
    ]
    options = [[name, *cells(row)] for name, row in result["options"].items()]
    integrator, step = SURVEY
    heading = ["rollers", "contact", "heights every, mm"]
    return "\n\n".join(
        [
            f"MuJoCo {result['version']}, elliptic cone, condim 3, by {integrator} at {step:g} s; the ground is a "
            "height field:",
            table([*heading, *COLUMNS], survey),
            "Each kind of roller by the contact and the heights that suited it best, by other steps:",
            table([*heading, "step, s", *COLUMNS], ladders),
            f"The best of these ({words(result['options']['as it is'])}) with other options:",
            table(["option", *COLUMNS], options),
            f"The best of all ({words(result['best'])}; {cells(result['best'])[0]} mm) and the fastest within "
            f"{bump_scene.NEAR:g} m ({words(result['fastest'])}) beside marches of omnisim, timed in turn:",
            bump_scene.comparison("MuJoCo", result),
            NOTES,
        ]
    )


def words(row: dict) -> str:
    return (
        f"{row['rollers']}; {row['contact']}; impratio {row['impratio']:.2g}; {row['integrator']}, {row['step']:g} s; "
        f"heights every {row['spacing'] * 1e3:g} mm"
    )


def claims(result: dict) -> list[Claim]:
    return bump_scene.claims("MuJoCo", result)
