"""Draws the sketches of the pages, docs/pages/pictures/NAME.svg: python -m docs.sketches

A sketch is a function that fills a Sheet, in units of its own with y up; shapes follow from the formulas they explain.
"""
# ruff: noqa: RUF001  (Greek letters are meant)

import math
from collections.abc import Callable
from pathlib import Path

from docs.ground_sketches import common_normals, rigid_limit, slope
from docs.sketch_sheet import COOL, DASHED, INK, PALE, WARM, Sheet

FOLDER = Path(__file__).parent / "pages/pictures"
Points = list[tuple[float, float]]


def profile(radius: float, distance: float, count: int, psi: float) -> Points:
    """Generatrix of a roller, (u, r) for q from -alpha to alpha."""
    alpha, c = math.pi / count, math.cos(psi)
    points = []
    for i in range(-20, 21):
        q = alpha * i / 20
        drop = radius - distance / math.cos(q)
        axial = distance * math.tan(q) / c + drop * c * math.sin(q)
        points.append((axial, drop * math.sqrt(1 - (c * math.sin(q)) ** 2)))
    return points


def turned(points: Points, angle: float, x: float = 0.0, y: float = 0.0) -> Points:
    c, s = math.cos(angle), math.sin(angle)
    return [(x + c * a - s * b, y + s * a + c * b) for a, b in points]


def outline(points: Points) -> Points:
    return points + [(u, -r) for u, r in reversed(points)]


def omni_wheel(sheet: Sheet, centre: tuple[float, float], distance: float, count: int, first: float) -> None:
    """Rollers along the rim (psi = 0) of a wheel of radius 1, the first at the azimuth q from straight down."""
    shape = outline(profile(1.0, distance, count, 0.0))
    for i in [*range(1, count), 0]:
        q = first + 2 * math.pi * i / count
        place = (centre[0] + distance * math.sin(q), centre[1] - distance * math.cos(q))
        sheet.line(*turned(shape, q, *place), fill="#eceff1", colour=PALE if i else INK, closed=True)


def frames_side() -> Sheet:
    """A wheel from its right side, and the letters of its contact."""
    sheet, q, distance = Sheet(430, 380, 150, (190, 180)), math.radians(18), 0.8
    sheet.floor(-1.2, 1.5, -1.0)
    omni_wheel(sheet, (0, 0), distance, 6, q)
    sheet.circle((0, 0), 1.0, PALE, dash=DASHED)
    end = (distance * math.sin(q), -distance * math.cos(q))
    sheet.line((0, 0), (0, -1), colour=PALE)
    sheet.line((0, 0), end, colour=COOL, width=2)
    sheet.text((0.17, -0.3), "R_1", COOL, "start")
    sheet.text((-0.07, -0.45), "R", anchor="end")
    below = (0.0, -distance / math.cos(q))
    sheet.arrow(end, (-0.52 * math.cos(q), -0.52 * math.sin(q)), COOL)
    sheet.text((end[0] - 0.58, end[1] - 0.06), "t", COOL)
    sheet.line(end, below, colour=WARM, width=3.5)
    sheet.text((0.16, -0.88), "m", WARM)
    sheet.line(below, (0, -1), colour=WARM, width=3.5)
    sheet.text((-0.05, -0.925), "h_q", WARM, "end", size=15)
    sheet.arc((0, 0), 0.55, -90, -90 + math.degrees(q), COOL)
    sheet.text((0.075, -0.63), "q", COOL)
    sheet.arrow((0, 0), (1.3, 0))
    sheet.text((1.4, 0), "h")
    sheet.arrow((0, 0), (0, 1.12))
    sheet.text((-0.09, 1.1), "n")
    sheet.arrow(end, (0.32 * math.sin(q), -0.32 * math.cos(q)), COOL)
    sheet.text((end[0] + 0.14, -1.08), "d", COOL, "start")
    away(sheet, (0, 0), 0.06)
    sheet.text((-0.1, 0.1), "k", anchor="end")
    sheet.text((0.1, 0.1), "O", anchor="start")
    sheet.dot(end, COOL)
    sheet.text((end[0] + 0.07, end[1] + 0.08), "O_B", COOL, "start")
    sheet.dot((0, -1), WARM)
    sheet.text((0, -1.12), "P", WARM)
    sheet.arc((0, 0), 0.75, 130, 60)
    sheet.text((0.28, 0.82), "φ")
    return sheet


