"""`omnisim compare`: two contact trackings or two formulations side by side, beside what the paper reports."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median
from typing import TYPE_CHECKING

import click

from .compiling import compilation_noted
from .screen import Failure, note

if TYPE_CHECKING:
    from omnisim.results.comparison import Comparison, Divergence
    from omnisim.results.trajectory import Trajectory
    from omnisim.scene.scene import Scene

# What is compared: attribute of the trajectory, and the scenes to compare without one from the user.
KINDS = {
    "tracking": (("implicit", "explicit"), ("authors_testbench", "authors_sliding")),
    "formulation": (("reduced", "multibody"), ("coulomb_wheel", "kiwi", "youbot")),
}
OF_FREE = {"tracking": "explicit", "formulation": "reduced"}  # what machines free in space have
CHOICE = click.Choice([name for names, _ in KINDS.values() for name in names])
PAPER_RATIO = 1.5  # in the paper: time of the implicit tracking / time of the explicit one


@click.command()
@click.argument("a", metavar="A", type=CHOICE)
@click.argument("b", metavar="B", type=CHOICE)
@click.argument("scene", required=False)
def compare(a: str, b: str, scene: str | None) -> None:
    """Run SCENE with A and with B, two contact trackings (implicit, explicit) or two formulations (reduced,
    multibody): how far apart, how fast.

    Without SCENE: for trackings the testbench of the paper's authors, and the same wheel sliding; for
    formulations a wheel, a kiwi and a youBot. Runs are repeated in turn, and times are medians.

    \b
    omnisim compare implicit explicit
    omnisim compare reduced multibody scene.toml
    """
    kind, scenes = kind_of(a, b)
    names = (scene,) if scene else scenes
    pairs = [scenes_of(name, kind, (a, b)) for name in names]
    stopped = []
    for name, pair in zip(names, pairs, strict=True):
        trajectories = compare_pair(pair, kind, (a, b))
        ends = zip((a, b), trajectories, strict=True)
        stopped += [f"{name}, {choice}: {run.attributes['status']}" for choice, run in ends if not run.complete]
    if stopped:
        raise Failure("\n".join(["compared up to where the first of both stopped early", *stopped]))


def kind_of(a: str, b: str) -> tuple[str, tuple[str, ...]]:
    """What a comparison of a and b is one of, and its scenes."""
    for kind, (choices, scenes) in KINDS.items():
        if a in choices and b in choices:
            return kind, scenes
    pairs = ", or ".join(" and ".join(choices) for choices, _ in KINDS.values())
    raise click.BadParameter(f"{a} and {b} are not of one kind; compare {pairs}", param_hint="A B")


def scenes_of(name: str, kind: str, choices: tuple[str, str]) -> list[Scene]:
    """A scene with either choice. Raises SceneError, for one of a machine free in space in the words of its file."""
    from omnisim.scene.problems import Problem
    from omnisim.scene.scene import SceneError, load

    scene = load(name)
    if scene.config.upright == "free" and set(choices) != {OF_FREE[kind]}:
        what = f"a machine free in space has one {kind}, {OF_FREE[kind]}: there is nothing to compare it with"
        problem = Problem(("scene", "upright"), f"{what}; give the scene of a machine that is held upright")
        raise SceneError(scene.document.told([problem]))
    return [load(name, [f"solver.{kind}={choice}"]) for choice in choices]


def compare_pair(pair: Sequence[Scene], kind: str, choices: tuple[str, str]) -> Sequence[Trajectory]:
    """Run one scene in both ways and print how they compare."""
    note(f"{pair[0].source}: {' and '.join(choices)}, in turn ...")
    from omnisim.results.comparison import compare, divergence
    from omnisim.run import timing

    with compilation_noted(pair):
        trajectories, times = timing.race(pair)
        costs = timing.tracking_costs(pair) if kind == "tracking" else []
    comparison = compare(*trajectories)
    click.echo(headline(trajectories, comparison, choices) + "\n")
    if kind == "tracking":
        click.echo(beside_the_paper(trajectories, comparison, times, costs) + "\n")
    else:
        click.echo(march_times(choices, times) + "\n")
    if any(row.difference for row in comparison.differences):
        click.echo(over_time(divergence(trajectories[0], trajectories[1])) + "\n")
    click.echo(everything(comparison) + "\n")
    return trajectories


def march_times(choices: tuple[str, str], times: list[list[float]]) -> str:
    """How long the marches took, and their ratio."""
    a, b = (median(spent) for spent in times)
    runs = f"medians of {len(times[0])} runs" if len(times[0]) > 1 else "one run"
    return f"time, {choices[1]} / {choices[0]}: {b / a:.3g} ({b:.3g} s / {a:.3g} s, {runs})"


def over_time(pieces: Sequence[Divergence]) -> str:
    """How the two motions part in the course of time."""
    lines = [f"{'largest difference until':<26}{'position':<12}{'yaw and spin':<14}{'velocity':<12}normal force"]
    for piece in pieces:
        sizes = piece.position, piece.angle, piece.velocity, piece.normal_force
        shown = [f"{size:.2g} {unit}" for size, unit in zip(sizes, ("m", "rad", "m/s", "N"), strict=True)]
        lines.append(f"  {f'{piece.until:g} s':<24}{shown[0]:<12}{shown[1]:<14}{shown[2]:<12}{shown[3]}")
    return "\n".join(lines)


def headline(trajectories: Sequence[Trajectory], comparison: Comparison, choices: tuple[str, str]) -> str:
    """What was compared, and which rows and events."""
    a, b = (trajectory.attributes for trajectory in trajectories)
    steps = " and ".join(dict.fromkeys(f"step {each['step']:g} s, {each['steps']} steps" for each in (a, b)))
    how = f"{a['method']}, {steps}, {comparison.rows} rows"
    lines = [a["title"] or "(no title)", f"{choices[0]} against {choices[1]}: {how}"]
    if comparison.apart:
        lines.append(f"{comparison.apart} rows left out: they lie between the exchange times of the two")
    if comparison.events[0] != comparison.events[1]:
        lines.append(f"numbers of events differ: {comparison.events[0]} against {comparison.events[1]}")
    return "\n".join(lines)


def beside_the_paper(
    trajectories: Sequence[Trajectory], comparison: Comparison, times: list[list[float]], costs: list[float]
) -> str:
    """The quantities that the paper reports, with its own numbers."""
    from omnisim.results.comparison import PAPER

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
    width = max((len(row.path) for row in rows), default=0) + 2
    lines = [f"{'dataset':<{width}}{'unit':<9}{'largest value':<16}largest difference"] if rows else []
    lines += [f"{row.path:<{width}}{row.units:<9}{row.largest:<16.6g}{row.difference:.2g}" for row in rows]
    if equal:
        lines += ["equal to the last bit:", *(f"  {path}" for path in equal)]
    return "\n".join(lines)
