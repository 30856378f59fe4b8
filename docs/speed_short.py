"""The page on speed in short: a few tables and sentences out of what `python -m bench --report` wrote."""

from bench.common import table

ROLLERS, STOPS, PLATFORM = "six_rollers", "coulomb_wheel", "platform"


def in_short(records: dict[str, dict]) -> str:
    """Tables of three scenes, and a line for each contestant; empty where a benchmark that they need is missing."""
    needed = ("precision", "laws", "whole_machines", "c_loop", "scipy_peer", "mujoco_peer", "scaling", "kernels")
    if not all(name in records for name in needed):
        return ""
    results = {name: records[name]["result"] for name in records}
    return "\n\n".join(
        [
            "## In short",
            f"`{ROLLERS}`, 2 s with 15 roller exchanges, smooth friction, `rk4`:",
            rollers(results["precision"][ROLLERS]["rows"]),
            f"`{STOPS}`, 2 s with 25 exchanges and 26 stops, set-valued friction, no parameter to tune, `rk4`:",
            stops(results["laws"]["exact"]),
            "A platform of 22.7 kg on four mecanum wheels of nine rollers, rate controllers, set-valued friction, 2 s "
            "with about 100 exchanges, steps of 1e-2 s by `rk4`:",
            platform(results["whole_machines"]["platform"]["ladder"]),
            "\n".join(sentences(results)),
            "Errors are those of position (m), yaw and spin angles (rad). Times real time are of the march.",
        ]
    )


def rollers(rows: list[dict]) -> str:
    ours = [row for row in rows if (row["method"], row["tracking"]) == ("rk4", "explicit")]
    cells = [[f"{row['step_s']:g}", fast(1.0 / row["wall_s_per_simulated_s"]), f"{row['error']:.1e}"] for row in ours]
    return table(["step, s", "times real time", "largest error in any row"], cells)


def stops(rows: list[dict]) -> str:
    cells = [
        [
            f"{row['step']:g}",
            fast(1e3 * row["end"] / row["march"]),
            fast(1e3 * row["end"] / row["few rows"]),
            f"{row['error']:.1e}",
        ]
        for row in rows
        if row["method"] == "rk4"
    ]
    return table(["step, s", "times real time", "with all of `omnisim.simulate`, 21 rows", "error at 2 s"], cells)


def platform(rows: list[dict]) -> str:
    ours = [row for row in rows if (row["drive"], row["method"], row["step"]) == ("rate", "rk4", 0.01)]
    cells = [
        [row["motion"], fast(2.0 / row["march"]), fast(2.0 / row["simulate"]), f"{row['error']:.1e}"] for row in ours
    ]
    titles = ["motion", "times real time", "with all of `omnisim.simulate`", "error of position in any row, m"]
    return table(titles, cells)


def sentences(results: dict[str, dict]) -> list[str]:
    """One for each contestant."""
    wheel, machine = results["c_loop"]["bare wheel"], results["c_loop"]["mecanum machine"]
    best_build = max(row["ratio"] for name, row in wheel.items() if name != "omnisim")
    wheels = {row["wheels"]: row["ns"] for row in results["whole_machines"]["wheels"]["coulomb"]}
    scipy, mujoco = results["scipy_peer"], results["mujoco_peer"]
    by_form = [(name, min_ratio(part, "NumPy"), min_ratio(part, "compiled")) for name, part in scipy.items()]
    best = mujoco["best"]
    tried = len(mujoco["survey"]) + len(mujoco["ladders"]) + len(mujoco["options"]) - 1
    ours = {(row["method"], row["step"]): row for row in mujoco["omnisim"]}
    quick, close = ours["dopri5", 1e-2], ours["rk4", 5e-3]
    with_scipy = [
        f"- At equal error SciPy's best, with the equations in NumPy, takes {numpy:.0f} times as long as `rk4` on "
        f"{name}; handed omnisim's own compiled equations {compiled:.0f} times."
        for name, numpy, compiled in by_form
    ]
    return [
        f"- A step of the bare wheel takes {wheel['omnisim']['ns_per_step']:.0f} ns: "
        f"{wheel['gcc -O3']['ratio']:.2f} times a hand-written C loop of the same equations (`gcc -O3`), "
        f"{best_build:.2f} times its fastest build. One of a mecanum machine takes "
        f"{machine['omnisim']['ns_per_step']:.0f} ns, {machine['gcc -O3']['ratio']:.2f} times a C loop written for that "
        f"machine alone. 12 wheels take {wheels[12] / wheels[3]:.1f} times as long as 3.",
        *with_scipy,
        f"- MuJoCo on `{STOPS}`, the most accurate of {tried} settings, is {best['position_error'] * 1e3:.2f} mm off, "
        f"its yaw by {best['yaw_error']:.2f} rad. `omnisim.simulate` "
        f"with `dopri5` at 1e-2 s is {nearer(best, quick)}, `rk4` at 5e-3 s {nearer(best, close)}.",
        f"- 64 rollers cost {results['scaling']['rollers']['1e-04']['ratio']:.2f} times as much as 8, with eight times the "
        f"exchanges: a roller in the air has no state. Two rows cost {span(results['scaling']['rows'])} times one row.",
        f"- Implicit contact tracking takes {ratio(results['kernels']['rk4']):.1f} times as long as explicit.",
    ]


def min_ratio(part: dict, form: str) -> float:
    """SciPy's best by rk4, where it does best."""
    return min(row["ratio"]["rk4"] for row in part["equal"] if row["form"] == form)


def span(rows: dict[str, dict]) -> str:
    """The least and the largest ratio."""
    ratios = [row["ratio"] for row in rows.values()]
    return f"{min(ratios):.2f} to {max(ratios):.2f}"


def nearer(best: dict, ours: dict) -> str:
    """How a run compares with the best of MuJoCo."""
    closer, faster = best["position_error"] / ours["position_error"], ours["simulate"]["ratios"]["the best"]
    return f"{fast(closer)} times closer and {fast(faster)} times faster"


def ratio(row: dict[str, float]) -> float:
    return row["implicit"] / row["explicit"]


def fast(speed: float) -> str:
    """To three digits."""
    return f"{float(f'{speed:.3g}'):.0f}"
