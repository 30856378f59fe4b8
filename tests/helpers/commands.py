"""The command as tests call it, and the scene that most of them hand to it."""

from click.testing import CliRunner, Result
from scenes import REFERENCE

from omnisim.scene.scene import load
from omnisim_cli.main import cli

SCENE = str(REFERENCE / "testbench_psi0.toml")
TIPS = load(  # the text of a machine that cannot begin: its trajectory has no rows
    "kiwi",
    (
        "friction={law='viscous', viscosity=500.0}",
        "initial.velocity=[1.0, 0.0]",
        "chassis.center_of_mass=[0.0, 0.0, 0.4]",
    ),
).text


def command(*arguments) -> Result:
    return CliRunner().invoke(cli, [str(argument) for argument in arguments], prog_name="omnisim")


def settings(*overrides: str) -> list[str]:
    return [part for override in overrides for part in ("--set", override)]


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def refused(result, *parts, code=2):
    """One line that has all the parts, an exit code, and nothing on stdout."""
    assert (result.exit_code, result.stdout) == (code, ""), result.output
    line = result.stderr.splitlines()[-1]
    assert line.startswith("Error: ") and result.stderr.count("Error: ") == 1, result.stderr
    for part in parts:
        assert part in line, line
    return line
