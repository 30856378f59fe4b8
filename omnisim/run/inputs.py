"""Inputs that are set while a march stands still: pieces of the tables that kernels read, and tables of a scene.

A piece begins where something is set, and holds it from then on; later pieces keep the rest of what the scene gives.
"""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from omnisim.dynamics.input_tables import WRENCH
from omnisim.dynamics.parameters import DRIVE_INPUT, YAW_TORQUE, Parameters
from omnisim.scene.scene import Scene
from omnisim.scene.schema import Config
from omnisim.scene.toml_text import MISSING, KeyPath, assign, rewrite

LEAST_ROOM = 64  # pieces


class Held(NamedTuple):
    """Pieces that the tables have (their arrays have room for more), and the channels that were set from outside."""

    pieces: int
    channels: frozenset[int] = frozenset()


def hold_inputs(
    parameters: Parameters, held: Held, piece: int, here: float, values: Mapping[int, float]
) -> tuple[Parameters, Held]:
    """Values of channels from the time `here` (s) on, where `piece` begins or would begin."""
    pieces = held.pieces
    if piece == pieces or parameters.starts[piece] > here:  # none begins here yet
        if pieces == len(parameters.starts):
            parameters = with_room(parameters)
        starts, inputs = parameters.starts, parameters.inputs
        if piece < pieces:
            starts[piece + 1 : pieces + 1] = starts[piece:pieces].copy()
            inputs[piece + 1 : pieces + 1] = inputs[piece:pieces].copy()
        starts[piece] = here
        inputs[piece] = inputs[piece - 1]
        inputs[piece, :, 0] += inputs[piece, :, 1] * (here - starts[piece - 1])
        pieces += 1
    for channel, value in values.items():
        parameters.inputs[piece:pieces, channel] = value, 0.0
    if not values.keys().isdisjoint(WRENCH):
        parameters.machine.pushed = 1
    return parameters, Held(pieces, held.channels | values.keys())


def with_room(parameters: Parameters) -> Parameters:
    """Room for as many pieces again; those that are not there yet never begin."""
    starts, inputs = parameters.starts, parameters.inputs
    more = max(LEAST_ROOM, len(starts))
    starts = np.concatenate([starts, np.full(more, np.inf)])
    inputs = np.concatenate([inputs, np.zeros((more, *inputs.shape[1:]))])
    return parameters._replace(starts=starts, inputs=inputs)


def with_tables(scene: Scene, parameters: Parameters, held: Held) -> Scene:
    """The scene with all that was set as tables, so that loading it repeats the run."""
    if not held.channels:
        return scene
    data = tomllib.loads(scene.text)
    edits = list(table_edits(scene.config, parameters, held).items())
    for path, value in edits:
        assign(data, path, value)
    return replace(scene, text=rewrite(scene.text, edits, data))


def table_edits(config: Config, parameters: Parameters, held: Held) -> dict[KeyPath, Any]:
    """What to set in a scene, by key."""
    edits: dict[KeyPath, Any] = {}
    driven = {channel - DRIVE_INPUT for channel in held.channels if channel >= DRIVE_INPUT}
    for w in sorted(driven):
        times, values = table(parameters, held, [DRIVE_INPUT + w])
        edits["wheels", w, "drive", "times"] = times
        edits["wheels", w, "drive", str(config.wheels[w].drive.given)] = [value for (value,) in values]
    if not held.channels.isdisjoint(WRENCH):
        times, values = table(parameters, held, WRENCH)
        edits["wrench", "times"] = times
        edits["wrench", "force"] = [vector[:YAW_TORQUE] for vector in values]
        edits["wrench", "yaw_torque"] = [vector[YAW_TORQUE] for vector in values]
    if config.command and all(w in driven for w, wheel in enumerate(config.wheels) if wheel.drive.follows_command):
        edits["command",] = MISSING  # nobody follows it any more
    return edits


def table(parameters: Parameters, held: Held, channels: Sequence[int]) -> tuple[list[float], list[list[float]]]:
    """Times and values of these channels, so far and as they would go on: two values at a jump, one where a line bends,
    none where nothing happens to them."""
    starts = parameters.starts[: held.pieces]
    lines = parameters.inputs[: held.pieces, channels]
    values, slopes = lines[..., 0], lines[..., 1]
    ends = values[:-1] + slopes[:-1] * np.diff(starts)[:, None]
    jumps = np.any(ends != values[1:], axis=1)
    bends = np.any(slopes[:-1] != slopes[1:], axis=1)
    knots = np.empty((2 * held.pieces - 1, len(channels)))
    knots[::2], knots[1::2] = values, ends
    kept = np.ones(len(knots), bool)
    kept[2::2] = jumps
    told = (np.diff(starts) == 0.0) & kept[:-1:2]  # a piece without length whose value stands there already
    kept[1::2] = (jumps | bends) & ~told
    return np.repeat(starts, 2)[1:][kept].tolist(), knots[kept].tolist()
