"""A study file: what it means, and what is said of a bad one."""
# ruff: noqa: E501  (tables of texts)

import math
from statistics import NormalDist

import numpy as np
import pytest

from omnisim.scene.document import InputError
from omnisim.studies.study import load_study

pytestmark = pytest.mark.short
HEAD = 'schema = 1\nscene = "youbot"\n'
FRICTION = '"friction.coefficient" = [0.3, 0.5]\n'


def study(tmp_path, text, head=HEAD):
    path = tmp_path / "study.toml"
    path.write_text(head + text)
    return load_study(path)


def test_a_grid_has_a_run_for_every_combination(tmp_path):
    found = study(tmp_path, f'[vary]\n{FRICTION}"wheel_types.mecanum.roller_count" = {{ from = 6, to = 8 }}\n')
    assert found.shape == (2, 3)
    assert [found.values(run) for run in (0, 1, 5)] == [[[0.3], [6]], [[0.3], [7]], [[0.5], [8]]]


def test_zip_takes_lists_side_by_side(tmp_path):
    found = study(tmp_path, f'[vary]\n{FRICTION}"chassis.mass" = [20.0, 30.0]\n[design]\nkind = "zip"\n')
    assert [found.values(run) for run in range(found.count)] == [[[0.3], [20.0]], [[0.5], [30.0]]]


def test_ranges_are_linear_or_logarithmic_with_their_ends(tmp_path):
    text = '[vary]\n"chassis.mass" = { from = 1.0, to = 100.0, count = 3, spacing = "log" }\n'
    assert study(tmp_path, text).factors[0].listed == pytest.approx((1.0, 10.0, 100.0), rel=1e-15)
    text = '[vary]\n"chassis.mass" = { from = 1, to = 2, count = 5 }\n'
    assert study(tmp_path, text).factors[0].listed == (1.0, 1.25, 1.5, 1.75, 2.0)


def test_a_star_stands_for_all_wheels_and_each_draws_for_every_one(tmp_path):
    text = '[vary]\n"wheels.*.phase_deg" = {{ uniform = [0, 60]{} }}\n[design]\nkind = "random"\ncount = 3\n'
    one, each = (study(tmp_path, text.format(more)) for more in ("", ", each = true"))
    assert len({value for _, value in one.settings(1)}) == 1 and len({value for _, value in each.settings(1)}) == 4
    wheels = each.data(1)["wheels"]
    assert [wheel["phase_deg"] for wheel in wheels] == each.values(1)[0]


@pytest.mark.parametrize("kind", ["random", "sobol", "latin"])
def test_draws_follow_their_distributions_and_their_seed(tmp_path, kind):
    """1024 draws: means and deviations within four standard errors of chance, and the same bits again."""
    text = (
        '[vary]\n"chassis.mass" = {{ mean = 22.0, deviation = 1.0 }}\n"friction.coefficient" = {{ loguniform = [0.1, 1.0] }}\n'
        '"wheel_types.mecanum.roller_count" = {{ from = 5, to = 8 }}\n"wheels.rear_left.spin_rate" = [1.0, 2.0]\n'
        '[design]\nkind = "{}"\ncount = 1024\nseed = {}\n'
    )
    found = study(tmp_path, text.format(kind, 7))
    mass, friction, rollers, rate = np.array([[values[0] for values in found.values(run)] for run in range(1024)]).T
    for values, mean, deviation in (
        (mass, 22.0, 1.0),
        (np.log10(friction), -0.5, 12**-0.5),
        (rollers, 6.5, 1.25**0.5),
        (rate, 1.5, 0.5),
    ):
        assert abs(values.mean() - mean) < 4.0 * deviation / 32.0
        assert abs(values.std() - deviation) < 4.0 * deviation / 32.0
    assert set(rollers) == {5, 6, 7, 8}
    again, other = (study(tmp_path, text.format(kind, seed)) for seed in (7, 8))
    assert found.values(513) == again.values(513) != other.values(513)


def test_the_columns_of_a_file_are_the_values_of_its_runs_and_those_of_pythons_own_numbers(tmp_path):
    """To the last bit, which an exponential or a logarithm of arrays does not promise."""
    found = study(
        tmp_path,
        '[vary]\n"chassis.mass" = { mean = 22.0, deviation = 1.0 }\n"friction.coefficient" = { loguniform = [0.1, 1.0] }\n'
        '"wheels.*.phase_deg" = { uniform = [0.1, 60.3], each = true }\n"wheels.rear_left.spin_rate" = [1.0, 2.0]\n'
        '"wheel_types.mecanum.roller_count" = { from = 5, to = 8 }\n[design]\nkind = "random"\ncount = 1000\n',
    )
    runs = [found.values(run) for run in range(1000)]
    assert found.columns == [[value for own in values for value in own] for values in zip(*runs, strict=True)]
    mass, friction, phase, _, _ = found.columns
    shares = found.shares.tolist()
    assert mass == [NormalDist(22.0, 1.0).inv_cdf(share[0]) for share in shares]
    assert friction == [math.exp(math.log(0.1) + share[1] * (math.log(1.0) - math.log(0.1))) for share in shares]
    assert phase == [0.1 + one * (60.3 - 0.1) for share in shares for one in share[2:6]]


