"""A wheel as a workshop sees it: side view, front view, and a roller with its dimensions in millimetres."""

import math
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon, Rectangle

from omnisim.base.files import write_whole
from omnisim.cad.geometry import roller_frames
from omnisim.scene.rollers import (
    drawn,
    farthest,
    gap_between_rows,
    gap_in_row,
    half_width,
    hub_radius,
    reach,
    rolling,
    thickest,
)
from omnisim.scene.wheel_schema import WheelType

STATIONS, CURVE = 17, 181  # of the table, of a drawn outline
MOST_STATIONS = 40  # of the table
PAPER = (11.7, 8.3)  # inches: A4
EDGE, RUBBER, METAL = "0.15", "#c3d4e4", "#f1f1f1"
THIN: dict[str, Any] = {"color": "0.35", "linewidth": 0.6}
AXIS_LINE = THIN | {"linestyle": (0, (14, 3, 2, 3))}
MM = 1e3
ROUNDING = 1e-12  # less of a direction is across an axis: there the whole end disc is farthest
RIGHT_SIDE = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # rows: what is drawn to the right, and up
AHEAD = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])


def draw(path: Path, name: str, kind: WheelType) -> None:
    """Write a drawing by its suffix, .png, .svg or .pdf, whole or not at all. Raises OSError."""
    figure = Figure(figsize=PAPER, layout="constrained")
    grid = figure.add_gridspec(2, 3, width_ratios=(1.3, 0.8, 0.7), height_ratios=(1.3, 1.0))
    side, front, table = (figure.add_subplot(grid[0, column]) for column in range(3))
    roller = figure.add_subplot(grid[1, :])
    side_view(side, kind)
    front_view(front, kind)
    profile_table(table, kind)
    roller_view(roller, kind)
    for axes in (side, front, roller):
        axes.set_aspect("equal")
        axes.margins(0.03)
    for axes in (side, front, table, roller):
        axes.set_axis_off()
    radius = f"rolling radius for the controller {rolling(kind).mean * MM:g} mm"
    what = f"{kind.rollers} rollers in {counted_rows(kind)} at {kind.roller_angle_deg:g} deg"
    figure.suptitle(f"Wheel type '{name}': {what}, {radius}. Dimensions in mm.", fontsize=11)
    image = BytesIO()
    suffix = path.suffix.lower()
    with rc_context({"svg.hashsalt": name}):
        figure.savefig(image, format=suffix[1:], dpi=160, metadata={"Date": None} if suffix == ".svg" else None)
    write_whole({path: image.getvalue()}, overwrite=True)


# --- views ----------------------------------------------------------------------------------------


def side_view(axes: Axes, kind: WheelType) -> None:
    """From the right: the wheel rolls to the right."""
    reach, distance = rolling(kind).highest * MM, kind.roller_distance * MM
    axes.add_patch(Circle((0.0, 0.0), hub_radius(kind) * MM, facecolor=METAL, edgecolor=EDGE, linewidth=0.8))
    rollers(axes, kind, RIGHT_SIDE, alpha=0.75)
    for radius in (reach, distance):
        axes.add_patch(Circle((0.0, 0.0), radius, fill=False, zorder=4, **AXIS_LINE))
    symmetry(axes, 1.08 * reach, 1.08 * reach)
    dimension(axes, (-reach, 0.0), (reach, 0.0), (0.0, -1.15 * reach), f"\N{DIAMETER SIGN} {2.0 * reach:.2f}")
    up = -0.25 * math.pi
    rim = (distance * math.cos(up), distance * math.sin(up))
    axes.annotate("", rim, (0.0, 0.0), arrowprops={"arrowstyle": "->", "shrinkA": 0, "shrinkB": 0, **THIN}, zorder=5)
    label(axes, 0.5 * rim[0], 0.5 * rim[1], f"R {distance:.2f}", 45.0 - 90.0)
    room = min(gap_in_row(kind), gap_between_rows(kind)) * MM
    told = f"gaps of {room:.2f} between rollers" if room > 0.0 else f"rollers overlap in {counted_rows(kind)}"
    axes.set_title(f"side; {told}", fontsize=9)


def front_view(axes: Axes, kind: WheelType) -> None:
    """From ahead, the left of the wheel to the right; farther rollers stand behind nearer ones."""
    height = rolling(kind).highest * MM
    sine = np.array([math.sin(math.radians(kind.roller_angle_deg))])
    half = (float(max(reach(kind, sine)[0], reach(kind, -sine)[0])) + max(abs(row.offset) for row in kind.rows)) * MM
    hub, width = hub_radius(kind) * MM, half_width(kind) * MM
    if hub > 0.0:
        axes.add_patch(
            Rectangle((-width, -hub), 2.0 * width, 2.0 * hub, facecolor=METAL, edgecolor=EDGE, linewidth=0.8)
        )
    rollers(axes, kind, AHEAD)
    symmetry(axes, 1.25 * half, 1.08 * height)
    dimension(axes, (-half, 0.0), (half, 0.0), (0.0, -1.15 * height), f"{2.0 * half:.2f}")
    axes.set_title("front", fontsize=9)