def frames_front() -> Sheet:
    """A mecanum wheel from behind: the contact wanders along the axle."""
    sheet, q = Sheet(360, 330, 120, (180, 150)), math.radians(16)
    shift = 0.8 * math.tan(q)
    sheet.floor(-1.3, 1.3, -1.0)
    sheet.line((-0.2, 0.62), (0.2, 0.62), (0.2, -0.62), (-0.2, -0.62), closed=True, fill="#eceff1", colour=PALE)
    half = 0.72 * math.cos(q)
    for x, y, colour in ((0.0, -0.8 * math.cos(q), INK), (0.0, 0.8 * math.cos(q), PALE)):
        tilt = math.radians(9 if y < 0 else -9)
        body = [(half * (i / 10), 0.19 * math.sqrt(1 - 0.55 * (i / 10) ** 2)) for i in range(-10, 11)]
        sheet.line(*turned(outline(body), tilt, x, y), closed=True, colour=colour)
    sheet.line((0, 1.05), (0, -1.0), colour=PALE, dash=DASHED)
    sheet.arrow((0, 0), (-1.1, 0))
    sheet.text((-1.22, 0), "k")
    sheet.arrow((0, 0), (0, 1.1))
    sheet.text((0.12, 1.08), "n")
    sheet.text((0.1, 0.1), "O", anchor="start")
    sheet.line((0, -1.08), (-shift, -1.08), colour=WARM, width=2, tip=True)
    sheet.text((-0.5 * shift, -1.24), "l", WARM)
    sheet.dot((-shift, -1.0), WARM)
    sheet.text((-shift - 0.14, -1.13), "P", WARM)
    sheet.line((0.62, 0), (0.62, -1), colour=COOL, tip=True)
    sheet.text((0.73, -0.4), "R", COOL)
    sheet.dot((0, 0))
    return sheet


def frames_top() -> Sheet:
    """World, body and wheel from above."""
    sheet = Sheet(390, 300, 100, (40, 250))
    sheet.arrow((0, 0), (2.4, 0))
    sheet.text((2.5, 0), "x")
    sheet.arrow((0, 0), (0, 2.1))
    sheet.text((0, 2.22), "y")
    centre, angle = (1.35, 0.85), math.radians(32)
    sheet.line(
        *turned([(-0.5, -0.16), (0.5, -0.16), (0.5, 0.16), (-0.5, 0.16)], angle, *centre),
        closed=True,
        fill="#eceff1",
        colour=PALE,
    )
    sheet.arrow(centre, (math.cos(angle), math.sin(angle)))
    sheet.text((2.33, 1.45), "h")
    sheet.arrow(centre, (-0.75 * math.sin(angle), 0.75 * math.cos(angle)))
    sheet.text((0.86, 1.56), "k")
    sheet.line(centre, (2.3, 0.85), colour=PALE, dash=DASHED)
    sheet.arc(centre, 0.7, 0, 32, COOL)
    sheet.text((2.1, 1.03), "θ + heading", COOL, "start", size=15)
    sheet.dot(centre)
    sheet.text((1.27, 0.68), "O")
    return sheet


