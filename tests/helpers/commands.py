"""The command as tests call it, and the scene that most of them hand to it."""

from click.testing import CliRunner, Result
from scenes import REFERENCE

from omnisim_cli.main import cli

SCENE = str(REFERENCE / "testbench_psi0.toml")


def command(*arguments) -> Result:
    return CliRunner().invoke(cli, [str(argument) for argument in arguments], prog_name="omnisim")


def settings(*overrides: str) -> list[str]:
    return [part for override in overrides for part in ("--set", override)]
