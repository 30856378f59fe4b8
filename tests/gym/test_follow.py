"""The environment omnisim/Follow-v0, one machine and many."""

import subprocess
import sys
import threading
import time
import warnings

import numpy as np
import pytest
from helpers.stages import either

import omnisim
from omnisim.base.records import lean

gymnasium = pytest.importorskip("gymnasium", reason="needs Gymnasium: pip install -e '.[test]'")
check_env = pytest.importorskip("gymnasium.utils.env_checker").check_env
AutoresetMode = pytest.importorskip("gymnasium.vector").AutoresetMode
path = pytest.importorskip("omnisim.gym").path
pieces = pytest.importorskip("omnisim.gym.machines").pieces

NAME = "omnisim/Follow-v0"
SHORT = path("circle", size=0.05)  # 0.47 s
VARY = {
    "friction.coefficient": {"uniform": [0.3, 0.8]},
    "chassis.mass": [15.0, 20.0, 25.0],
    "wheels.*.phase_deg": {"uniform": [0.0, 60.0], "each": True},
}


def single(**options):
    return gymnasium.make(NAME, **{"scene": "youbot", "path": SHORT, **options})


def many(count, **options):
    return gymnasium.make_vec(NAME, num_envs=count, **{"scene": "youbot", "path": SHORT, **options})


def actions(steps, *shape, seed=3):
    return np.random.default_rng(seed).uniform(-1.0, 1.0, (steps, *shape)).astype(np.float32)


def episode(environment, actions, seed):
    """All that a single environment returns, for so many actions, over as many episodes as they take."""
    found = [(environment.reset(seed=seed)[0], 0.0, False, False)]
    over = False
    for action in actions:
        if over:
            found.append((environment.reset()[0], 0.0, False, False))
            over = False
        else:
            found.append(environment.step(action)[:4])
            over = found[-1][2] or found[-1][3]
    return [np.array(column) for column in zip(*found, strict=True)]


def episodes(environment, actions, seed):
    """The same of a vector environment."""
    found = [(environment.reset(seed=seed)[0], *np.zeros((3, environment.num_envs)))]
    found += [environment.step(action)[:4] for action in actions]
    return [np.array(column) for column in zip(*found, strict=True)]


@pytest.mark.parametrize("action", either(["torque", "rate", "twist"], ["twist"]))
def test_the_checker_of_gymnasium_has_nothing_to_say_but_that_observations_have_no_bounds(action):
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        check_env(single(action=action, loads=True).unwrapped)
    assert [str(one.message) for one in told if "infinity" not in str(one.message)] == []


def test_a_vector_environment_has_the_spaces_of_a_single_one_stacked():
    one, some = single(), many(3)
    observed, infos = some.reset(seed=0)
    assert some.single_observation_space == one.observation_space and some.single_action_space == one.action_space
    assert observed in some.observation_space and infos == {} and observed.shape == (3, 9 + 4 + 6)
    observed, rewards, terminated, truncated, _ = some.step(some.action_space.sample())
    assert observed in some.observation_space and rewards.shape == (3,)
    assert terminated.dtype == truncated.dtype == bool


def test_every_machine_of_many_is_bit_for_bit_a_single_one_with_its_own_seed_through_several_episodes():
    acted = actions(120, 3, 3)
    together = episodes(many(3, vary=VARY), acted, 7)
    ends = together[2] + together[3]
    assert (ends.sum(axis=0) >= 2).all() and together[2].any()  # at the end of the path, and off it
    for i in range(3):
        alone = episode(single(vary=VARY), acted[:, i], 7 + i)
        for ours, theirs in zip(together, alone, strict=True):
            assert np.array_equal(ours[:, i], theirs)
    assert not np.array_equal(together[0][:, 0], together[0][:, 1])


@pytest.mark.parametrize("threads", [2, 3, 5])
@pytest.mark.long
def test_no_bit_depends_on_the_number_of_threads(threads, monkeypatch):
    monkeypatch.setattr("omnisim.gym.machines.WORTH_SHARING", -1.0)  # s: always
    acted = actions(60, 5, 3)
    one, some = (episodes(many(5, vary=VARY, threads=count), acted, 1) for count in (1, threads))
    assert all(np.array_equal(ours, theirs) for ours, theirs in zip(one, some, strict=True))


@pytest.mark.parametrize(("count", "threads", "least"), [(64, 2, 3), (64, 16, 1), (5, 5, 1), (1, 1, 1), (100, 3, 200)])
def test_threads_take_pieces_that_hold_every_machine_once(count, threads, least):
    taken = list(pieces(count, threads, least))
    assert [i for first, last in taken for i in range(first, last)] == list(range(count))
    sizes = [last - first for first, last in taken]
    assert sizes == sorted(sizes, reverse=True)  # so that all end at about the same time
    assert min(sizes[:-1], default=least) >= least