def roller_view(axes: Axes, kind: WheelType) -> None:
    """A roller along its axis, lengths from its middle."""
    u, r = (MM * values for values in drawn(kind, CURVE))
    first, last = u[0], u[-1]
    middle, tip = thickest(kind) * MM, r[-1]
    outline = np.column_stack([np.append(u, u[::-1]), np.append(r, -r[::-1])])
    axes.add_patch(Polygon(outline, facecolor=RUBBER, edgecolor=EDGE, linewidth=1.0))
    symmetry(axes, 1.12 * last, 1.15 * middle)
    dimension(axes, (first, -r[0]), (last, -tip), (0.0, -1.3 * middle), f"{last - first:.3f}")
    dimension(axes, (0.0, -middle), (0.0, middle), (-1.22 * last, 0.0), f"\N{DIAMETER SIGN} {2.0 * middle:.3f}")
    dimension(axes, (last, -tip), (last, tip), (1.22 * last, 0.0), f"\N{DIAMETER SIGN} {2.0 * tip:.3f}")
    what = "exact profile" if kind.profile.kind == "exact" else kind.profile.kind
    axes.set_title(f"roller, {what} by the table", fontsize=9)


def counted_rows(kind: WheelType) -> str:
    return "one row" if len(kind.rows) == 1 else f"{len(kind.rows)} rows"


def profile_table(axes: Axes, kind: WheelType) -> None:
    """One half of a roller; both of one that need not be symmetric."""
    whole = kind.profile.kind == "points"
    u, r = drawn(kind, 2 * STATIONS - 1)
    told = [(x, y) for x, y in zip(u, r, strict=True) if whole or x >= -ROUNDING]
    lines = [f"{x * MM:9.4f}  {2.0 * y * MM:9.4f}" for x, y in told[:: 1 + len(told) // MOST_STATIONS]]
    text = "\n".join(["from middle, \N{DIAMETER SIGN}", *lines])
    axes.text(0.5, 0.5, text, family="monospace", fontsize=8, ha="center", va="center", transform=axes.transAxes)


# --- lines ----------------------------------------------------------------------------------------


def rollers(axes: Axes, kind: WheelType, view: np.ndarray, alpha: float = 1.0) -> None:
    """All rollers from afar; the last ones drawn are nearest."""
    nearness = np.cross(view[0], view[1])
    for centre, axis in sorted(roller_frames(kind), key=lambda frame: frame[0] @ nearness):
        for points in outlines(kind, axis, view):
            place = MM * (points + view @ centre)
            axes.add_patch(Polygon(place, facecolor=RUBBER, edgecolor=EDGE, linewidth=0.8, alpha=alpha))


def outlines(kind: WheelType, axis: np.ndarray, view: np.ndarray) -> list[np.ndarray]:
    """Contours (CURVE, 2) of the convex solids of a roller about its centre, m: of each its farthest point in every
    direction of the paper."""
    turns = np.linspace(0.0, 2.0 * np.pi, CURVE)
    directions = np.column_stack([np.cos(turns), np.sin(turns)]) @ view
    sines = np.clip(directions @ axis, -1.0, 1.0)
    across = directions - np.outer(sines, axis)
    sizes = np.linalg.norm(across, axis=1)
    across /= np.where(sizes > ROUNDING, sizes, np.inf)[:, None]
    return [(np.outer(u, axis) + r[:, None] * across) @ view.T for u, r in farthest(kind, sines)]


def symmetry(axes: Axes, x: float, y: float) -> None:
    """Lines of symmetry."""
    axes.plot([-x, x], [0.0, 0.0], zorder=4, **AXIS_LINE)
    axes.plot([0.0, 0.0], [-y, y], zorder=4, **AXIS_LINE)


def dimension(axes: Axes, start: tuple, end: tuple, place: tuple, text: str) -> None:
    """A dimension between two points, its line level or upright through `place`."""
    upright = start[0] == end[0]
    ends = [(place[0], point[1]) if upright else (point[0], place[1]) for point in (start, end)]
    for point, arrow in zip((start, end), ends, strict=True):
        axes.plot(*zip(point, arrow, strict=True), zorder=3, **THIN)
    axes.annotate("", ends[0], ends[1], arrowprops={"arrowstyle": "<->", "shrinkA": 0, "shrinkB": 0, **THIN})
    x, y = np.mean(ends, axis=0)
    label(axes, x, y, text, 90.0 if upright else 0.0)


def label(axes: Axes, x: float, y: float, text: str, rotation: float) -> None:
    paper = {"boxstyle": "square,pad=0.15", "facecolor": "white", "edgecolor": "none"}
    axes.text(x, y, text, fontsize=8, ha="center", va="center", rotation=rotation, bbox=paper, zorder=6)
