"""What rubber and gaps between rollers do to the platform of `omnisim wheel`.

    python -m docs.wheel_rubber         writes the table of docs/pages/which_wheel.md anew, draws pictures/wheel_rubber.png

The wheel is the packaged `gobilda_mecanum_104`, rigid or free on rubber; its rubber and its gaps are ASSUMED.
"""

import math
from pathlib import Path
from typing import Any

import omnisim
from omnisim.scene.rollers import rolling
from omnisim.scene.scene import load_text
from omnisim.studies.many import simulate_many
from omnisim.studies.wheel_cycle import CYCLE, SPEED, STEADY, Candidate, Found, Platform

HERE = Path(__file__).parent / "pages"
PAGE, PICTURE = HERE / "which_wheel.md", HERE / "pictures/wheel_rubber.png"
BEGIN, END = "<!-- python -m docs.wheel_rubber -->\n", "<!-- end -->\n"
WHEEL = "gobilda_mecanum_104"
MASS = 20.0  # kg, of the platform
FRICTION = {"law": "regularized", "coefficient": 0.6, "slip_speed": 0.01}
METHOD, STEP = "radau5", 2.5e-4  # s
HARD, SOFT = 1e6, 1e5  # N/m
DAMPED = 0.1  # of critical, of a quarter of the platform on one roller
CUT = 10.0  # deg, half the angle over which a roller with gaps carries; 180 / 11 without
TOLD = ("forward", "sideways")
Run = tuple[Found | str, float]  # and how often a wheel leaves the floor, 1/m


def scene(keys: dict[str, Any], step: float = STEP) -> omnisim.Scene:
    """Four of the packaged wheel under a platform, with these keys."""
    rigid = omnisim.load(WHEEL)
    text = Platform(Candidate(WHEEL, rigid, WHEEL), MASS, SPEED).scene("forward")
    always = {"friction": FRICTION, "solver": {"method": METHOD}, "time.step": step}
    return load_text(text, always | keys)


def rubber(stiffness: float, gaps: bool) -> dict[str, Any]:
    """Keys of a machine that is free on it."""
    damping = 2.0 * DAMPED * math.sqrt(stiffness * MASS / 4.0)
    kind = f"wheel_types.{WHEEL}"
    keys: dict[str, Any] = {"scene.upright": "free", f"{kind}.contact": {"stiffness": stiffness, "damping": damping}}
    return keys | ({f"{kind}.covered_deg": CUT} if gaps else {})


def candidates(step: float = STEP) -> list[Candidate]:
    """Rigid, and hard and soft rubber without gaps and with them."""
    kinds = {"rigid": {}} | {
        f"{name}, {'gaps' if gaps else 'no gap'}": rubber(stiffness, gaps)
        for gaps in (False, True)
        for name, stiffness in (("hard", HARD), ("soft", SOFT))
    }
    return [Candidate(name, scene(keys, step), WHEEL) for name, keys in kinds.items()]


def drop(wheel: Candidate) -> float:
    """Of a wheel between two rollers, m."""
    found = rolling(wheel.scene.config.wheel_types[WHEEL])
    return found.highest - found.lowest


def driven(wheels: list[Candidate], motions: tuple[str, ...] = tuple(CYCLE)) -> list[dict[str, Run]]:
    """What each wheel does in these motions."""
    platforms = [Platform(wheel, MASS, SPEED) for wheel in wheels]
    runs = iter(simulate_many([load_text(platform.scene(motion)) for platform in platforms for motion in motions]))
    return [{motion: told(platform, next(runs), motion) for motion in motions} for platform in platforms]


def told(platform: Platform, run: omnisim.Trajectory, motion: str) -> Run:
    found = platform.found(run, motion)
    lifted = (run["events/time"] >= STEADY) & (run["events/kind"] == "lift_off")
    return found, float(lifted.sum()) / (SPEED * (run.time[-1] - STEADY))


def table(wheels: list[Candidate], found: list[dict[str, Run]]) -> str:
    """Rows by motion and wheel."""
    lines = [
        "| | | ripple of velocity | up and down | peak load, of its share | wheels leave the floor | drives give |",
        "| --- | --- | ---: | ---: | ---: | ---: | ---: |",
    ]
    for motion in TOLD:
        for wheel, motions in zip(wheels, found, strict=True):
            one, lifted = motions[motion]
            assert isinstance(one, Found), one
            height = "" if one.height is None else f"{1e3 * one.height:.2f} mm"
            cells = [
                motion if wheel is wheels[0] else "", wheel.name, f"{1e3 * one.ripple:.1f} mm/s", height,
                f"{one.load:.2f}", f"{lifted:.0f} /m", f"{one.energy:.1f} J/m",
            ]  # fmt: skip
            lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def draw(wheels: list[Candidate], found: list[dict[str, Run]]) -> None:
    """As `omnisim wheel -o` does."""
    from omnisim.pictures.plots.wheels import side_by_side

    names = [wheel.name for wheel in wheels]
    shown = [{motion: one for motion, (one, _) in motions.items()} for motions in found]
    side_by_side(f"four {WHEEL} under {MASS:g} kg at {SPEED:g} m/s", names, shown).savefig(PICTURE, dpi=110)


if __name__ == "__main__":
    compared = candidates()
    done = driven(compared)
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    PAGE.write_text(before + BEGIN + table(compared, done) + END + rest.partition(END)[2], encoding="utf-8")
    draw(compared, done)
