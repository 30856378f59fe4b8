"""The types of wheels in a scene file: disk, rollers, rows, profile, rubber.

Masses and moments of inertia that a scene leaves out are 0 here only until estimates.py has made them of the shapes;
`model_fields_set` keeps what was given.
"""

import math
from typing import Annotated

from pydantic import Field

from omnisim.scene.ground_schema import Contact, Profile, Row
from omnisim.scene.values import Count, NonNegative, Positive, Table

SAME_DEG = 1e-9  # deg


class Disk(Table):
    """A wheel without its rollers: mass (kg), moments of inertia (kg m^2) about axle and diameter.

    Inertias that are left out are those of a cylinder about the axle: hub_radius (m) gives that about the axle, width
    (m) that about a diameter, which is half the other plus mass width^2 / 12. It may have a bore of bore_radius (m),
    and around each of its ends a plate of the same material, of plate_radius and plate_thickness (m).
    """

    mass: Positive
    inertia_axle: Positive = 0.0
    inertia_diameter: Positive = 0.0
    hub_radius: Positive = 0.0
    width: Positive = 0.0
    bore_radius: NonNegative = 0.0
    plate_radius: Positive = 0.0
    plate_thickness: Positive = 0.0


class Roller(Table):
    """One roller: mass (kg), moments of inertia (kg m^2) about its axis and across it.

    What is left out is that of a solid of its profile with a bore of bore_radius (m): mass, if there is a density
    (kg/m^3), and inertias.

    Friction of its bearing: viscosity (N m s), and a Coulomb torque (N m) that changes its sign over a rate (rad/s).

    Rolling resistance on the floor: a moment by load (m), which changes its sign over rolling_rate (rad/s).
    """

    mass: Positive = 0.0
    density: Positive = 0.0
    bore_radius: NonNegative = 0.0
    inertia_axial: Positive = 0.0
    inertia_transverse: Positive = 0.0
    bearing_viscosity: NonNegative = 0.0
    bearing_torque: NonNegative = 0.0
    bearing_rate: Positive = 0.1
    rolling_resistance: NonNegative = 0.0
    rolling_rate: Positive = 0.1

    @property
    def has_bearing_friction(self) -> bool:
        return self.bearing_viscosity > 0.0 or self.bearing_torque > 0.0

    @property
    def has_rolling_resistance(self) -> bool:
        return self.rolling_resistance > 0.0


class WheelType(Table):
    """[wheel_types.NAME]: radius R and roller distance R1 (m), N_r, psi (deg), disk and roller.

    Also rows of rollers along the axle, and half the angle over which a roller of the exact profile is cut (deg); of a
    machine free in space rubber and profile. What is left out is taken over from the packaged wheel that `from` names.
    """

    taken_from: Annotated[str | None, Field(alias="from", description="the name of a packaged wheel")] = None
    radius: Positive
    roller_distance: Positive
    roller_count: Count
    roller_angle_deg: Annotated[float, Field(gt=-90, lt=90, description="a finite number between -90 and 90")]
    disk: Disk
    roller: Roller
    contact: Contact | None = None
    rows: Annotated[tuple[Row, ...], Field(min_length=1, description="a list of one or more rows of rollers")] = (
        Row(),
    )
    profile: Profile = Profile()
    covered_deg: Annotated[float | None, Field(gt=0, lt=90, description="a finite number between 0 and 90")] = None

    @property
    def rollers(self) -> int:
        """All of its rollers, in all rows."""
        return self.roller_count * len(self.rows)

    @property
    def rings(self) -> tuple[Row, ...]:
        """Its rows in order of azimuth from roller 0 of the first one on, each with the phase of its roller that comes
        next there: roller i of the wheel is on ring i % rows."""
        if len(self.rows) == 1:
            return self.rows
        pitch = 360.0 / self.roller_count
        start = self.rows[0].phase_deg
        turned = [(row.phase_deg - start) % pitch for row in self.rows]
        behind = [turn if turn < pitch - SAME_DEG else 0.0 for turn in turned]
        ahead = sorted(zip(behind, range(len(self.rows)), strict=True))
        return tuple(Row(offset=self.rows[i].offset, phase_deg=start + turn) for turn, i in ahead)

    @property
    def middle(self) -> float:
        """Of its rows along the axle, from the wheel's centre, m."""
        return math.fsum(row.offset for row in self.rows) / len(self.rows)

    @property
    def spread(self) -> bool:
        """Whether the rollers of all rows together are spread evenly around the turn."""
        share = 360.0 / self.rollers
        start = self.rows[0].phase_deg
        return all(abs(row.phase_deg - start - i * share) < SAME_DEG for i, row in enumerate(self.rings))

    @property
    def covered(self) -> float:
        """Half the angle over which a roller of the exact profile is cut, rad: its share of the turn, if all rollers
        are spread evenly around it."""
        share = math.pi / (self.rollers if self.spread else self.roller_count)
        given = self.covered_deg
        return share if given is None or abs(given - math.degrees(share)) < SAME_DEG else math.radians(given)
