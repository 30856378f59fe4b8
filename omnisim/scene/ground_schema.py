"""The tables of a scene file that tell of the floor, and of what stands on it with rubber and springs."""

from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from omnisim.scene.values import Bumps, Name, NonNegative, Planar, Positive, Real, Slope, Spacing, Table, choice

# Which keys a profile needs, and which it may have beside them.
PROFILE_KEYS: dict[str, tuple[str, ...]] = {
    "exact": (),
    "arc": ("radius", "curvature_radius", "half_length"),
    "cylinder": ("radius", "half_length"),
    "capsule": ("radius", "half_length"),
    "sphere": ("radius",),
    "cone": ("radius", "end_radius", "half_length"),
    "stepped": ("radii", "lengths"),
    "points": ("axial", "radius"),
}
PROFILE_OPTIONS = {"cylinder": ("edge_radius",)}
MOST_STEPS, MOST_POINTS = 8, 20

if TYPE_CHECKING:  # to a type checker a word is a word
    ProfileKind = str
    About = str
else:
    ProfileKind = choice(*PROFILE_KEYS)
    About = choice("x", "y")


Radius = Annotated[
    Positive | tuple[NonNegative, ...],
    Field(description='a finite number > 0; of "points" a list of finite numbers >= 0'),
]
Steps = Annotated[tuple[Positive, ...], Field(description="a list of finite numbers > 0")]


class Grid(Table):
    """Heights (m) at nodes, in a CSV or .npy file beside the scene: rows along x, the first from `origin` [x, y] (m),
    nodes `spacing` [dx, dy] (m) apart. Between them lies a bicubic spline; beyond them the floor is level.

    A scene that is loaded keeps the heights themselves in the place of the file's name.
    """

    file: Annotated[str, Field(min_length=1, description="the name of a file of heights, CSV or .npy")]
    origin: Planar = (0.0, 0.0)
    spacing: Spacing


class Step(Table):
    """Up by `height` (m) across the line through `point` (m), towards direction_deg; the upper edge is rounded.

    height < 0: down. The line is always the foot of the step's face.
    """

    point: Planar
    direction_deg: Real
    height: Real
    edge_radius: Positive


class Floor(Table):
    """[floor]: a plane that rises by slope_deg (S) towards uphill_deg (U), the direction from the x axis of the floor;
    and what stands on it, for machines free in space: all of it adds up.

    The axes of the world are those of the floor, x and y in it, z normal to it: gravity is
    g (-sin S cos U, -sin S sin U, -cos S). A bump is height exp(-distance^2 / radius^2), a pit if height < 0 (m).
    """

    slope_deg: Slope = 0.0
    uphill_deg: Real = 0.0
    bumps: Bumps = ()
    grid: Grid | None = None
    steps: tuple[Step, ...] = ()

    @property
    def is_plane(self) -> bool:
        """Whether nothing stands on it."""
        return not self.bumps and self.grid is None and not self.steps


class Contact(Table):
    """Rubber between a roller and the floor: stiffness (N/m) and damping (N s/m). A machine free in space needs it."""

    stiffness: Positive
    damping: NonNegative = 0.0


class Row(Table):
    """A ring of roller_count rollers: its offset along the axle (m), and the turn of its roller 0 (deg).

    Rollers of a wheel are counted in order of azimuth, through all of its rows, from roller 0 of the first one on.
    """

    offset: Real = 0.0
    phase_deg: Real = 0.0


class Profile(Table):
    """The generatrix of a roller, |u| <= half_length (m) along its axis; lengths and radii in m.

    exact: the envelope that keeps an upright wheel round. arc, a barrel: r = radius - curvature_radius +
    sqrt(curvature_radius^2 - u^2). cylinder: its edges rounded by edge_radius. capsule: a cylinder between half spheres
    of its radius, which half_length includes. sphere. cone: from radius in the middle to end_radius at both ends.
    stepped: cylinders of these radii, ever smaller, with sharp edges; lengths from the middle to one end, the other
    half is the same. points: a smooth curve of arcs through measured points (axial, radius).
    """

    kind: ProfileKind = "exact"
    radius: Radius = 0.0
    curvature_radius: Positive = 0.0
    half_length: Positive = 0.0
    edge_radius: NonNegative = 0.0
    end_radius: NonNegative = 0.0
    radii: Steps = ()
    lengths: Steps = ()
    axial: Annotated[tuple[Real, ...], Field(description="a list of finite numbers, each greater than the last")] = ()


class Suspension(Table):
    """A hub that slides along chassis z by s, up: its mass (kg), isotropic inertia (kg m^2), and the spring on it,
    -(preload + stiffness s + damping s') in N, N/m and N s/m."""

    mass: Positive
    inertia: Positive
    stiffness: NonNegative
    damping: NonNegative = 0.0
    preload: Real = 0.0


class Rocker(Table):
    """[[axles]]: two wheels on one body that turns freely about a line of the chassis through `point` (m), along x or
    y."""

    name: Name
    wheels: Annotated[tuple[str, str], Field(description="the names of two wheels")]
    about: About
    point: Annotated[tuple[Real, Real, Real], Field(description="three finite numbers [x, y, z]")]