def roller_profile() -> Sheet:
    """The generatrix of a mecanum roller, from its formula."""
    sheet, points = Sheet(480, 230, 230, (225, 120)), profile(1.0, 0.8, 8, math.radians(45))
    end, tip = points[-1]
    sheet.line(*outline(points), closed=True, fill="#eceff1", colour=INK, width=2)
    sheet.arrow((-end - 0.18, 0), (2 * end + 0.4, 0), width=1.5)
    sheet.text((end + 0.29, 0), "a")
    sheet.line((0, 0), (0, points[20][1]), colour=WARM, tip=True)
    sheet.text((-0.04, 0.1), "r(0)", WARM, "end")
    sheet.line((end, 0), (end, tip), colour=WARM, tip=True)
    sheet.text((end + 0.03, 0.09), "r(α)", WARM, "start")
    here = points[31]
    sheet.dot(here, COOL)
    sheet.line((here[0], 0), here, colour=COOL, dash=DASHED)
    sheet.text((here[0] + 0.02, here[1] + 0.07), "u(q), r(q)", COOL, "start")
    for side in (-end, end):
        sheet.line((side, -tip), (side, -0.36), colour=PALE)
    sheet.line((0, -0.33), (end, -0.33), tip=True)
    sheet.line((0, -0.33), (-end, -0.33), tip=True)
    sheet.text((0, -0.41), "2 u(α)")
    return sheet


def friction_laws() -> Sheet:
    """Friction by slip: the jump and two smooth laws."""
    sheet, eps = Sheet(430, 250, 100, (215, 125)), 0.45
    sheet.arrow((-1.95, 0), (3.9, 0), PALE, 1.2)
    sheet.text((1.95, -0.14), "v")
    sheet.arrow((0, -1.15), (0, 2.3), PALE, 1.2)
    sheet.text((0.25, 1.12), "- F")
    slips = [-1.85 + 3.7 * i / 80 for i in range(81)]
    sheet.line(*[(v, 0.85 * v / math.hypot(v, eps)) for v in slips], colour=COOL, width=2)
    sheet.line(*[(v, 0.85 * v / max(abs(v), eps)) for v in slips], colour=WARM, width=1.5, dash=DASHED)
    sheet.line((-1.85, -0.85), (0, -0.85), (0, 0.85), (1.85, 0.85), width=2.4)
    sheet.line((0, 0.85), (eps, 0.85), (eps, 0), colour=PALE, dash="2 3")
    sheet.text((eps, -0.13), "ε")
    sheet.text((-0.12, 0.85), "μ N", anchor="end")
    for y, words, colour in ((-0.35, "coulomb", INK), (-0.57, "saturated", WARM), (-0.79, "regularized", COOL)):
        sheet.line((0.75, y), (1.05, y), colour=colour, width=2)
        sheet.text((1.13, y), words, colour, "start", symbol=False)
    return sheet


def two_rollers() -> Sheet:
    """A wheel on an edge between two of its rollers."""
    sheet, distance, count = Sheet(430, 330, 140, (215, 160)), 0.8, 6
    alpha = math.pi / count
    sheet.floor(-1.4, 1.4, -1.0)
    omni_wheel(sheet, (0, 0), distance, count, alpha)
    sheet.circle((0, 0), 1.0, PALE, dash=DASHED)
    for side, name, load in ((1, "q = +α", "σ N"), (-1, "q = -α", "(1 - σ) N")):
        place = (side * distance * math.sin(alpha), -distance * math.cos(alpha))
        sheet.line((0, 0), place, colour=COOL)
        sheet.text((0.6 * place[0] + 0.06 * side, 0.45 * place[1]), name, COOL, "start" if side > 0 else "end", size=15)
        sheet.arrow((side * 0.07, -1.16), (0, 0.14), WARM)
        sheet.text((side * 0.16, -1.11), load, WARM, "start" if side > 0 else "end", size=15)
    sheet.arc((0, 0), 0.32, 150, 60, INK)
    sheet.arc((0, 0), 0.42, 30, 120, INK)
    sheet.text((0, 0.62), "φ' = φ'' = 0", size=15)
    sheet.dot((0, 0))
    return sheet


def away(sheet: Sheet, place: tuple[float, float], size: float) -> None:
    """An arrow that points away from the reader."""
    sheet.circle(place, size, fill="white")
    reach, (x, y) = 0.7 * size, place
    sheet.line((x - reach, y - reach), (x + reach, y + reach))
    sheet.line((x - reach, y + reach), (x + reach, y - reach))


