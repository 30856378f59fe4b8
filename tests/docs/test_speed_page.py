"""The pages on speed and accuracy say what the results say."""

import json
import re
import statistics

import pytest

pytest.importorskip("matplotlib", reason="needs matplotlib")
from bench.memory import MEGABYTE
from docs import speed_page, speed_plots, speed_short

BOUND = {"bound": "at most", "target": 1.2, "alarm": 2.5}


def record(name, result, report="| a |\n| --- |\n| 1 |", value=1.0):
    """What `python -m bench --report` writes."""
    return {
        "title": name.capitalize(),
        "command": f"python -m bench {name}",
        "date": "2026-01-02T03:04:05+00:00",
        "machine": "a processor",
        "versions": {"numba": "0.1"},
        "claims": [{"text": f"{name} is quick", "value": value, **BOUND}],
        "report": report,
        "result": result,
    }


@pytest.fixture
def records(tmp_path):
    kernels = {"rhs": {"explicit": 50.0, "implicit": 100.0}, "rk4": {"explicit": 200.0, "implicit": 400.0}}
    for name, made in {
        "kernels": record("kernels", kernels),
        "scaling": record("scaling", {}, "A sentence.\n\n" + "\n".join(["| row |"] * 15) + "\n\nThe end.", 2.0),
        "twists": record("twists", []),
    }.items():
        made["claims"][0]["reason"] = "Rollers touch" if name == "scaling" else ""
        (tmp_path / f"{name}.json").write_text(json.dumps(made))
    return speed_page.read(tmp_path)


def test_the_page_begins_with_a_verdict_and_shows_what_is_missed(records):
    page = speed_page.pages(records, {})["index"]
    assert "**2 of 3 targets are met.** Missed:\n\n- scaling is quick: 2, to be at most 1.2. Rollers touch\n\n" in page
    assert page.index("targets are met") < page.index("| scaling is quick | 2 | at most 1.2 | **missed** | 2.5 |")
    assert "[Machines, rollers, memory](cost.md): Kernels; Scaling" in page
    assert "Twists" not in "".join(speed_page.pages(records, {}).values())  # machines_in_numbers.md has them


def test_each_section_names_machine_day_and_command(records):
    page = speed_page.pages(records, {})["cost"]
    assert page.index("## Kernels") < page.index("## Scaling")
    assert "a processor; numba 0.1; 2026-01-02; `python -m bench scaling`" in page


def test_long_tables_are_folded_and_short_ones_are_not(records):
    page = speed_page.pages(records, {})["cost"]
    assert page.count("<details>") == page.count("</details>") == 1
    head, _, rest = page.partition("<details><summary>13 rows</summary>\n\n| row |\n")
    assert head.endswith("A sentence.\n\n") and rest.partition("</details>")[2].startswith("\n\nThe end.")


def test_every_plot_is_written_and_stands_in_its_section(records, tmp_path):
    drawn = speed_page.draw(records, tmp_path)
    assert drawn == {"kernels": "kernels"}
    assert (tmp_path / "kernels.png").stat().st_size > 1000 and (tmp_path / "kernels.svg").stat().st_size > 1000
    page = speed_page.pages(records, drawn)["cost"]
    assert page.index("## Kernels") < page.index("(kernels.png)") < page.index("## Scaling")


def test_the_page_recommends_by_the_fastest_march_of_each_method_that_is_accurate_enough():
    def row(method, error, seconds, tracking="explicit"):
        return {"method": method, "tracking": tracking, "error": error, "wall_s_per_simulated_s": seconds}

    rows = [row("rk4", 1e-7, 2e-3), row("rk4", 1e-10, 1e-2), row("rk4", 1e-5, 1e-4), row("dopri5", 1e-8, 1e-3)]
    rows += [row("rk4", 1e-8, 1e-4, "implicit"), row("heun", None, None)]
    said = speed_page.recommendation({"a wheel": {"rows": rows}})
    assert "| a wheel | 1e-06 | - | 500 | **1000** | - | - |" in said
    assert "| a wheel | 1e-09 | - | **100** | - | - | - |" in said
    assert "at most 2.00 times as fast" in said


def test_the_committed_pages_are_what_the_script_makes_of_the_committed_results():
    records = speed_page.read(speed_page.RESULTS)
    drawn = {name: stem for name, (stem, *_) in speed_plots.FIGURES.items()} | {"precision": "work_precision"}
    made = speed_page.pages(records, drawn)
    assert {path.stem for path in speed_page.FOLDER.glob("*.md")} == set(made)
    for name, text in made.items():
        assert (speed_page.FOLDER / f"{name}.md").read_text(encoding="utf-8") == text, name
    plots = [f"{stem}.{suffix}" for stem in drawn.values() for suffix in ("png", "svg")]
    assert all((speed_page.FOLDER / plot).exists() for plot in plots)


