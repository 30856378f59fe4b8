"""Writes docs/pages/speed, pages and plots: python -m docs.speed_page (needs the extra `docs`).

Nothing is measured here: the numbers stand in bench/results, from `python -m bench --report bench/results`.
"""

import json
from itertools import groupby
from pathlib import Path

from bench.common import Claim, claims_table, table
from docs.speed_plots import draw
from docs.speed_short import in_short

HERE = Path(__file__).parent
RESULTS, FOLDER = HERE.parent / "bench/results", HERE / "pages/speed"
EXPLICIT, DEFAULT = ("heun", "rk4", "dopri5", "bs5"), "rk4"
METHODS = (*EXPLICIT, "radau5", "auto")
ERRORS = (1e-6, 1e-9)  # m, rad
LONG = 12  # rows: longer tables are folded
# What stands on which page; results of other benchmarks stand elsewhere.
PAGES = {
    "precision": ("Speed against error", ("precision", "accuracy", "targets")),
    "peers": ("Against C and SciPy", ("c_loop", "limit", "scipy_peer")),
    "engines": (
        "Against general engines",
        ("mujoco_peer", "mujoco_platform", "drake_peer", "mujoco_bumps", "drake_bumps"),
    ),
    "laws": ("Laws and formulations", ("laws", "formulations")),
    "cost": (
        "Machines, rollers, memory",
        ("whole_machines", "spatial", "kernels", "scaling", "native", "startup", "memory"),
    ),
    "many": ("Thousands of runs", ("studies", "short_runs", "gym")),
    "hard_cases": ("Hard cases", ("hard_cases",)),
}
SECTIONS = [name for _, names in PAGES.values() for name in names]
WRITTEN = """Written by `python -m docs.speed_page` from the numbers in `bench/results`"""
INTRODUCTION = f"""# Speed and accuracy

{WRITTEN}. Ratios are medians of rounds in which the contestants took
turns, beside the C loops and for rollers and rows those of the quietest tenth of hundreds; the rules stand in `bench/README.md`. All
numbers are of one day and one machine, a share of a larger one, whose neighbours slow both sides of a ratio, and omnisim more than
a C loop. Times real time are what it gave then: of `coulomb_wheel`, with errors below 1e-6, three runs of the bench said 10200, 9660
and 10400, of the platform below 1e-9 530, 519 and 540, within 1e-5 m 2010, 1960 and 1980. Other processors gave less and more,
by older code: an EPYC of the first generation 3570 of `coulomb_wheel` and 198 of the platform below 1e-9; an Intel Xeon 13000, 585, and
2150 within 1e-5 m, by code that takes 1.1 to 1.2 times as long as the present one. Errors and orders are the same on every machine."""
CLAIMS = """A target is what is aimed at. Beyond its alarm a value is no noise of a machine; `python -m bench --check` fails."""


def main() -> None:
    records = read(RESULTS)
    FOLDER.mkdir(exist_ok=True)
    for name, text in pages(records, draw(records, FOLDER)).items():
        (FOLDER / f"{name}.md").write_text(text, encoding="utf-8")


def read(folder: Path) -> dict[str, dict]:
    """What `python -m bench --report` wrote, by benchmark."""
    return {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in sorted(folder.glob("*.json"))}


def pages(records: dict[str, dict], drawn: dict[str, str]) -> dict[str, str]:
    """Text by page, `index` with the claims first; drawn: the stem of the plot of each benchmark that has one."""
    claims = [Claim(**claim) for name in dict.fromkeys([*SECTIONS, *records]) for claim in claims_of(records, name)]
    parts = [text for text in (INTRODUCTION, in_short(records), verdict(claims)) if text]
    if "precision" in records:
        parts.append(recommendation(records["precision"]["result"]))
    parts += ["## Claims", claims_table(claims), CLAIMS, "## Where the numbers stand", contents(records)]
    texts = {"index": parts}
    for page, (title, names) in PAGES.items():
        found = [section(records[name], drawn.get(name)) for name in names if name in records]
        texts[page] = [f"# {title}", f"{WRITTEN}; every section names machine, day and command.", *found]
    return {page: "\n\n".join(parts) + "\n" for page, parts in texts.items()}