def test_the_same_seed_gives_the_same_episodes_and_another_one_others():
    acted = np.repeat(actions(60, 1, 3), 2, axis=1)
    first, again, other = (episodes(many(2, vary=VARY), acted, seed) for seed in (4, 4, 5))
    assert all(np.array_equal(ours, theirs) for ours, theirs in zip(first, again, strict=True))
    assert np.array_equal(first[0][:, 1], other[0][:, 0])  # machine 1 of seed 4 is machine 0 of seed 5
    assert not np.array_equal(first[0][:, 0], other[0][:, 0])


CASES = [
    ("youbot", "rate", {}),
    ("youbot", "torque", {}),
    pytest.param("youbot", "twist", {}, marks=pytest.mark.long),
    ("platform24v", "twist", {}),  # motors, sampled controllers
    ("kiwi", "torque", {"chassis.center_of_mass": [0.03, -0.02, 0.02]}),
    pytest.param("soccer_robot", "torque", {}, marks=pytest.mark.long),
    pytest.param("youbot", "twist", {"solver.method": "radau5"}, marks=pytest.mark.long),
    pytest.param("youbot", "twist", {"solver.formulation": "multibody"}, marks=pytest.mark.long),
    pytest.param(
        "kiwi",
        "twist",
        {"friction": {"law": "regularized", "slip_speed": 0.05}, "solver.method": "auto"},
        marks=pytest.mark.long,
    ),
]


@pytest.mark.parametrize(("scene", "action", "changes"), CASES)
def test_an_episode_is_bit_for_bit_what_a_loop_does_with_the_same_inputs(scene, action, changes):
    environment = single(scene=omnisim.load(scene, changes), action=action, loads=True, reach=1e3).unwrapped
    environment.reset(seed=0)
    inner = environment.many
    loop = omnisim.Loop(inner.scene)
    count = len(loop.names)
    for acted in 0.3 * actions(20, *environment.action_space.shape):  # all of it tips a machine
        observed = environment.step(acted)[0]
        for name, value in zip(loop.names, inner.actions.of(acted.astype(float)), strict=True):
            loop.drive(name, value)
        loop.advance(0.01)
        assert np.array_equal(observed[9 : 9 + count], loop.spin_rates)
        assert np.array_equal(inner.machines.runs.y[0], loop.run.y)
        loads = observed[9 + count : 9 + 2 * count]  # a Loop evaluates them anew
        assert np.abs(loads / loop.normal_forces - 1.0).max() < 1e-12  # measured: 3e-15
        axes = np.array([[np.cos(loop.yaw), np.sin(loop.yaw)], [-np.sin(loop.yaw), np.cos(loop.yaw)]])
        target = inner.path.poses[inner.step_of[0], 0]
        assert np.abs(observed[:2] - axes @ (target[:2] - loop.position)).max() < 1e-15  # measured: 7e-18
        assert abs(observed[2] - (target[2] - loop.yaw)) < 1e-15  # measured: 4e-16
        assert np.abs(observed[6:8] - axes @ loop.velocity).max() < 1e-15 and observed[8] == loop.yaw_rate
    assert loop.status == "running"
    done = omnisim.load_text(loop.trajectory().attributes["scene"], {"time.end": 0.2, "time.output_interval": 0.2})
    repeated = omnisim.simulate(done)
    assert np.abs(repeated["body/position"][-1, :2] - loop.position).max() < 1e-12  # measured: 0


def test_the_order_of_actions_in_memory_does_not_matter():
    acted = actions(3, 2, 3)[-1]
    found = []
    for order in "CFC":
        some = many(2)
        some.reset(seed=0)
        found.append(some.step(np.array(acted, order=order))[0])
    assert np.array_equal(found[0], found[1]) and np.array_equal(found[0], found[2])
    assert not np.array_equal(found[0][0], found[0][1])


def test_the_observation_is_the_path_seen_from_the_machine():
    table = [[0.0, 0.3, 0.2, 0.5], [1.0, 0.5, 0.2, 0.5]]
    environment = single(path=table, ahead=[0.5], scene=omnisim.load("youbot", {"initial.yaw_deg": 90.0}))
    observed, _ = environment.reset()
    turned = 0.5 - np.pi / 2.0
    assert np.allclose(observed[:3], [0.2, -0.3, turned], atol=1e-15)
    assert np.allclose(observed[3:6], [0.0, -0.1, 0.0], atol=1e-15)  # half of 0.2 m/s: it begins here
    assert np.allclose(observed[13:16], [0.2, -0.4, turned], atol=1e-15)
    for _ in range(10):
        observed, reward, *_ = environment.step(np.zeros(3, np.float32))
    x, y, yaw = observed[:3]
    assert reward == np.exp(-(x * x + y * y) / 0.01 - (yaw / 0.2) ** 2)
    assert np.allclose(observed[3:6], [0.0, -0.2, 0.0], atol=1e-3)


