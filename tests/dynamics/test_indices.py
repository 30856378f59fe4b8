"""Tables of indices: an axle with two rows of rollers needs no other arithmetic than one with one row."""

import numpy as np
import pytest

from omnisim import Loop, load
from omnisim.base.records import blank
from omnisim.dynamics.indices import carries, roller_index, roller_of, row_index
from omnisim.dynamics.packing import pack
from omnisim.dynamics.parameters import WHEEL
from omnisim.dynamics.state import MODE, Stage
from omnisim.march.runge_kutta import evaluate

OFFSET = 0.01  # m, of the rows from the middle of their wheel
ROWS = [
    "wheel_types.omni.roller_count=9",
    f"wheel_types.omni.rows=[{{offset={OFFSET}}}, {{offset={-OFFSET}, phase_deg=20.0}}]",
]


@pytest.mark.short
def test_the_contact_of_a_roller_stands_on_its_row():
    """To rounding; and two neighbours stand on different rows."""
    loop = Loop(load("kiwi", [*ROWS, "time.end=0.005", "time.output_interval=0.005"]))
    loop.march(1)
    run, parameters = loop.run, loop.parameters
    evaluate(parameters, Stage(run.mode, 0, 0.0, run.y, run.slopes[0], run.monitors, True))
    for w, wheel in enumerate(parameters.wheels):
        offset = parameters.roller_rows.offset[run.mode[w].row[0]]
        assert offset == (OFFSET if run.mode[w].roller % 2 == 0 else -OFFSET)
        contact = parameters.workspace.contacts[wheel.contacts]
        q = wheel.phase + 2.0 * wheel.alpha * run.mode[w].roller - run.y[3 + w]
        middle = wheel.roller_distance * np.tan(q) * wheel.tan_psi
        assert contact.l - middle == pytest.approx(offset, abs=1e-15)
        assert row_index(wheel, run.mode[w].roller) != row_index(wheel, run.mode[w].roller - 1)


@pytest.mark.short
def test_a_machine_free_in_space_counts_its_rollers_as_an_upright_one_does():
    """Rows out of order, one of them turned by whole pitches: roller i is at the same azimuth, on the same row."""
    rows = "[{offset=-0.02, phase_deg=7.0}, {offset=0.02, phase_deg=107.0}, {offset=0.0, phase_deg=-33.0}]"
    scene = ["wheel_types.omni.roller_count=6", f"wheel_types.omni.rows={rows}", "friction.law=coulomb"]
    rubber = ["scene.upright=free", "wheel_types.omni.contact={stiffness=1e5}"]
    upright, free = (pack(load("kiwi", [*scene, *more]).config) for more in ([], rubber))
    for w, wheel in enumerate(upright.wheels):
        own = upright.roller_rows[wheel.row : wheel.row + wheel.rows]
        angle = wheel.phase + 2.0 * wheel.alpha * np.arange(18)
        places = np.array([np.cos(angle), np.sin(angle), np.tile(own.offset, 6)])
        np.testing.assert_allclose(upright.sector[w, 2], places[2], atol=0.0)
        np.testing.assert_allclose(free.space.disk[w], places, atol=1e-15)


def test_two_rows_move_alike_in_both_formulations():
    """Bodies that stand apart along the axle, against one body with their inertia: within 1.3e-14 m and 2.4e-12 N, when
    the loads differ by 0.6 N from those on one row; the contacts of two wheels pass from row to row."""
    at_once = ["time.end=0.4", "time.output_interval=0.005"]
    reduced, multibody = (
        Loop(load("kiwi", [*ROWS, *at_once, f"solver.formulation={name}"])) for name in ("reduced", "multibody")
    )
    for loop in (reduced, multibody):
        loop.march()
    one_row, reduced, multibody = Loop(load("kiwi", at_once)), reduced.trajectory(), multibody.trajectory()
    one_row.march()
    loads, on_one = "wheels/left/normal_force", one_row.trajectory()
    assert np.abs(reduced["body/position"] - multibody["body/position"]).max() < 1e-13
    assert np.abs(reduced[loads] - multibody[loads]).max() < 1e-10
    assert np.abs(reduced[loads] - on_one[loads]).max() > 0.1
    assert (reduced["events/kind"] == "exchange").sum() == 2
    assert np.abs(reduced["energy/balance"]).max() < 1e-11  # 2.7e-12 J


@pytest.mark.short
@pytest.mark.parametrize("roller", [-7, -1, 0, 5, 13])
def test_a_contact_names_one_roller_of_its_axle(roller):
    wheel, mode = blank(WHEEL, 1)[0], blank(MODE, 1)[0]
    wheel.rollers, wheel.row, wheel.rows, mode.roller = 6, 0, 2, roller
    for side in range(2):
        carried = [i for i in range(6) if carries(wheel, mode, side, i)]
        assert carried == [roller_index(wheel, roller_of(mode, side))] == [(roller - side) % 6]
