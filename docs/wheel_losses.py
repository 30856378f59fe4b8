"""What bearings and rolling resistance of rollers cost under the platform of `omnisim wheel`.

    python -m docs.wheel_losses         writes the table of docs/pages/which_wheel.md anew, draws pictures/wheel_losses.png

The wheel is the packaged `gobilda_mecanum_104`; what its rollers lose is ASSUMED.
"""

import tomllib
from pathlib import Path

import omnisim
from omnisim.scene.toml_text import write_value
from omnisim.studies.wheel_cycle import CYCLE, Candidate, Found, compare_wheels

HERE = Path(__file__).parent / "pages"
PAGE, PICTURE = HERE / "which_wheel.md", HERE / "pictures/wheel_losses.png"
BEGIN, END = "<!-- python -m docs.wheel_losses -->\n", "<!-- end -->\n"
WHEEL = "gobilda_mecanum_104"
MASS = 20.0  # kg, of the platform
RESISTANCE, TORQUE = 0.5e-3, 5e-3  # m; N m of a roller's bearing


def candidate(name: str, roller: dict[str, float]) -> Candidate:
    """The packaged wheel with these keys of its rollers."""
    data = tomllib.loads(omnisim.load(WHEEL).text)
    data["wheel_types"][WHEEL]["roller"] |= roller
    text = "\n".join(f"{key} = {write_value(value)}" for key, value in data.items())
    return Candidate(name, omnisim.load_text(text), WHEEL)


def losses() -> list[Candidate]:
    """Rollers that lose nothing, or by bearings, by rubber that rolls, by both."""
    bearing, rolls = {"bearing_torque": TORQUE}, {"rolling_resistance": RESISTANCE}
    return [
        candidate("nothing", {}),
        candidate(f"bearings, {1e3 * TORQUE:g} N mm", bearing),
        candidate(f"rolling resistance, {1e3 * RESISTANCE:g} mm", rolls),
        candidate("both", bearing | rolls),
    ]


def table(names: list[str], found: list[dict[str, Found | str]]) -> str:
    """What is lost by the way, J/m."""
    lines = [f"| lost, J/m, to | {' | '.join(CYCLE)} |", f"| --- |{' ---: |' * len(CYCLE)}"]
    for name, motions in zip(names, found, strict=True):
        cells = [entry if isinstance(entry, str) else f"{entry.drag:.2f}" for entry in motions.values()]
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def draw(names: list[str], found: list[dict[str, Found | str]]) -> None:
    """As `omnisim wheel -o` does."""
    from omnisim.pictures.plots.wheels import side_by_side

    side_by_side(f"four {WHEEL} under {MASS:g} kg at 0.5 m/s", names, found).savefig(PICTURE, dpi=110)


if __name__ == "__main__":
    wheels = losses()
    labels, motions = [wheel.name for wheel in wheels], compare_wheels(wheels, MASS)
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    PAGE.write_text(before + BEGIN + table(labels, motions) + END + rest.partition(END)[2], encoding="utf-8")
    draw(labels, motions)