def test_a_machine_that_follows_its_path_by_feedback_is_truncated_at_its_end_with_nearly_all_reward():
    environment = single(path="line")
    observed, _ = environment.reset(seed=0)
    total = count = 0
    over = False
    while not over:
        acted = (observed[3:6] + 3.0 * observed[:3]) / [1.0, 1.0, 3.0]
        observed, reward, terminated, over, _ = environment.step(acted.astype(np.float32))
        assert not terminated
        total, count = total + reward, count + 1
    assert count == 600  # 6 s
    assert total > 0.999 * count  # measured: 0.99995
    assert np.hypot(*observed[:2]) < 1e-3  # measured: 2e-5 m


def test_a_machine_too_far_from_its_path_is_terminated_and_told_so():
    environment = single(path="line", reach=0.1)
    environment.reset(seed=0)
    over = False
    while not over:
        observed, _, over, truncated, info = environment.step(np.float32([0.0, 1.0, 0.0]))
        assert not truncated and over == (np.hypot(*observed[:2]) > 0.1)
    assert info == {"status": "more than 0.1 m off the path"}
    after = environment.step(np.float32([0.0, 1.0, 0.0]))
    assert after[1:4] == (0.0, True, False) and np.array_equal(after[0], observed)


def test_a_run_that_cannot_go_on_is_terminated_with_its_sentence():
    lifted = omnisim.load("youbot", {"wrench": {"times": [0.0], "force": [[0.0, 0.0, 500.0]]}})
    some = many(2, scene=lifted)
    some.reset(seed=0)
    observed, _, terminated, truncated, infos = some.step(np.zeros((2, 3), np.float32))
    assert terminated.all() and not truncated.any() and np.isfinite(observed).all() and infos["_status"].all()
    assert "the machine tips at t = 0 s" in infos["status"][1]


def test_many_begin_anew_at_the_step_after_an_end_without_reward_and_only_where_it_ended():
    some = many(2, autoreset_mode="NextStep")
    assert some.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
    first, _ = some.reset(seed=0)
    still = np.zeros((2, 3), np.float32)
    for _ in range(48):
        observed, rewards, terminated, truncated, _ = some.step(still)
    assert truncated.all() and not terminated.any() and (rewards > 0.0).all()
    observed, rewards, terminated, truncated, _ = some.step(still)
    assert np.array_equal(observed, first) and not rewards.any() and not truncated.any()


def test_without_autoreset_a_mask_says_who_begins_anew():
    some = many(3, autoreset_mode=AutoresetMode.DISABLED)
    first, _ = some.reset(seed=0)
    moved = [some.step(np.ones((3, 3), np.float32))[0] for _ in range(5)][-1]
    found, _ = some.reset(options={"reset_mask": np.array([False, True, False])})
    assert np.array_equal(found[1], first[1]) and np.array_equal(found[[0, 2]], moved[[0, 2]])


def test_friction_and_mass_are_drawn_for_every_episode():
    some = many(8, vary=VARY)
    some.reset(seed=0)
    machine = np.asarray(some.machines.parameters.machine)
    before = machine["friction"].copy()
    assert len(set(before)) == 8 and 0.3 <= before.min() < before.max() <= 0.8
    assert set(machine["chassis_mass"]) == {15.0, 20.0, 25.0}
    phases = np.asarray(some.machines.parameters.wheels)["phase"]
    assert len(set(phases.ravel())) == 32
    some.reset()
    assert not set(before) & set(machine["friction"])