def bearing_axes() -> Sheet:
    """Axes along which bearing loads are told."""
    sheet = Sheet(520, 290, 105, (140, 150))
    sheet.floor(-1.2, 1.2, -1.0)
    omni_wheel(sheet, (0, 0), 0.8, 8, math.radians(15))
    sheet.arrow((0, 0), (0.6, 0))
    sheet.text((0.5, 0.13), "h")
    sheet.arrow((0, 0), (0, 0.6))
    sheet.text((0.11, 0.5), "n")
    away(sheet, (0, 0), 0.07)
    sheet.text((-0.1, -0.12), "k", anchor="end")
    sheet.text((0, 1.22), "hub: at the wheel's axle", symbol=False)
    shape = outline(profile(1.0, 0.8, 8, math.radians(45)))
    sheet.line(*[(2.3 + 1.5 * u, 0.2 + 1.5 * r) for u, r in shape], closed=True, fill="#eceff1", colour=INK)
    sheet.arrow((2.3, 0.2), (0.95, 0), COOL)
    sheet.text((3.15, 0.36), "axial", COOL, symbol=False)
    sheet.arrow((2.3, 0.2), (0, -0.75), WARM)
    sheet.text((2.3, -0.7), "radial: out from the wheel's centre", WARM, symbol=False)
    away(sheet, (2.3, 0.2), 0.07)
    sheet.text((2.2, 0.33), "lateral", INK, "end", symbol=False)
    sheet.text((2.3, 1.22), "mount: at a roller's axle", symbol=False)
    return sheet


def kiwi_places() -> Sheet:
    """The machine on the page: wheels at 0.125 m from the middle; the page has x up and y to the left."""
    sheet, rim = Sheet(400, 310, 1000, (200, 140)), [(-0.05, -0.012), (0.05, -0.012), (0.05, 0.012), (-0.05, 0.012)]
    sheet.circle((0, 0), 0.085, PALE, fill="#f5f5f5")
    sheet.arrow((0, 0), (0, 0.065))
    sheet.text((0.012, 0.06), "x")
    sheet.arrow((0, 0), (-0.065, 0))
    sheet.text((-0.06, 0.014), "y")
    for name, x, y, heading in (
        ("left", 0.0625, 0.1083, 150),
        ("back", -0.125, 0.0, 270),
        ("right", 0.0625, -0.1083, 30),
    ):
        place, angle = (-y, x), math.radians(heading + 90)
        sheet.line(*turned(rim, angle, *place), closed=True, fill="#cfd8dc")
        sheet.arrow(place, (0.07 * math.cos(angle), 0.07 * math.sin(angle)), WARM)
        sheet.text((-1.42 * y, 1.22 * x), name, symbol=False)
    sheet.text((0.085, 0.13), "h", WARM)
    return sheet


def mecanum_hands() -> Sheet:
    """Four wheels from above, with the rollers on top of them and those on the floor."""
    sheet = Sheet(400, 330, 110, (150, 165))
    sheet.line((-0.55, -1.2), (0.55, -1.2), (0.55, 1.2), (-0.55, 1.2), closed=True, colour=PALE, fill="#f5f5f5")
    for x, y, lean in ((-0.8, 0.9, -1), (0.8, 0.9, 1), (-0.8, -0.9, 1), (0.8, -0.9, -1)):
        sheet.line(
            (x - 0.17, y - 0.4),
            (x + 0.17, y - 0.4),
            (x + 0.17, y + 0.4),
            (x - 0.17, y + 0.4),
            closed=True,
            fill="#eceff1",
        )
        for step in (-0.22, 0.0, 0.22):
            sheet.line((x - 0.14, y + step - lean * 0.14), (x + 0.14, y + step + lean * 0.14), colour=INK, width=4)
        sheet.line((x - 0.3, y + lean * 0.3), (x + 0.3, y - lean * 0.3), colour=WARM, width=2, dash=DASHED)
    sheet.arrow((0, -0.3), (0, 0.7))
    sheet.text((0.12, 0.36), "x")
    sheet.arrow((0, -0.3), (-0.4, 0))
    sheet.text((-0.36, -0.14), "y")
    sheet.line((1.2, 0.25), (1.5, 0.25), width=4)
    sheet.text((1.2, 0.05), "on top: X", anchor="start", symbol=False)
    sheet.line((1.2, -0.25), (1.5, -0.25), colour=WARM, width=2, dash=DASHED)
    sheet.text((1.2, -0.45), "on the floor: O", WARM, "start", symbol=False)
    return sheet


