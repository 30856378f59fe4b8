"""Pictures of studies show the numbers of their files."""

import numpy as np
import pytest

pytest.importorskip("matplotlib", reason="needs matplotlib")
import matplotlib
from commands import command, refused
from matplotlib import pyplot

from omnisim.pictures.plots.studies import study
from omnisim.pictures.plots.style import PlotError
from omnisim.studies.effects import first_order
from omnisim.studies.sweep import sweep

matplotlib.use("agg")
HEAD = {"schema": 1, "scene": "kiwi", "set": {"time.end": 0.04, "time.output_interval": 0.02}}
FAR = {"far": {"dataset": "body/position", "at": "end", "component": "norm"}}
KEYS = {"friction.coefficient": [0.05, 0.3, 0.6], "chassis.mass": [3.0, 6.0], "scene.gravity": [9.0, 9.81]}


def grid(count):
    return sweep(HEAD | {"vary": dict(list(KEYS.items())[:count]), "measure": FAR}, workers=1)


@pytest.fixture(autouse=True)
def closed():
    yield
    pyplot.close("all")


def test_one_key_makes_a_curve():
    found = grid(1)
    (axes,) = study(found).axes
    (line,) = axes.get_lines()
    np.testing.assert_array_equal(line.get_xydata().T, [KEYS["friction.coefficient"], found["far"]])
    assert axes.get_xlabel() == "friction.coefficient" and axes.get_ylabel() == "far (m)"


def test_two_keys_make_a_map():
    found = grid(2)
    axes, _ = study(found).axes
    np.testing.assert_array_equal(np.ravel(axes.collections[0].get_array()), found["far"].T.ravel())


def test_more_keys_make_a_matrix():
    figure = study(grid(3))
    assert [axes.get_xlabel() for axes in figure.axes] == list(KEYS)


def test_what_a_key_explains_comes_with_its_uncertainty():
    """y = x_0 + x_1 / 2 + noise of a tenth: shares 0.79 and 0.20 of the variance, of nothing 0; within three of the
    deviations that are told."""
    random = np.random.default_rng(2)
    x = random.normal(size=(3, 4000))
    y = x[0] + 0.5 * x[1] + 0.1 * random.normal(size=4000)
    variance = 1.0 + 0.25 + 0.01
    for values, share in zip(x, (1.0 / variance, 0.25 / variance, 0.0), strict=True):
        effect = first_order(values, y)
        assert 0.0 < effect.deviation < 0.03
        assert abs(effect.share - share) < 3.0 * effect.deviation + 0.02  # classes of x are not x itself
    assert first_order(x[0][:10], y[:10]) is None


def test_the_command_draws_a_study_and_nothing_beside_it(tmp_path):
    path = tmp_path / "study.h5"
    grid(2).save(path)
    result = command("plot", path, "-o", tmp_path / "study.png")
    assert (result.exit_code, result.output) == (0, f"{tmp_path / 'study.png'} (study)\n")
    assert (tmp_path / "study.png").read_bytes().startswith(b"\x89PNG")
    refused(command("plot", path, path, "-o", tmp_path / "two.png"), "a study is shown by itself")


def test_a_study_without_numbers_is_told():
    found = sweep(HEAD | {"vary": {"friction.coefficient": {"uniform": [-2, -1]}}, "measure": FAR,
                          "design": {"kind": "random", "count": 3}}, workers=1)  # fmt: skip
    with pytest.raises(PlotError, match="no measure of this study has a number"):
        study(found)