@pytest.mark.long
def test_laws_that_few_machines_have_may_be_drawn_beside_others_and_change_no_bit_of_any():
    smooth = {"friction": {"law": "regularized", "coefficient": 0.6, "slip_speed": 0.02, "viscosity": 60.0}}
    options = {"scene": omnisim.load("youbot", smooth), "vary": {"friction.law": ["regularized", "viscous"]}}
    assert lean(many(2, scene=options["scene"]).unwrapped.machines.parameters.machine.dtype)
    some, acted = many(4, **options), actions(12, 4, 3)
    some.reset(seed=7)
    machine = some.unwrapped.machines.parameters.machine
    assert not lean(machine.dtype) and machine["viscous"].tolist() == [1, 0, 1, 1]
    together = episodes(some, acted, 7)
    for i in range(4):
        for alone, column in zip(episode(single(**options), acted[:, i], 7 + i), together, strict=True):
            assert np.array_equal(alone, column[:, i])


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"action": "twst"}, """option action = 'twst': must be "torque", "rate" or "twist"; did you mean 'twist'?"""),
        ({"controll": 50.0}, "option controll = 50.0: unknown key; did you mean 'control'?"),
        ({"control": 333.0}, "option control: 1 / 333 s must be a multiple of time.step = 0.0005 s"),
        ({"limits": [1.0, 2.0]}, "option limits: must be 1 or 3 numbers for actions of kind twist, not 2"),
        ({"limits": [1.0, -2.0, 1.0]}, "option limits[1] = -2.0: must be a list of finite numbers > 0"),
        ({"threads": 2}, "option threads: only for a vector environment"),
        ({"vary": [1]}, "vary: must be a table of keys of the scene"),
        ({"path": "oval"}, "path: no path is called 'oval'; must be line, square, circle, figure_eight"),
        ({"path": [[0.0, 0.0, 0.0]]}, "path: a table must be (K, 4), K >= 2, of time, x, y and yaw, not (1, 3)"),
        ({"path": [[0.0] * 4, [0.0] * 4]}, "path: times must begin at 0 and increase"),
        ({"path": [[0.0] * 4, [1.0, np.nan, 0.0, 0.0]]}, "path: row 1 is not finite"),
        ({"scene": "youbt"}, "youbt"),
        ({"scene": "six_rollers"}, "six_rollers: wheels: none has a drive that takes an input"),
        ({"scene": "thirty_two_rollers"}, 'must follow a rate where actions are a twist: kind "rate"'),
        ({"scene": "thirty_two_rollers", "action": "rate"}, "wheels.wheel.drive: must follow a rate"),
        ({"vary": {"chassis.mas": [1.0]}}, "vary"),
        ({"vary": {"friction.coefficient": []}}, "must have one value or more"),
        ({"vary": {"chassis.mass": {"uniform": [-1.0, 1.0]}}}, "impossible: chassis.mass = -1.0"),
        ({"vary": {"wheel_types.mecanum.roller_count": [6, 7]}}, "wheel_types.mecanum.roller_count: makes machines of"),
        ({"vary": {"friction.law": ["coulomb", "viscous"]}}, "friction"),
    ],
)
def test_what_cannot_be_meant_is_one_clear_line(options, told):
    with pytest.raises(ValueError) as raised:
        single(**options)
    assert told in str(raised.value) and "\n" not in str(raised.value)


def test_actions_that_are_no_numbers_are_refused():
    some = many(2)
    some.reset()
    with pytest.raises(ValueError, match=r"actions: must be \(2, 3\) finite numbers"):
        some.step(np.full((2, 3), np.nan))
    with pytest.raises(ValueError, match=r"seed: must be one number, or 2, not 3"):
        some.reset(seed=[1, 2, 3])


def test_other_threads_of_python_run_while_machines_march():
    some = many(32, vary=VARY, threads=1)
    some.reset(seed=0)
    moments, over = [], threading.Event()

    def watch():
        while not over.wait(0.001):
            moments.append(time.perf_counter())

    thread = threading.Thread(target=watch)
    thread.start()
    some.machines.drive(~some.over, some.actions.wheels, some.actions.of(np.ones((32, 3))))
    begun = time.perf_counter()
    some.machines.march(~some.over, 100)  # one call
    took = time.perf_counter() - begun
    over.set()
    thread.join()
    within = [moment for moment in moments if 0.1 * took < moment - begun < 0.9 * took]
    assert len(within) > 5  # measured: 63, in 0.09 s


def test_a_package_without_gymnasium_says_what_to_install():
    program = "import sys; sys.modules['gymnasium'] = None; import omnisim.gym"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.stderr.splitlines()[-1] == "ImportError: omnisim.gym needs Gymnasium: pip install 'omnisim-engine[gym]'"


def test_the_environment_of_one_goes_through_gymnasiums_own_vectors_too():
    ours, theirs = many(2), gymnasium.make_vec(NAME, 2, "sync", scene="youbot", path=SHORT)
    acted = actions(50, 2, 3)
    for one, other in zip(episodes(ours, acted, 5), episodes(theirs, acted, 5), strict=True):
        assert np.array_equal(one, other)


def test_a_machine_free_in_space_is_refused():
    with pytest.raises(omnisim.SceneError, match=r'scene\.upright = "free": environments take machines that are held'):
        single(scene="cable_duct")
