"""`omnisim compare`: the two contact trackings side by side, and beside what the paper reports."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median
from typing import TYPE_CHECKING

import click

from omnisim_cli.screen import Failure, compilation_noted, note

if TYPE_CHECKING:
    from omnisim.analysis import Comparison
    from omnisim.scene import Scene
    from omnisim.trajectory import Trajectory

TRACKING = click.Choice(["implicit", "explicit"])
SCENES = ("authors_testbench", "authors_sliding")
PAPER = {"acceleration": 1e-8, "velocity": 1e-7, "position": 1e-6}  # largest differences, in SI units
PAPER_RATIO = 1.5  # time of the implicit tracking / time of the explicit one


@click.command()
@click.argument("a", metavar="A", type=TRACKING)
@click.argument("b", metavar="B", type=TRACKING)
@click.argument("scene", required=False)
def compare(a: str, b: str, scene: str | None) -> None:
    """Run SCENE with contact tracking A and with B (each implicit or explicit): how far apart, how fast.

    Without SCENE: the testbench of the paper's authors, and the same wheel sliding. Runs are repeated in
    turn, and times are medians.

    \b
    omnisim compare implicit explicit
    omnisim compare implicit explicit scene.toml
    """
    from omnisim.scene import load

    names = (scene,) if scene else SCENES
    pairs = [[load(name, [f"solver.tracking={tracking}"]) for tracking in (a, b)] for name in names]
    stopped = []
    for name, pair in zip(names, pairs, strict=True):
        trajectories = compare_pair(pair)
        stopped += [early_stop(name, trajectory) for trajectory in trajectories if not trajectory.complete]
    if stopped:
        raise Failure("\n".join(["compared up to where the first of both stopped early", *stopped]))


def early_stop(name: str, trajectory: Trajectory) -> str:
    return f"{name}, {trajectory.attributes['tracking']}: {trajectory.attributes['status']}"


def compare_pair(pair: Sequence[Scene]) -> Sequence[Trajectory]:
    """Run one scene with both trackings and print how they compare."""
    note(f"{pair[0].source}: {' and '.join(scene.config.solver.tracking for scene in pair)}, in turn ...")
    from omnisim import analysis, timing

    with compilation_noted():
        trajectories, times = timing.race(pair)
        costs = timing.tracking_costs(pair)
    comparison = analysis.compare(*trajectories)
    click.echo(headline(trajectories, comparison) + "\n")
    click.echo(beside_the_paper(trajectories, comparison, times, costs) + "\n")
    click.echo(everything(comparison) + "\n")
    return trajectories


def headline(trajectories: Sequence[Trajectory], comparison: Comparison) -> str:
    """What was compared, and which rows and events."""
    a, b = (trajectory.attributes for trajectory in trajectories)
    steps = " and ".join(dict.fromkeys(f"step {each['step']:g} s, {each['steps']} steps" for each in (a, b)))
    how = f"{a['method']}, {steps}, {comparison.rows} rows"
    lines = [a["title"] or "(no title)", f"{a['tracking']} against {b['tracking']}: {how}"]
    if comparison.apart:
        lines.append(f"{comparison.apart} rows left out: they lie between the exchange times of the two")
    if comparison.events[0] != comparison.events[1]:
        lines.append(f"numbers of events differ: {comparison.events[0]} against {comparison.events[1]}")
    return "\n".join(lines)


def beside_the_paper(
    trajectories: Sequence[Trajectory], comparison: Comparison, times: list[list[float]], costs: list[float]
) -> str:
    """The quantities that the paper reports, with its own numbers."""
    a, b = (trajectory.attributes["tracking"] for trajectory in trajectories)
    ratio = {("implicit", "explicit"): f"{PAPER_RATIO:g}", ("explicit", "implicit"): f"{1 / PAPER_RATIO:.2g}"}
    lines = [f"{'height of the centre of roller 0':<36}{'difference':<16}paper"]
    for row in comparison.centre_height:
        lines.append(f"  {row.path:<34}{row.difference:<10.2g}{row.units:<6}{PAPER[row.path]:.0e}")
    lines.append(f"{f'time, {a} / {b}':<36}{'ratio':<16}paper")
    march_a, march_b = (median(spent) for spent in times)
    seconds = f"{march_a:.3g} s / {march_b:.3g} s, medians of {len(times[0])} runs"
    lines.append(f"  {'whole run':<34}{march_a / march_b:<16.2f}{ratio.get((a, b), '-'):<8}({seconds})")
    nanoseconds = f"{costs[0] * 1e9:.3g} ns / {costs[1] * 1e9:.3g} ns for one right-hand side"
    lines.append(f"  {'contact tracking alone':<34}{costs[0] / costs[1]:<16.2f}{'-':<8}({nanoseconds})")
    return "\n".join(lines)


def everything(comparison: Comparison) -> str:
    """Largest difference of every dataset; those without any in one sentence."""
    rows = [row for row in comparison.differences if row.difference > 0.0]
    equal = [row.path for row in comparison.differences if row.difference == 0.0]
    lines = [f"{'dataset':<42}{'unit':<9}{'largest value':<16}largest difference"] if rows else []
    lines += [f"{row.path:<42}{row.units:<9}{row.largest:<16.6g}{row.difference:.2g}" for row in rows]
    if equal:
        lines += ["equal to the last bit:", *(f"  {path}" for path in equal)]
    return "\n".join(lines)
