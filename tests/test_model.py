"""What `info` says is modelled is what is integrated."""

import pytest
from scenes import packed, reference_scene

from omnisim.model import describe
from omnisim.scene import load, packaged_scenes

pytestmark = pytest.mark.short


@pytest.mark.parametrize("tracking", ["explicit", "implicit"])
@pytest.mark.parametrize("name", packaged_scenes())
def test_the_states_counted_are_the_states_integrated(name, tracking):
    scene = load(name, [f"solver.tracking={tracking}"])
    model = describe(scene.config)
    assert model.states == len(packed(scene)[1].y)
    assert f"{model.states} states" in model.line
    assert "\n" not in model.line


def test_only_what_the_scene_needs_is_modelled():
    def modelled(*overrides):
        return {
            part.name for part in describe(reference_scene("testbench_psi30", *overrides).config).parts if part.modelled
        }

    plain = modelled()
    assert "rollers in the air" not in plain
    assert modelled("friction.law=none") == plain - {"friction"}
    assert modelled("wheels.wheel.drive={kind='torque', torque=1.0}") == plain | {"drive"}
    assert modelled("wrench.times=[0]", "wrench.force=[[1, 0, 0]]") == plain | {"wrench"}
    assert modelled("solver.tracking=implicit") == plain | {"rho"}


def test_keys_that_the_law_does_not_use_are_named():
    text = describe(reference_scene("testbench_psi30", "friction.viscosity=2.0").config).text
    assert "not used by this scene: friction.viscosity" in text