def loads() -> Sheet:
    """What the floor carries: levers of a machine from its side."""
    sheet = Sheet(430, 270, 90, (215, 220))
    sheet.floor(-2.2, 2.2)
    for x in (-1.3, 1.3):
        sheet.circle((x, 0.5), 0.5, PALE, fill="#eceff1")
        sheet.arrow((x, -0.42), (0, 0.4), WARM)
        sheet.arrow((x, 0), (0.55, 0), COOL)
    sheet.text((-1.55, -0.22), "N_1", WARM)
    sheet.text((1.55, -0.22), "N_2", WARM)
    sheet.text((-0.75, 0.16), "F_1", COOL)
    sheet.text((1.85, 0.16), "F_2", COOL)
    sheet.line((-1.7, 0.7), (1.7, 0.7), (1.7, 1.5), (-1.7, 1.5), closed=True)
    sheet.dot((-0.2, 1.15))
    sheet.text((-0.38, 1.25), "C")
    sheet.arrow((-0.2, 1.15), (0, -0.62))
    sheet.text((-0.05, 0.85), "M g", anchor="start")
    sheet.line((0.75, 0), (0.75, 1.15), colour=PALE, tip=True)
    sheet.line((-0.2, 1.15), (0.9, 1.15), colour=PALE, dash=DASHED)
    sheet.text((0.95, 0.45), "z_C")
    sheet.line((-0.2, 1.75), (-1.3, 1.75), colour=PALE, tip=True)
    sheet.text((-0.75, 1.92), "D_1", INK)
    sheet.arrow((1.1, 1.95), (0.7, 0))
    sheet.text((1.45, 2.12), "acceleration", symbol=False)
    return sheet


def step_cut() -> Sheet:
    """An event inside a step."""
    sheet = Sheet(470, 150, 100, (30, 100))
    sheet.arrow((0, 0), (4.2, 0), PALE, 1.5)
    sheet.text((4.3, 0), "t")
    for i in range(4):
        sheet.line((0.4 + 1.1 * i, -0.08), (0.4 + 1.1 * i, 0.08))
        sheet.text((0.4 + 1.1 * i, -0.25), ("t_n", "t_n+1", "t_n+2", "t_n+3")[i], size=15)
    sheet.line((1.5, 0.25), (2.6, 0.25), colour=PALE, dash=DASHED, tip=True)
    sheet.text((2.35, 0.42), "given up", PALE, symbol=False)
    sheet.line((0.4, 0.12), (1.5, 0.12), colour=COOL, width=2, tip=True)
    sheet.line((1.5, 0.12), (2.05, 0.12), colour=COOL, width=2, tip=True)
    sheet.line((2.05, 0.12), (2.6, 0.12), colour=WARM, width=2, tip=True)
    sheet.line((2.6, 0.12), (3.7, 0.12), colour=WARM, width=2, tip=True)
    sheet.line((2.05, -0.1), (2.05, 0.62), colour=WARM)
    sheet.text((2.05, 0.78), "event: the mode changes", WARM, symbol=False)
    return sheet


SKETCHES: dict[str, Callable[[], Sheet]] = {
    sketch.__name__: sketch
    for sketch in (frames_side, frames_front, frames_top, roller_profile, friction_laws, two_rollers, bearing_axes,
                   kiwi_places, mecanum_hands, loads, slope, common_normals, rigid_limit, step_cut)
}  # fmt: skip


def main() -> None:
    for name, sketch in SKETCHES.items():
        (FOLDER / f"{name}.svg").write_text(sketch().svg(), encoding="utf-8")


if __name__ == "__main__":
    main()