def test_distributions_with_a_count_are_drawn_by_chance(tmp_path):
    found = study(tmp_path, '[vary]\n"chassis.mass" = { uniform = [1, 2] }\n[design]\ncount = 5\n')
    assert (found.kind, found.shape) == ("random", (5,))


def test_the_sequences_fill_the_square_more_evenly_than_chance():
    """Largest gap of one coordinate among 256: 1/256 each of a Latin hypercube and of Sobol's sequence."""
    from omnisim.studies.study import drawn

    gaps = {kind: np.diff(np.sort(drawn(kind, 256, 2, 3)[:, 1])).max() for kind in ("random", "sobol", "latin")}
    assert gaps["random"] > 2.0 / 128.0 > max(gaps["sobol"], gaps["latin"])


WRONG = {
    "unknown key of the study": ('[vary]\n"friction.coefficient" = [1]\n[designs]\n', "study.toml:5: designs = {}: unknown key"),
    "nothing varied": ("", "vary: missing; must be a table of keys of the scene in quotes"),
    "key that no scene has": ('[vary]\n"frictoin.coefficient" = [0.5]\n', "did you mean 'friction'?"),
    "key that no wheel has": ('[vary]\n"wheels.*.phse_deg" = [1.0]\n', "unknown key; did you mean 'phase_deg'?"),
    "wheel that is not there": ('[vary]\n"wheels.left.phase_deg" = [1.0]\n', "no wheel is called 'left'"),
    "wheel type that is not there": ('[vary]\n"wheel_types.omni.radius" = [1.0]\n', "no wheel type is called 'omni'"),
    "star elsewhere": ('[vary]\n"friction.*" = [1.0]\n', "a * stands for all of wheels or wheel_types"),
    "no quotes": ("[vary]\nfriction.coefficient = [1.0]\n", 'a dotted key stands in quotes, such as "friction.coefficient"'),
    "empty list": ('[vary]\n"friction.coefficient" = []\n', "study.toml:4: vary.'friction.coefficient' = []: must have one value"),
    "text for a number": ('[vary]\n"chassis.mass" = [1.0, "two"]\n', "'two': must be a finite number > 0"),
    "not a number": ('[vary]\n"chassis.mass" = [1.0, nan]\n', "nan: must be a finite number > 0"),
    "impossible value": ('[vary]\n"chassis.mass" = [1.0, -2.0]\n', "-2.0: must be a finite number > 0"),
    "wrong key of a distribution": ('[vary]\n"chassis.mass" = { mean = 2.0, sigma = 1.0 }\n', "unknown key"),
    "half a distribution": ('[vary]\n"chassis.mass" = { mean = 2.0 }\n', "must be a list of values, { from, to }"),
    "two distributions": ('[vary]\n"chassis.mass" = { mean = 2.0, deviation = 1.0, uniform = [1, 2] }\n', "and nothing else"),
    "uniform upside down": ('[vary]\n"chassis.mass" = { uniform = [2, 1] }\n', "the first below the second"),
    "logarithm of nothing": ('[vary]\n"chassis.mass" = { loguniform = [0, 1] }\n', "both > 0"),
    "range without count": ('[vary]\n"chassis.mass" = { from = 1.0, to = 2.0 }\n', "must be 2 or more"),
    "distribution on a grid": ('[vary]\n"chassis.mass" = { uniform = [1, 2] }\n', "takes a design that draws"),
    "draws without count": ('[vary]\n"chassis.mass" = { uniform = [1, 2] }\n[design]\nkind = "latin"\n', "design.count: missing"),
    "grid with count": ('[vary]\n"chassis.mass" = [1, 2]\n[design]\ncount = 3\n', "makes its own number of runs"),
    "zip of two lengths": (f'[vary]\n{FRICTION}"chassis.mass" = [1]\n[design]\nkind = "zip"\n', "friction.coefficient 2, chassis.mass 1"),
    "each of one": ('[vary]\n"chassis.mass" = { uniform = [1, 2], each = true }\n[design]\nkind = "random"\ncount = 2\n', "there is none"),
    "unknown design": (f'[vary]\n{FRICTION}[design]\nkind = "sobl"\n', "did you mean 'sobol'?"),
    "bad setting": (f'set = {{ "time.nd" = 1.0 }}\n[vary]\n{FRICTION}', "did you mean 'end'?"),
    "no TOML": ("[vary\n", "study.toml:3: not valid TOML"),
}  # fmt: skip


@pytest.mark.parametrize("which", WRONG)
def test_a_bad_study_is_told_in_one_line(tmp_path, which):
    text, told = WRONG[which]
    with pytest.raises(InputError) as caught:
        study(tmp_path, text)
    assert told in str(caught.value) and "\n" not in str(caught.value)


def test_a_missing_file_or_scene_is_told(tmp_path):
    with pytest.raises(InputError, match=r"none\.toml: No such file"):
        load_study(tmp_path / "none.toml")
    with pytest.raises(InputError, match="no file and no packaged scene has this name; did you mean 'youbot'"):
        study(tmp_path, f"[vary]\n{FRICTION}", 'schema = 1\nscene = "youbt"\n')


def test_a_scene_stands_beside_its_study(tmp_path):
    from omnisim import load

    (tmp_path / "own.toml").write_text(load("youbot", ["chassis.mass=33.0"]).text)
    found = study(tmp_path, f"[vary]\n{FRICTION}", 'schema = 1\nscene = "own.toml"\n')
    assert found.scene.config.chassis.mass == 33.0