def test_the_page_in_short_says_what_the_results_say():
    page = speed_page.pages(speed_page.read(speed_page.RESULTS), {})["index"]
    row = json.loads((speed_page.RESULTS / "laws.json").read_text())["result"]["exact"][0]
    assert f"| 0.01 | {speed_short.fast(2e3 / row['march'])} |" in page
    assert row["method"] == "rk4" and row["step"] == 0.01 and f"| {row['error']:.1e} |" in page


def test_the_page_of_validation_tells_of_the_fastest_engine_what_the_results_say():
    page = " ".join((speed_page.FOLDER.parent / "validation.md").read_text(encoding="utf-8").split())
    mujoco = speed_page.read(speed_page.RESULTS)["mujoco_peer"]["result"]
    ratios = [row["simulate"]["ratios"]["the fastest"] for row in mujoco["omnisim"]]
    errors = [row["position_error"] for row in mujoco["omnisim"]]
    assert f"fastest setting is {1e3 * mujoco['fastest']['position_error']:.0f} mm off" in page
    assert f"takes {min(ratios):.1f} to {max(ratios):.0f} times as long" in page
    assert f"errors of {min(errors):.0e} to {max(errors):.1e} m".replace("e-0", "e-") in page


def test_the_five_numbers_of_the_readme_are_those_of_the_results():
    """Renew README.md with bench/results: a measured ratio may be told to 2 %."""
    readme = " ".join((speed_page.HERE.parent / "README.md").read_text(encoding="utf-8").split())
    results = {name: record["result"] for name, record in speed_page.read(speed_page.RESULTS).items()}
    stops = {row["step"]: row for row in results["laws"]["exact"] if row["method"] == "rk4"}
    platform = [2.0 / row["march"] for row in results["whole_machines"]["platform"]["ladder"]
                if (row["drive"], row["method"], row["step"]) == ("rate", "rk4", 0.01)]  # fmt: skip
    wheel, best = results["scipy_peer"]["coulomb_wheel"], results["mujoco_peer"]["best"]
    ours = next(row for row in results["mujoco_peer"]["omnisim"] if (row["method"], row["step"]) == ("dopri5", 0.01))
    told = {
        r"1\.1e-5 \(m, rad\) off at (\d+) times real time": 2e3 / stops[0.01]["march"],
        r"2\.0e-9 off at (\d+)\.": 2e3 / stops[0.001]["march"],
        r"nine rollers, within 2e-6 m: (\d+) to": min(platform),
        r"nine rollers, within 2e-6 m: \d+ to (\d+) times": max(platform),
        r"bare wheel takes ([\d.]+) times a hand-written C loop": results["c_loop"]["bare wheel"]["gcc -O3"]["ratio"],
        r"in NumPy, takes (\d+) times as long": speed_short.min_ratio(wheel, "NumPy"),
        r"compiled equations (\d+) times": speed_short.min_ratio(wheel, "compiled"),
        r"all settings tried ([\d.]+) mm": 1e3 * best["position_error"],
        r"yaw off by ([\d.]+) rad": best["yaw_error"],
        r"`omnisim.simulate` is (\d+) times closer": best["position_error"] / ours["position_error"],
        r"times closer and (\d+) times faster": ours["simulate"]["ratios"]["the best"],
    }
    for words, value in told.items():
        (number,) = re.findall(words, readme)
        assert float(number) == pytest.approx(value, rel=0.02), words
    assert [f"{stops[step]['error']:.1e}" for step in (0.01, 0.001)] == ["1.1e-05", "2.0e-09"]


def test_the_page_on_studies_tells_the_record():
    page = " ".join((speed_page.HERE / "pages/studies.md").read_text(encoding="utf-8").split())
    result = speed_page.read(speed_page.RESULTS)["studies"]["result"]
    one, processes, threads = (
        statistics.median(result["rates"][name])
        for name in ("study, 1 process", "study, 2 processes", "its runs on 2 threads")
    )
    assert f"processes do {processes:.0f} runs a second" in page
    assert f"not write a file, {threads:.0f}, one process {one:.0f}." in page
    for count, peak in result["peak"].items():
        assert f"| {count} | {peak / MEGABYTE:.0f} MiB |" in page
