"""The rules of rollers' profiles: what each kind needs, and how it fits on its wheel."""

import math
from collections.abc import Callable, Iterator
from itertools import pairwise

from omnisim.scene.generatrix import number, numbers
from omnisim.scene.ground_schema import MOST_POINTS, MOST_STEPS, PROFILE_KEYS, PROFILE_OPTIONS, Profile
from omnisim.scene.problems import Problem, allowed_at
from omnisim.scene.schema import Config
from omnisim.scene.toml_text import KeyPath
from omnisim.scene.wheel_schema import WheelType

Found = Iterator[tuple[str | tuple[str, int], str]]  # key, or key and index, and what it must be


def profile_rules(config: Config) -> Iterator[Problem]:
    """Of machines free in space: keys, then values that do not go together, then how rollers stand on their wheel."""
    if config.upright != "free":
        return
    for name, kind in config.wheel_types.items():
        path = ("wheel_types", name, "profile")
        problems = [*key_rules(path, kind.profile)]
        if not problems:
            for key, allowed in SHAPE_RULES.get(kind.profile.kind, nothing)(kind.profile):
                problems.append(Problem((*path, *(key if isinstance(key, tuple) else (key,))), allowed))
        yield from problems or place_rules(path, kind)


def key_rules(path: KeyPath, profile: Profile) -> Iterator[Problem]:
    needed = PROFILE_KEYS[profile.kind]
    for key in needed:
        if key not in profile.model_fields_set:
            yield Problem((*path, key), f"missing; must be {allowed_at((*path, key))}")
    allowed = {"kind", *needed, *PROFILE_OPTIONS.get(profile.kind, ())}
    for key in sorted(profile.model_fields_set - allowed):
        yield Problem((*path, key), f"not a key of a profile with kind = '{profile.kind}'")
    if "radius" in needed and isinstance(profile.radius, tuple) != (profile.kind == "points"):
        one = "a list of finite numbers >= 0" if profile.kind == "points" else "a finite number > 0"
        yield Problem((*path, "radius"), f"must be {one} with kind = '{profile.kind}'")


# --- one roller -----------------------------------------------------------------------------------


def nothing(profile: Profile) -> Found:
    yield from ()


def arc_rules(profile: Profile) -> Found:
    if profile.curvature_radius < profile.half_length:
        yield "curvature_radius", f"must be at least half_length = {profile.half_length:g}"
        return
    end = (
        number(profile.radius)
        - profile.curvature_radius
        + math.sqrt(profile.curvature_radius**2 - profile.half_length**2)
    )
    if end < 0.0:
        yield "half_length", "too long: the arc meets the roller's axis before its end"


def cylinder_rules(profile: Profile) -> Found:
    for key in ("radius", "half_length"):
        if profile.edge_radius > getattr(profile, key):
            yield "edge_radius", f"must be at most {key} = {getattr(profile, key):g}"
            return


def capsule_rules(profile: Profile) -> Found:
    radius = number(profile.radius)
    if profile.half_length < radius:
        yield "half_length", f"must be at least radius = {radius:g}: it includes the half sphere at the end"


def cone_rules(profile: Profile) -> Found:
    radius = number(profile.radius)
    if profile.end_radius >= radius:
        yield "end_radius", f"must be less than radius = {radius:g}, that in the middle"


def stepped_rules(profile: Profile) -> Found:
    radii, lengths = profile.radii, profile.lengths
    if not 1 <= len(radii) <= MOST_STEPS:
        yield "radii", f"must be a list of 1 to {MOST_STEPS} finite numbers > 0"
    elif len(lengths) != len(radii):
        yield "lengths", f"must be as many as radii, {len(radii)}, not {len(lengths)}"
    for i, (inner, outer) in enumerate(pairwise(radii)):
        if outer >= inner:
            yield ("radii", i + 1), f"must be less than the radius before it, {inner:g}: steps go down to the end"


def points_rules(profile: Profile) -> Found:
    axial, radius = profile.axial, numbers(profile.radius)
    if not 3 <= len(axial) <= MOST_POINTS:
        yield "axial", f"must be a list of 3 to {MOST_POINTS} finite numbers, each greater than the last"
        return
    if len(radius) != len(axial):
        yield "radius", f"must be as many as axial, {len(axial)}, not {len(radius)}"
        return
    for i, (before, after) in enumerate(pairwise(axial)):
        if after <= before:
            yield ("axial", i + 1), f"must be greater than the one before it, {before:g}: points do not fold back"
            return
    if not axial[0] < 0.0 < axial[-1]:
        yield "axial", "must go from below 0 to above 0, the middle of the roller"
    points = list(zip(axial, radius, strict=True))
    for i, (a, b, c) in enumerate(zip(points, points[1:], points[2:], strict=False)):
        chord = a[1] + (c[1] - a[1]) * (b[0] - a[0]) / (c[0] - a[0])
        if b[1] <= chord * (1.0 + 1e-9):
            what = f"above {chord:.6g}, the line between its neighbours: the curve bulges; or leave this point out"
            yield ("radius", i + 1), f"must be {what}"


SHAPE_RULES: dict[str, Callable[[Profile], Found]] = {
    "arc": arc_rules,
    "cylinder": cylinder_rules,
    "capsule": capsule_rules,
    "cone": cone_rules,
    "stepped": stepped_rules,
    "points": points_rules,
}


# --- on its wheel ---------------------------------------------------------------------------------


def place_rules(path: KeyPath, kind: WheelType) -> Iterator[Problem]:
    """Rollers of a row are apart, and carry the wheel over the gaps between them; exact ones without gaps do both."""
    whole = kind.profile.kind == "exact" and kind.spread and kind.covered_deg is None
    if not whole:
        yield from [*room_rules(path, kind)] or drop_rules(path, kind)


def room_rules(path: KeyPath, kind: WheelType) -> Iterator[Problem]:
    """Of exact rollers that overlap there is a doubt only: a scene may have those of two rows in one plane."""
    # here: NumPy is slow to import, and few scenes need it
    from omnisim.scene.rollers import gap_between_rows, gap_in_row, thickest

    if kind.profile.kind == "exact":
        return
    if kind.roller.bore_radius >= thickest(kind):
        allowed = f"less than {thickest(kind):g}, the roller's own radius"
        yield Problem((*path[:-1], "roller", "bore_radius"), f"must be {allowed}")
    if thickest(kind) >= kind.roller_distance:
        what = f"{thickest(kind):g} m thick on a ring of {kind.roller_distance:g} m: rollers reach the axle"
        yield Problem((*path[:-1], "roller_distance"), what)
        return
    room = gap_in_row(kind)
    if room < 0.0:
        what = f"too wide for {kind.roller_count} in a row: neighbours overlap by {-room:.3g} m"
        yield Problem(path, f"{what}; expected a smaller roller, or fewer")
        return
    room = gap_between_rows(kind)
    if room < 0.0:
        yield Problem(
            (*path[:-1], "rows"), f"rollers of two rows overlap by {-room:.3g} m; expected offsets farther apart"
        )


def drop_rules(path: KeyPath, kind: WheelType) -> Iterator[Problem]:
    from omnisim.scene.rollers import rolling  # here as well

    hub = kind.disk.hub_radius
    lowest = rolling(kind).lowest if hub > 0.0 else math.inf
    if lowest <= hub:
        what = f"between two rollers the wheel drops to {lowest:.4g} m, onto its hub"
        yield Problem((*path[:-1], "disk", "hub_radius"), f"{what}; must be less than that, or rollers nearer")
