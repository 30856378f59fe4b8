"""Draws docs/pages/pictures/picture.png for README and site: python -m docs.picture (needs the extra `docs`)."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection

import omnisim
from omnisim.base.methods import TABLEAUX
from omnisim.contact.roller_profile import axial_coordinate, profile_radius
from omnisim.dynamics.packing import pack

HERE = Path(__file__).parent
INK, WARM, COOL = "#1f2933", "#d1495b", "#00798c"


def roller_surface(wheel, q):
    """Quads of a roller's surface at azimuth q, (m, 4, 3) in axes h, k, n."""
    parameter = np.linspace(-wheel.alpha, wheel.alpha, 25)
    angle = np.linspace(0.0, 2.0 * np.pi, 49)
    u = np.array([axial_coordinate(wheel, p) for p in parameter])[:, None, None]
    r = np.array([profile_radius(wheel, p) for p in parameter])[:, None, None]
    d = np.array([np.sin(q), 0.0, -np.cos(q)])
    t = np.array([-np.cos(q), 0.0, -np.sin(q)])
    axis = wheel.cos_psi * t + wheel.sin_psi * np.array([0.0, 1.0, 0.0])
    across = np.cross(axis, d)
    ring = np.cos(angle)[None, :, None] * d + np.sin(angle)[None, :, None] * across
    points = wheel.roller_distance * d + u * axis + r * ring
    centres = wheel.roller_distance * d + u[[0, -1]] * axis + 0.0 * ring
    points = np.concatenate([centres[:1], points, centres[1:]])  # with the end discs
    quads = np.stack([points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]], axis=2)
    return quads.reshape(-1, 4, 3)


def draw_wheel(axes, scene, view):
    """The wheel with its exact rollers, painted from back to front; view: side (along k) or front (along h)."""
    wheel = pack(scene.config).wheels[0]
    direction, columns = {"side": (np.array([0, -1.0, 0]), (0, 2)), "front": (np.array([1.0, 0, 0]), (1, 2))}[view]
    quads, shades = [], []
    for i in range(wheel.rollers):
        q = 2.0 * wheel.alpha * i
        surface = roller_surface(wheel, q)
        normal = np.cross(surface[:, 2] - surface[:, 0], surface[:, 3] - surface[:, 1])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True) + 1e-300
        light = np.array([0.3, -0.5, 0.8]) if view == "side" else np.array([0.5, -0.3, 0.8])
        quads.append(surface)
        shades.append(0.35 + 0.6 * np.abs(normal @ (light / np.linalg.norm(light))))
    quads, shades = np.concatenate(quads), np.concatenate(shades)
    order = np.argsort(quads.mean(axis=1) @ direction)
    colours = plt.cm.bone(0.15 + 0.75 * shades[order])
    axes.add_collection(PolyCollection(quads[order][:, :, columns], facecolors=colours, edgecolors=colours, lw=0.3))
    radius = wheel.radius
    axes.axhline(-radius, color=INK, lw=1.5)
    if view == "side":
        axes.add_patch(plt.Circle((0, 0), 0.62 * wheel.roller_distance, color="#9aa5b1", zorder=0))
        axes.add_patch(plt.Circle((0, 0), radius, fill=False, color=WARM, lw=1.2, ls=(0, (4, 3))))
        axes.plot(0, -radius, "o", color=WARM, ms=5)
    axes.set_xlim(-1.25 * radius, 1.25 * radius)
    axes.set_ylim(-1.2 * radius, 1.2 * radius)
    axes.set_aspect("equal")
    axes.axis("off")


def draw_path(axes, run):
    """The path of the wheel centre with its heading, exchanges marked."""
    x, y = run["body/position"][:, 0], run["body/position"][:, 1]
    axes.plot(x, y, color=INK, lw=1.5)
    step = max(len(x) // 16, 1)
    yaw = run["body/yaw"][::step]
    axes.quiver(x[::step], y[::step], np.cos(yaw), np.sin(yaw), color=COOL, angles="xy", scale=22, width=0.006)
    at = [np.interp(run["events/time"], run.time, values) for values in (x, y)]
    axes.plot(*at, "o", color=WARM, ms=4, label="the next roller takes over")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x / m")
    axes.set_ylabel("y / m")
    axes.legend(frameon=False, fontsize=8)
    axes.set_title("sliding, yawing, rollers spinning up", fontsize=10)


def draw_convergence(axes):
    """Error of the final position against speed, for every method."""
    quiet = ["time.output_interval=2.0"]
    exact = omnisim.simulate(omnisim.load("six_rollers", [*quiet, "solver.method=dopri5", "time.step=2.5e-5"]))
    for (name, colour), marker in zip({"heun": "#8d99ae", "rk4": COOL, "dopri5": WARM}.items(), "s^o", strict=True):
        errors, speeds = [], []
        for step in (1.25e-3, 6.25e-4, 3.125e-4, 1.5625e-4) if name == "dopri5" else (1e-3, 5e-4, 2e-4, 1e-4, 5e-5):
            runs = [
                omnisim.simulate(omnisim.load("six_rollers", [*quiet, f"solver.method={name}", f"time.step={step}"]))
                for _ in range(5)
            ]
            errors.append(np.linalg.norm(runs[0]["body/position"][-1] - exact["body/position"][-1]))
            speeds.append(2.0 / np.median([run.attributes["wall_time"] for run in runs]))
        label = f"{name} (order {TABLEAUX[name].order})"
        axes.loglog(speeds, errors, marker + "-", color=colour, ms=4, lw=1.2, label=label)
    axes.set_xlabel("times real time")
    axes.set_ylabel("error of position after 2 s / m")
    axes.legend(frameon=False, fontsize=8)
    axes.grid(True, which="major", lw=0.3)
    ticks = (200, 500, 1000, 2000, 5000)
    axes.set_xticks(ticks, [str(tick) for tick in ticks])
    axes.minorticks_off()
    axes.set_title("speed against error, 15 roller exchanges", fontsize=10)


def main():
    figure, (side, front, path, errors) = plt.subplots(
        1, 4, figsize=(14, 3.6), width_ratios=[1, 0.9, 1.3, 1.3], constrained_layout=True
    )
    nine = ["wheel_types.mecanum.roller_count=9", "wheel_types.mecanum.roller_distance=0.16"]
    scene = omnisim.load("thirty_two_rollers", nine)
    draw_wheel(side, scene, "side")
    draw_wheel(front, scene, "front")
    side.set_title("real rollers, exact profile", fontsize=10)
    front.set_title("nine rollers at 45 deg", fontsize=10)
    draw_path(path, omnisim.simulate(omnisim.load("six_rollers", ["time.step=1e-4"])))
    draw_convergence(errors)
    figure.savefig(HERE / "pages/pictures/picture.png", dpi=130)


if __name__ == "__main__":
    main()