def claims_of(records: dict[str, dict], name: str) -> list[dict]:
    return records[name]["claims"] if name in records else []


def contents(records: dict[str, dict]) -> str:
    """A line for each page: what is on it."""
    lines = []
    for page, (title, names) in PAGES.items():
        titles = [records[name]["title"] for name in names if name in records]
        lines.append(f"- [{title}]({page}.md): {'; '.join(titles)}")
    return "\n".join([*lines, "- [What real rollers do](../machines_in_numbers.md): results of `vehicle` and `twists`"])


def verdict(claims: list[Claim]) -> str:
    """How many targets are met, and a line for each that is not, with the reason if one is known."""
    missed = [
        f"- {claim.text}: {claim.value:.4g}, to be {claim.bound} {claim.target:g}"
        + (f". {claim.reason}" if claim.reason else "")
        for claim in claims
        if not claim.met
    ]
    met = f"## Targets\n\n**{len(claims) - len(missed)} of {len(claims)} targets are met.**"
    return "\n".join([f"{met} Missed:", "", *missed]) if missed else met


def recommendation(scenes: dict[str, dict]) -> str:
    """What each method gives at an error that most want and at a small one, and how far the default falls behind."""
    lines, behind = [], []
    for name, scene in scenes.items():
        for limit in ERRORS:
            speeds = {method: fastest(scene["rows"], method, limit) for method in METHODS}
            best = max(speeds, key=speeds.get)
            cells = [f"{speed:.3g}" if speed < 1e3 else f"{speed:.0f}" for speed in speeds.values()]
            marked = [f"**{cell}**" if method == best else cell for method, cell in zip(METHODS, cells, strict=True)]
            lines.append([name, f"{limit:.0e}", *(cell if cell.strip("*") != "0" else "-" for cell in marked)])
            if limit == ERRORS[0] and best in EXPLICIT and speeds[DEFAULT]:
                behind.append(speeds[best] / speeds[DEFAULT])
    return "\n\n".join(
        [
            "## Which method, which step",
            f"`{DEFAULT}`, the default, with a step from `solver.error`: of {len(scenes)} scenes there are "
            f"{len(behind)} on which it is the fastest with errors below {ERRORS[0]:.0e}, or another explicit one at "
            f"most {max(behind):.2f} times as fast. Smaller errors of a bare wheel, and a wheel near its limit of "
            "friction, are faster by `dopri5` or `bs5`; where friction is stiff, `auto` or `radau5`. The fastest "
            "march of each, times real time:",
            table(["scene", "errors below", *METHODS], lines),
        ]
    )


def fastest(rows: list[dict], method: str, limit: float) -> float:
    """Times real time of a method's fastest march with errors below a limit, by explicit tracking; 0: none."""
    speeds = [
        1.0 / row["wall_s_per_simulated_s"]
        for row in rows
        if (row["method"], row["tracking"]) == (method, "explicit")
        and row["error"] is not None
        and row["error"] < limit
    ]
    return max(speeds, default=0.0)


def section(record: dict, plot: str | None) -> str:
    """One benchmark."""
    versions = ", ".join(f"{name} {version}" for name, version in record["versions"].items())
    where = f"{record['machine']}; {versions}; {record['date'][:10]}; `{record['command']}`"
    picture = [f"[![{record['title']}]({plot}.png)]({plot}.svg)"] if plot else []
    return "\n\n".join([f"## {record['title']}", where, *picture, folded(record["report"])])


def folded(text: str) -> str:
    """Markdown whose long tables open on demand."""
    parts = []
    for is_table, group in groupby(text.split("\n"), key=lambda line: line.startswith("|")):
        lines = list(group)
        rows = len(lines) - 2  # without header and rule
        if is_table and rows > LONG:
            lines = [f"<details><summary>{rows} rows</summary>", "", *lines, "", "</details>"]
        parts += lines
    return "\n".join(parts)


if __name__ == "__main__":
    main()
