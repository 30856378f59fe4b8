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
from omnisim.cad.geometry import hub_radius, of_type, profile, roller_frames, support
from omnisim.contact.roller_profile import axial_coordinate, profile_radius, support_parameter
from omnisim.scene.schema import WheelType
from omnisim.scene.solids import gap_between_rows, gap_in_row, half_width

STATIONS, CURVE = 17, 181  # of the table, of a drawn outline
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
    wheel = of_type(kind)
    figure = Figure(figsize=PAPER, layout="constrained")
    grid = figure.add_gridspec(2, 3, width_ratios=(1.3, 0.8, 0.7), height_ratios=(1.3, 1.0))
    side, front, table = (figure.add_subplot(grid[0, column]) for column in range(3))
    roller = figure.add_subplot(grid[1, :])
    side_view(side, kind, wheel)
    front_view(front, kind, wheel)
    profile_table(table, wheel)
    roller_view(roller, wheel)
    for axes in (side, front, roller):
        axes.set_aspect("equal")
        axes.margins(0.03)
    for axes in (side, front, table, roller):
        axes.set_axis_off()
    radius = f"rolling radius for the controller {kind.radius * MM:g} mm"
    what = f"{kind.rollers} rollers in {counted_rows(kind)} at {kind.roller_angle_deg:g} deg"
    figure.suptitle(f"Wheel type '{name}': {what}, {radius}. Dimensions in mm.", fontsize=11)
    image = BytesIO()
    suffix = path.suffix.lower()
    with rc_context({"svg.hashsalt": name}):
        figure.savefig(image, format=suffix[1:], dpi=160, metadata={"Date": None} if suffix == ".svg" else None)
    write_whole({path: image.getvalue()}, overwrite=True)


# --- views ----------------------------------------------------------------------------------------


def side_view(axes: Axes, kind: WheelType, wheel: np.record) -> None:
    """From the right: the wheel rolls to the right."""
    reach, distance = kind.radius * MM, kind.roller_distance * MM
    axes.add_patch(Circle((0.0, 0.0), hub_radius(wheel) * MM, facecolor=METAL, edgecolor=EDGE, linewidth=0.8))
    rollers(axes, kind, wheel, RIGHT_SIDE, alpha=0.75)
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


def front_view(axes: Axes, kind: WheelType, wheel: np.record) -> None:
    """From ahead, the left of the wheel to the right; farther rollers stand behind nearer ones."""
    reach = kind.radius * MM
    half = (float(support(wheel, abs(wheel.sin_psi))) + max(abs(row.offset) for row in kind.rows)) * MM
    hub, width = hub_radius(wheel) * MM, half_width(kind) * MM
    if hub > 0.0:
        axes.add_patch(
            Rectangle((-width, -hub), 2.0 * width, 2.0 * hub, facecolor=METAL, edgecolor=EDGE, linewidth=0.8)
        )
    rollers(axes, kind, wheel, AHEAD)
    symmetry(axes, 1.25 * half, 1.08 * reach)
    dimension(axes, (-half, 0.0), (half, 0.0), (0.0, -1.15 * reach), f"{2.0 * half:.2f}")
    axes.set_title("front", fontsize=9)


def roller_view(axes: Axes, wheel: np.record) -> None:
    """A roller along its axis, lengths from its middle."""
    u, r = (MM * values for values in profile(wheel, np.linspace(-wheel.alpha, wheel.alpha, CURVE)))
    half = u[-1]
    middle = r[CURVE // 2]
    tip = r[-1]
    outline = np.column_stack([np.append(u, u[::-1]), np.append(r, -r[::-1])])
    axes.add_patch(Polygon(outline, facecolor=RUBBER, edgecolor=EDGE, linewidth=1.0))
    symmetry(axes, 1.12 * half, 1.15 * middle)
    dimension(axes, (-half, -tip), (half, -tip), (0.0, -1.3 * middle), f"{2.0 * half:.3f}")
    dimension(axes, (0.0, -middle), (0.0, middle), (-1.22 * half, 0.0), f"\N{DIAMETER SIGN} {2.0 * middle:.3f}")
    dimension(axes, (half, -tip), (half, tip), (1.22 * half, 0.0), f"\N{DIAMETER SIGN} {2.0 * tip:.3f}")
    axes.set_title("roller, exact profile by the table", fontsize=9)


def counted_rows(kind: WheelType) -> str:
    return "one row" if len(kind.rows) == 1 else f"{len(kind.rows)} rows"


def profile_table(axes: Axes, wheel: np.record) -> None:
    u, r = profile(wheel, np.linspace(0.0, wheel.alpha, STATIONS))
    lines = [f"{x * MM:9.4f}  {2.0 * y * MM:9.4f}" for x, y in zip(u, r, strict=True)]
    text = "\n".join(["from middle, \N{DIAMETER SIGN}", *lines])
    axes.text(0.5, 0.5, text, family="monospace", fontsize=8, ha="center", va="center", transform=axes.transAxes)


# --- lines ----------------------------------------------------------------------------------------


def rollers(axes: Axes, kind: WheelType, wheel: np.record, view: np.ndarray, alpha: float = 1.0) -> None:
    """All rollers from afar; the last ones drawn are nearest."""
    nearness = np.cross(view[0], view[1])
    for centre, axis in sorted(roller_frames(kind), key=lambda frame: frame[0] @ nearness):
        points = MM * outline(wheel, centre, axis, view)
        axes.add_patch(Polygon(points, facecolor=RUBBER, edgecolor=EDGE, linewidth=0.8, alpha=alpha))


def outline(wheel: np.record, centre: np.ndarray, axis: np.ndarray, view: np.ndarray) -> np.ndarray:
    """Contour (CURVE, 2) of a roller, m: its farthest point in every direction of the paper."""
    points = []
    for turn in np.linspace(0.0, 2.0 * np.pi, CURVE):
        direction = np.array([math.cos(turn), math.sin(turn)]) @ view
        sine = direction @ axis
        across = direction - sine * axis
        q = support_parameter(wheel, -sine)
        norm = np.linalg.norm(across)
        radius = profile_radius(wheel, q) / norm if norm > ROUNDING else 0.0
        points.append(view @ (centre + axial_coordinate(wheel, q) * axis + radius * across))
    return np.array(points)


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
