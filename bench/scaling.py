"""What more rollers and more rows cost: 64 rollers against 8 on the same wheel, two rows against one of all rollers.

A roller in the air costs nothing, whatever their number: with 64 rollers exchanges come eight times as often, and each
is a handful of trial steps. On two rows a wheel has the same rollers at the same azimuths, half of them on either side:
as many exchanges, at which the contact jumps along the axle as well.
"""

from functools import partial

import omnisim
from bench.common import Claim, bare_wheel, interleaved, marching, quiet, ready, table
from bench.spatial import DAMPED, on_plane
from omnisim.scene.scene import Scene, changed

TARGET, ALARM = 1.15, 1.5  # times the 8-roller wheel
ROWS_TARGET, ROWS_ALARM = 1.2, 1.5  # times the wheel with all rollers in one row
STEPS = [1e-4, 2e-5]
APART = 0.02  # m, of the two rows
MARCHES_PER_ROUND = 20


def measure(rounds: int) -> dict:
    """Of rollers at each step, and of rows on each machine, what `side_by_side` tells."""
    rollers = {step: {f"{count} rollers": bare_wheel(step, 1.0, rollers=count) for count in (8, 64)} for step in STEPS}
    return {
        "rollers": {f"{step:.0e}": side_by_side(scenes, rounds) for step, scenes in rollers.items()},
        "rows": {name: side_by_side(on_rows(scene), rounds) for name, scene in machines().items()},
    }


def machines() -> dict[str, Scene]:
    """Those that are measured on one row and on two."""
    return {
        "bare wheel, 8 rollers": bare_wheel(1e-4, 1.0, rollers=8),
        "kiwi drive, 18 rollers a wheel": omnisim.load("kiwi", ["time.end=2.0"]),
        "mecanum machine free in space, 6 rollers a wheel": on_plane(DAMPED),
    }


def on_rows(scene: Scene) -> dict[str, Scene]:
    """The scene with all rollers of a wheel in one row, and with every other one in a row of its own."""
    ((name, kind),) = scene.config.wheel_types.items()
    rows = [{"offset": -0.5 * APART}, {"offset": 0.5 * APART, "phase_deg": 180.0 / (kind.rollers // 2)}]
    two = {"roller_count": kind.rollers // 2, "rows": rows}
    return {"one row": scene, "two rows": changed(scene, {"wheel_types": {name: two}})}


def side_by_side(scenes: dict[str, Scene], rounds: int) -> dict:
    """ms of a march of each of two scenes in quiet rounds, its events, and the second by the first."""
    contestants = {name: partial(marching, scene) for name, scene in scenes.items()}
    seconds = quiet(interleaved(contestants, MARCHES_PER_ROUND * rounds))
    first, second = seconds.values()
    return {
        "ms": {name: taken * 1e3 for name, taken in seconds.items()},
        "events": {name: int(ready(scene).go().run.clock.events) for name, scene in scenes.items()},
        "ratio": second / first,
    }


def report(result: dict) -> str:
    return "\n\n".join(
        [
            "More rollers on the bare wheel:",
            told("step, s", result["rollers"]),
            f"More rows, {1e3 * APART:g} mm apart:",
            told("", result["rows"]),
        ]
    )


def told(of: str, rows: dict[str, dict]) -> str:
    """A line for each comparison."""
    names = next(iter(rows.values()))["ms"]
    header = [of, *(f"{name}, ms" for name in names), "events", "ratio"]
    lines = []
    for name, row in rows.items():
        times = [f"{ms:.2f}" for ms in row["ms"].values()]
        lines.append([name, *times, ", ".join(map(str, row["events"].values())), f"{row['ratio']:.3f}"])
    return table(header, lines)


def claims(result: dict) -> list[Claim]:
    worst = max(row["ratio"] for row in result["rollers"].values())
    found = [Claim("a march of the bare wheel with 64 rollers, by that with 8", worst, "at most", TARGET, ALARM)]
    for name, row in result["rows"].items():
        text = f"a march on two rows of rollers, by that on one: {name}"
        found.append(Claim(text, row["ratio"], "at most", ROWS_TARGET, ROWS_ALARM))
    return found
