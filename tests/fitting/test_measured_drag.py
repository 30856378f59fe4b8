"""The measured robots with creep, resistance and bearings: carried paths are simulated ones; the page has the fits."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from docs import measured_drag as drag
from docs.measured_robots import ALL, begun, errors_on, of_kind, values
from omnisim.fitting.fit_file import load_fit
from omnisim.fitting.paths import errors, measured
from omnisim.fitting.simulation import SimulatedPaths, prepared

MENDED = "omni4_squares_mended"


def fit_with(of, kind, keys):
    """A fit with these keys free, the way to its paths, and the runs that it is made of."""
    runs = drag.recorded(of, kind)
    return drag.with_keys(begun(load_fit(of), runs["lengths"]), keys), partial(drag.CarriedPaths, runs), runs


@pytest.mark.parametrize("of", drag.FITS)
@pytest.mark.parametrize("kind", drag.KINDS)
def test_paths_carried_nowhere_are_the_simulated_ones(of, kind):
    """Moves of each log, to the rounding with which they are kept: 1e-12 m and rad."""
    fit, ways, runs = fit_with(of, kind, ())
    paths = ways(fit)(runs["lengths"][None], list(range(8)))[0]
    point = fit.point(runs["lengths"])
    for log, path in zip(fit.logs, paths, strict=True):
        yaw = path.yaw - point.yaw
        found = drag.moves(path.position - drag.turned(np.array([point.x, point.y]), yaw), yaw)
        np.testing.assert_allclose(found, runs[f"{drag.name(log)}/plain"], atol=1e-11)


@pytest.mark.long
@pytest.mark.parametrize(("of", "log"), [(MENDED, 0), ("omni3_squares", 3)])
def test_the_record_is_what_a_simulation_moves(of, log):
    """Largest difference of a move 5e-7 m or rad, half of what is kept."""
    runs, fit = drag.recorded(of, "squares"), load_fit(of)
    fit = replace(fit, logs=(fit.logs[log],))
    robot, (plain, resisted) = of[:5], (f"{drag.name(fit.logs[0])}/{key}" for key in ("plain", "rolling_resistance"))
    found = drag.along(fit, drag.scene_of(robot), runs["lengths"])[0]
    more = drag.along(fit, drag.scene_of(robot, "rolling_resistance"), runs["lengths"])[0] - found
    assert np.abs(found - runs[plain]).max() < 1e-6
    assert np.abs(more - runs[resisted]).max() < 1e-6


@pytest.mark.long
def test_a_simulation_with_the_resistance_that_squares_tell_ends_where_the_carried_paths_do():
    """Squares 1 to 4 within 0.6 mm and 0.12 deg, circles within 3.1 mm and 0.5 deg."""
    fit, ways, _ = fit_with(MENDED, "squares", ("rolling_resistance",))
    found = values(fit, of_kind(fit, "squares"), ways)
    logs = list(range(8))
    carried = errors_on(fit, found, logs, ways)
    plain = replace(begun(load_fit(MENDED), found[:-1]), scene=drag.scene_of("omni4", "rolling_resistance", found[-1]))
    prepared(plain)
    paths = SimulatedPaths(plain, 1)(found[None, :-1], logs)[0]
    told = [errors(path, measured(log, fit.compared(log))) for path, log in zip(paths, fit.logs, strict=True)]
    apart = np.abs(carried - [(1e3 * e.end_position, np.degrees(e.end_yaw), 1e3 * e.rms_position) for e in told])
    squares = of_kind(fit, "squares")
    assert (apart[squares] < (1.0, 0.2, 1.0)).all(), apart
    assert (apart < (5.0, 0.7, 5.0)).all(), apart


@pytest.mark.long
@pytest.mark.parametrize(("of", "row"), [(MENDED, "plus bearings"), ("omni3_squares", "plus rolling resistance")])
def test_the_page_has_what_the_fits_find(of, row):
    """Circles that squares tell: bearings leave 5 mm of 36 on omni4; omni3 wants no resistance."""
    page = drag.PAGE.read_text(encoding="utf-8")
    keys = drag.ROWS[row]
    both = [drag.carried(of, kind, keys) for kind in drag.KINDS]
    section = page.partition(f"**{drag.FITS[of]}**")[2]
    shown = next(line for line in section.splitlines() if line.startswith(f"| {row} |")).replace("**", "")
    assert all(drag.other_kind(one, one) in shown for one in both)
    told = [drag.estimate(of[:5], keys[0], one.estimates[:, -1]) for one in both]
    assert f"| {drag.FITS[of]} | {drag.NAMES[keys[0]]} | {' | '.join(told)} |" in page
    assert np.isfinite([one.estimates[ALL] for one in both]).all()


@pytest.mark.long
def test_a_record_made_anew_begins_as_the_packaged_one_and_keeps_the_other_fits(monkeypatch, tmp_path):
    """The command on the first 4 s of a square and of a circle, with the lengths of whole logs. Another end changes
    steps by a little: moves of 21 mm differ by up to 1.1e-5 m, the 5e-5 to 3e-4 m that keys add by 2e-6."""
    whole, kept = load_fit(MENDED), 16
    shown = [next(i for i, log in enumerate(whole.logs) if f"_{kind}_1" in log.file) for kind in drag.KINDS]

    def short(log):
        rows = slice(whole.compared(log)[kept] + 1)
        return replace(log, **{key: getattr(log, key)[rows] for key in ("time", "position", "yaw", "angles")})

    def of_whole_logs(fit, fitted):
        kinds = [kind for kind in drag.KINDS if any(f"_{kind}_" in fit.logs[i].file for i in fitted)]
        return values(whole, [i for kind in kinds for i in of_kind(whole, kind)])

    before = dict(np.load(drag.RECORD))
    monkeypatch.setattr(drag, "RECORD", tmp_path / "record.npz")
    np.savez_compressed(drag.RECORD, **before | {f"{MENDED}/squares/of_old/plain": np.zeros((1, 3))})
    monkeypatch.setattr(drag, "load_fit", lambda of: replace(whole, logs=tuple(short(whole.logs[i]) for i in shown)))
    monkeypatch.setattr(drag, "values", of_whole_logs)
    drag.record(MENDED)
    found = dict(np.load(drag.RECORD))
    mine = {key for key in found if key.startswith(f"{MENDED}/")}
    assert found.keys() - mine == {key for key in before if not key.startswith(f"{MENDED}/")}
    assert all(np.array_equal(found[key], before[key]) for key in found.keys() - mine)
    expected = {key for key in before if key.startswith(f"{MENDED}/") and ("_1/" in key or key.endswith("/lengths"))}
    assert mine == expected and len(mine) == 16
    for key in mine:
        if key.endswith("/lengths"):
            np.testing.assert_allclose(found[key], before[key], rtol=1e-6)
        else:
            apart = drag.RECORDED * np.abs(found[key][: kept - 1] - before[key][: kept - 1])
            assert apart.max() < (2e-5 if key.endswith("/plain") else 4e-6), key
