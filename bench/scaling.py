"""64 rollers against 8 on the same wheel: a roller in the air costs nothing, whatever their number.

What is left is that exchanges come eight times as often, and each is a handful of trial steps.
"""

import statistics

from bench.common import Claim, bare_wheel, interleaved, median_ratio, ready, table

TARGET, ALARM = 1.15, 1.5  # times the 8-roller wheel
STEPS = [1e-4, 2e-5]


def measure(rounds: int) -> dict:
    """Median ratio 64 / 8 rollers at each step, with the exchanges of both wheels."""
    result = {}
    for step in STEPS:
        scenes = {count: bare_wheel(step, end=1.0, rollers=count) for count in (8, 64)}
        exchanges = {count: int(ready(scene).go().run.clock.events) for count, scene in scenes.items()}
        contestants = {str(count): (lambda scene=scene: ready(scene).go) for count, scene in scenes.items()}
        seconds = interleaved(contestants, rounds)
        result[f"{step:.0e}"] = {
            "ms_8": statistics.median(seconds["8"]) * 1e3,
            "ms_64": statistics.median(seconds["64"]) * 1e3,
            "exchanges_8": exchanges[8],
            "exchanges_64": exchanges[64],
            "ratio": median_ratio(seconds["64"], seconds["8"]),
        }
    return result


def report(result: dict) -> str:
    rows = []
    for step, row in result.items():
        exchanges = f"{row['exchanges_8']}, {row['exchanges_64']}"
        rows.append([step, f"{row['ms_8']:.2f}", f"{row['ms_64']:.2f}", exchanges, f"{row['ratio']:.3f}"])
    return table(["step, s", "8 rollers, ms per simulated s", "64 rollers, ms", "exchanges", "ratio"], rows)


def claims(result: dict) -> list[Claim]:
    worst = max(row["ratio"] for row in result.values())
    return [Claim("a march of the bare wheel with 64 rollers, by that with 8", worst, "at most", TARGET, ALARM)]
