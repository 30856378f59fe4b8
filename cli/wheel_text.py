"""What `omnisim wheel` prints of a wheel type: dimensions, profile, room, and how it rolls."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnisim.base.formatting import aligned, columns

if TYPE_CHECKING:
    from omnisim.scene.rollers import Rolling
    from omnisim.scene.wheel_schema import WheelType

STATIONS = 17  # of the profile
ROUND = 1e-9  # of the rolling radius: what heaves by less is round


def about(name: str, kind: WheelType, load: float) -> str:
    """load: of a wheel of its scene, N; 0: not known."""
    from omnisim.scene.rollers import rolling

    found = rolling(kind)
    sections = {
        f"wheel type '{name}'": aligned(dimensions(kind, found), indent="  "),
        "profile of a roller: u along its axis from the middle, r from its axis": profile_table(kind),
        "room": aligned(room(kind), indent="  "),
    }
    if kind.profile.kind == "exact":
        sections["rolling straight, by the shape of the rollers"] = ripple_table(kind)
    if not is_round(found):
        sections["rolling straight, upright"] = aligned(ripple(kind, found, load), indent="  ")
    return "\n\n".join(f"{heading}\n{body}" for heading, body in sections.items())


def is_round(found: Rolling) -> bool:
    return found.highest - found.lowest < ROUND * found.highest


def dimensions(kind: WheelType, found: Rolling) -> dict[str, str]:
    from omnisim.scene.rollers import drawn, roller_solid, thickest

    body = roller_solid(kind)
    roller = kind.roller
    density = roller.mass / body.volume
    u, r = drawn(kind, STATIONS)
    in_rows = f" in rows at {', '.join(mm(row.offset) for row in kind.rows)}" if len(kind.rows) > 1 else ""
    radius = f"{mm(kind.radius)}, for the controller: {kind.radius:g} m at every angle"
    if not is_round(found):
        radius = f"{mm(found.mean)} on average, for the controller; {mm(found.lowest)} to {mm(found.highest)}"
    return {
        "rolling radius": radius,
        "rollers": f"{kind.rollers}{in_rows}, axes at {mm(kind.roller_distance)}, angle {kind.roller_angle_deg:g} deg",
        "roller length": mm(u[-1] - u[0]),
        "roller diameter": f"{mm(2.0 * thickest(kind))} amid, {mm(2.0 * r[-1])} at the tips",
        "roller volume": f"{body.volume * 1e6:.5g} cm^3; {roller.mass:g} kg is {density:.4g} kg/m^3",
        "roller inertia": f"{roller.inertia_axial:.4g} kg m^2 about its axis, {roller.inertia_transverse:.4g} across; "
        f"of a solid {density * body.axial:.4g} and {density * body.transverse:.4g}",
    }


def profile_table(kind: WheelType) -> str:
    from omnisim.scene.rollers import drawn

    rows = [
        (f"{u * 1e3:10.4f}", f"{r * 1e3:9.4f}", f"{2e3 * r:12.4f}") for u, r in zip(*drawn(kind, STATIONS), strict=True)
    ]
    return columns([("     u, mm", "    r, mm", "diameter, mm"), *rows], indent="  ")


def room(kind: WheelType) -> dict[str, str]:
    from omnisim.scene.rollers import gap_between_rows, gap_in_row, hub_radius

    hub = hub_radius(kind)
    gaps = exact_room(kind) if kind.profile.kind == "exact" else {}
    if len(kind.rows) > 1 or not gaps:
        gaps["in a row"] = told(gap_in_row(kind)) or "neighbours overlap: the exact rollers do not fit"
    if len(kind.rows) > 1:
        gaps["between rows"] = told(gap_between_rows(kind)) or "rollers overlap: the rows are too near"
    return {
        **gaps,
        "hub": f"{mm(hub)} is the largest radius free of rollers" if hub > 0.0 else "rollers reach the axle",
        "": "Gaps are distances of surfaces: the widest slab that fits between two rollers, so never too large.",
    }


def exact_room(kind: WheelType) -> dict[str, str]:
    """How far tips are from points; of one row, how it would be with two."""
    from omnisim.cad.geometry import gap, of_type

    record = of_type(kind)
    margin = record.radius * record.cos_alpha - record.roller_distance
    found = {"tips": f"{mm(max(margin, 0.0))} until they are points (R cos alpha - R1)"}
    if len(kind.rows) == 1:
        found["neighbours"] = told(gap(record)) or "they overlap: in one row the exact rollers do not fit"
        found["next but one"] = told(gap(record, 2)) or "they overlap: in two rows the exact rollers do not fit"
    return found


def told(distance: float) -> str:
    return f"gap of {mm(distance)}" if distance > 0.0 else ""


def ripple(kind: WheelType, found: Rolling, load: float) -> dict[str, str]:
    """How it heaves, and the rubber that evens it out: one contact carries the load where the wheel is highest, two
    share it where it is lowest."""
    heave = found.highest - found.lowest
    depth = 2.0 * heave
    soft = f"; under {load:.3g} N of load {load / depth:.3g} N/m or softer" if load > 0.0 else ""
    facts = {
        "ripple": f"the centre heaves by {mm(heave)}, {100.0 * heave / found.mean:.3g} % of the rolling radius",
        "rubber": f"closes the gaps where it gives in by {mm(depth)} at the highest place{soft}",
    }
    if kind.contact is not None and load > 0.0:
        facts["that of the scene"] = f"gives in by {mm(load / kind.contact.stiffness)}"
    return facts


def ripple_table(kind: WheelType) -> str:
    from omnisim.cad.geometry import of_type, ripple, shapes

    record = of_type(kind)
    rows: list[tuple[str, ...]] = [
        ("roller", "height of the centre, peak to peak, mm", "rolling radius: mean", "lowest", "highest")
    ]
    for shape, reach in shapes(record).items():
        found = ripple(record, reach)
        relative = [
            f"{round((value / record.radius - 1.0) * 100.0, 3) + 0.0:+.3f} %"
            for value in (found.mean, found.lowest, found.highest)
        ]
        rows.append((shape, f"{(found.highest - found.lowest) * 1e3:.4f}", *relative))
    return columns(rows, indent="  ")


def mm(metres: float) -> str:
    return f"{metres * 1e3:.4f} mm"
