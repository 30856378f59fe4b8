"""A machine stepped from outside: what each way to step the kiwi drive with a Loop takes beyond one march."""

import statistics
from functools import partial

import omnisim
from bench.common import interleaved, median_ratio, table
from omnisim.run.loop import Loop

STEPS = 1000  # of the kiwi drive: half a second, while its command rises by KIWI_RISE
KIWI_RISE = 0.3  # m/s^2


def at_once(loop: Loop) -> None:
    loop.advance(STEPS * loop.run.clock.dt)


def one_by_one(loop: Loop) -> None:
    step = loop.run.clock.dt
    for _ in range(STEPS):
        loop.advance(step)


def driven(loop: Loop) -> None:
    """The back wheel gets the input that it has anyway: 0, as the kiwi goes forward."""
    step = loop.run.clock.dt
    for _ in range(STEPS):
        loop.drive("back", 0.0)
        loop.advance(step)


def commanded(loop: Loop) -> None:
    """The rise of the kiwi's own command as stairs."""
    step = loop.run.clock.dt
    for _ in range(STEPS):
        loop.command(KIWI_RISE * loop.time, 0.0, 0.0)
        loop.advance(step)


CALLS = {
    f"one advance of {STEPS} steps": at_once,
    f"{STEPS} times: advance": one_by_one,
    f"{STEPS} times: drive, advance": driven,
    f"{STEPS} times: command, advance": commanded,
}


def measure(rounds: int) -> dict:
    """Microseconds per step of each way to step the kiwi; beyond one advance, and that of the set input alone."""
    scene = omnisim.load("kiwi")
    contestants = {name: (lambda call=call: partial(call, Loop(scene))) for name, call in CALLS.items()}
    seconds = interleaved(contestants, rounds)
    whole, single = list(CALLS)[:2]
    return {
        name: {
            "us": statistics.median(times) / STEPS * 1e6,
            "beyond": difference(times, seconds[whole]),
            "input": difference(times, seconds[single]) if name not in (whole, single) else None,
            "ratio": median_ratio(times, seconds[whole]),
            "real_time": STEPS * scene.config.time.step / statistics.median(times),
        }
        for name, times in seconds.items()
    }


def difference(times: list[float], others: list[float]) -> float:
    """Median over the rounds, microseconds per step."""
    return statistics.median(a - b for a, b in zip(times, others, strict=True)) / STEPS * 1e6


def loop_table(calls: dict) -> str:
    header = ["calls", "microseconds per step", "beyond the march", "the input alone", "ratio", "times real time"]
    rows = [
        [
            name,
            f"{row['us']:.2f}",
            f"{row['beyond']:.2f}",
            "-" if row["input"] is None else f"{row['input']:.2f}",
            f"{row['ratio']:.2f}",
            f"{row['real_time']:.0f}",
        ]
        for name, row in calls.items()
    ]
    return table(header, rows)
