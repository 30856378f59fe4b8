"""Speed against error, from easy scenes to hard ones: what `omnisim bench` measures, by scenes chosen for it.

The reference of each scene is computed on the spot and confirmed by another method; see `omnisim.run.work_precision`.
"""

from bench.common import Claim, table
from bench.precision_scenes import ENTRIES, Entry, chosen
from omnisim.base import methods
from omnisim.run import work_precision
from omnisim_cli.bench_report import GOALS, LEGEND, scene_data, section, winner

FULL_ROUNDS = 5  # fewer rounds are for the quick ones


def measure(rounds: int) -> dict:
    """By scene: the numbers of `omnisim bench`, and what the command says."""
    entries, methods = chosen(rounds < FULL_ROUNDS)
    return {name: measure_entry(entry, methods, rounds) for name, entry in entries.items()}


def measure_entry(entry: Entry, methods: tuple[str, ...], rounds: int) -> dict:
    found = work_precision.measure(entry.scene(), entry.settings(methods), rounds)
    return scene_data(found) | {
        "winners": [winner(found, goal) for goal in GOALS],
        "report": "\n\n".join(section(found)),
    }


def report(result: dict) -> str:
    header = ["scene", "friction", *(f"fastest with errors below {goal:.0e}" for goal in GOALS)]
    rows = [[name, data["law"], *data["winners"]] for name, data in result.items()]
    scenes = (f"### {data['title']}\n\n{data['report']}" for data in result.values())
    return "\n\n".join([table(header, rows), LEGEND.replace("*:", "\\*:"), *scenes])


def claims(result: dict) -> list[Claim]:
    """How fast some method marches with errors below a limit."""
    found = []
    for name, data in result.items():
        for speed in ENTRIES[name].speeds:
            rows = [row for row in data["rows"] if below(row, speed.limit)]
            fastest = max(rows, key=times_real_time, default=None)
            text = f"times real time with errors below {speed.limit:g}, {name}"
            value, reason = (times_real_time(fastest), spent(fastest)) if fastest else (0.0, "")
            found.append(Claim(text, value, "at least", speed.target, speed.alarm, reason))
    return found


def spent(row: dict) -> str:
    """What a march by an explicit method did beside the stages of its steps."""
    own = methods.METHODS[row["method"]].tableau.stages * row["steps"]
    return (
        f"By `{row['method']}` at {row['step_s']:g} s, {row['rhs_evaluations']} right-hand sides: {own} of its steps, "
        f"the others of {row['events']} events and of slow slip"
    )


def below(row: dict, limit: float) -> bool:
    return row["error"] is not None and row["error"] < limit


def times_real_time(row: dict) -> float:
    return 1.0 / row["wall_s_per_simulated_s"]
