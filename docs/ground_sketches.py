"""Sketches of ground: a slope, where rollers touch bumps and steps, and the rigid limit; docs/sketches.py draws them."""
# ruff: noqa: RUF001  (Greek letters are meant)

import math
from pathlib import Path

from docs.sketch_sheet import COOL, DASHED, FLOOR, INK, PALE, WARM, Sheet

PAGE = Path(__file__).parent / "pages/ground.md"


def slope() -> Sheet:
    """Gravity on a floor that rises by S."""
    sheet, angle = Sheet(400, 250, 100, (70, 200)), math.radians(22)
    c, s = math.cos(angle), math.sin(angle)
    sheet.line((0, 0), (3, 0), colour=PALE, dash=DASHED)
    sheet.line((0, 0), (3 * c, 3 * s), colour=FLOOR, width=3)
    sheet.arc((0, 0), 1.0, 0, 22, COOL)
    sheet.text((1.17, 0.2), "S_f", COOL)
    foot = (1.9 * c, 1.9 * s)
    centre = (foot[0] - 0.4 * s, foot[1] + 0.4 * c)
    sheet.circle(centre, 0.4, INK, fill="#eceff1")
    sheet.arrow(centre, (0, -1.05))
    sheet.text((centre[0] + 0.12, centre[1] - 1.0), "M g", anchor="start")
    sheet.arrow(centre, (-1.05 * s * c, -1.05 * s * s), WARM)
    sheet.text((centre[0] - 0.62, centre[1] - 0.06), "M g_t", WARM)
    sheet.arrow(centre, (-0.8 * s, 0.8 * c))
    sheet.text((centre[0] - 0.42, centre[1] + 0.72), "n")
    sheet.arrow((2.35 * c, 2.35 * s + 0.12), (0.55 * c, 0.55 * s))
    sheet.text((2.3 * c + 0.15, 2.35 * s + 0.48), "U: uphill", anchor="start", symbol=False)
    return sheet


def common_normals() -> Sheet:
    """A roller on a bump, and one that touches the ground and the edge of a step at once."""
    sheet = Sheet(620, 250, 100, (30, 190))
    bump = [(x, 0.55 * math.exp(-(((x - 1.3) / 0.75) ** 2))) for x in (0.05 * i for i in range(53))]
    sheet.line(*bump, colour=FLOOR, width=3)
    x, height = bump[19]
    slope = -2.0 * (x - 1.3) / 0.75**2 * height
    size = math.hypot(1.0, slope)
    nu, radius, depth = (-slope / size, 1.0 / size), 0.42, 0.1
    centre = (x + (radius - depth) * nu[0], height + (radius - depth) * nu[1])
    low = (centre[0] - radius * nu[0], centre[1] - radius * nu[1])
    sheet.circle(centre, radius, INK, fill="#eceff1")
    sheet.line(*bump, colour=FLOOR, width=3)
    sheet.line(low, (x + 1.15 * nu[0], height + 1.15 * nu[1]), colour=COOL, tip=True)
    sheet.text((x + 1.15 * nu[0] + 0.05, height + 1.15 * nu[1] + 0.14), "ν", COOL)
    for place, name, side in ((centre, "B", 0.13), ((x, height), "X", -0.16), (low, "P", 0.16)):
        sheet.dot(place, INK)
        sheet.text((place[0] + side, place[1] + (0.06 if name == "X" else -0.03)), name)
    edge, axis = 0.3, (4.5, 0.15)
    arc = [
        (axis[0] - edge * math.sin(a), axis[1] + edge * math.cos(a))
        for a in (math.pi / 60 * i for i in range(21, -1, -1))
    ]
    sheet.line((3.0, 0.0), (axis[0] - edge, 0.0), (axis[0] - edge, axis[1]), *arc, (5.8, axis[1] + edge),
               colour=FLOOR, width=3)  # fmt: skip
    roller, reach = 0.5, 0.5 + edge
    spot = (axis[0] - math.sqrt(reach**2 - (roller - axis[1]) ** 2), roller)
    sheet.circle(spot, roller, INK, fill="#eceff1")
    sheet.arrow((spot[0], 0.0), (0, 0.42), WARM)
    way = ((spot[0] - axis[0]) / reach, (spot[1] - axis[1]) / reach)
    sheet.line(axis, (axis[0] + edge * way[0], axis[1] + edge * way[1]), colour=PALE, dash=DASHED)
    sheet.arrow((axis[0] + edge * way[0], axis[1] + edge * way[1]), (0.42 * way[0], 0.42 * way[1]), WARM)
    sheet.dot(axis, PALE)
    sheet.text((axis[0] + 0.08, axis[1] - 0.02), "e", PALE, "start")
    sheet.arrow((axis[0] - edge, -0.2), (0.5, 0), PALE, 1.5)
    sheet.text((axis[0] - edge + 0.6, -0.2), "s", PALE)
    return sheet


def table_of_the_limit() -> tuple[list[str], list[list[float]]]:
    """Of the page: its machines, and rows of stiffness (N/m) and the difference of each to the rigid one (m)."""
    table = PAGE.read_text(encoding="utf-8").partition("| stiffness, N/m ")[2].partition("\n\n")[0]
    head, _, *rows = [line.split("|")[1:-1] for line in table.split("\n")]
    return [name.strip() for name in head], [[float(cell) for cell in row] for row in rows]


def rigid_limit() -> Sheet:
    """Decades of the difference to the rigid machine over decades of stiffness, both of one length: slopes are true."""
    sheet = Sheet(580, 420, 52, (-185, -85))
    names, rows = table_of_the_limit()
    decades = [[math.log10(number) for number in row] for row in rows]
    for y in range(-8, -2):
        sheet.line((5, y), (9, y), colour="#eceff1", width=1)
        sheet.text((4.85, y), f"1e{y}", anchor="end", symbol=False)
    for x in range(5, 10):
        sheet.line((x, -8.7), (x, -2.5), colour="#eceff1", width=1)
        sheet.text((x, -8.95), f"1e{x}", symbol=False)
    sheet.line((5, -2.5), (5, -8.7), (9, -8.7), colour=PALE)
    sheet.text((7, -9.3), "stiffness, N/m", symbol=False)
    sheet.text((3.75, -2.15), "difference to the rigid machine, m", anchor="start", symbol=False)
    looks = ((INK, "", 0.0), (COOL, "", -0.12), (COOL, DASHED, 0.14), (WARM, "", 0.0))
    for column, (name, (colour, dash, shift)) in enumerate(zip(names, looks, strict=True), 1):
        points = [(row[0], row[column]) for row in decades]
        sheet.line(*points, colour=colour, width=2, dash=dash)
        for point in points:
            sheet.dot(point, colour)
        sheet.text((9.15, points[-1][1] + shift), name, colour, "start", symbol=False)
    x = decades[2][0]
    for power, words, start, place, anchor in (
        (-1.0, "slope -1", decades[2][1] - 0.25, (-0.12, 0.0), "end"),
        (-0.5, "slope -1/2", decades[2][4] + 0.35, (0.25, 0.25), "start"),
    ):
        sheet.line((x, start), (9, start + (9 - x) * power), colour=FLOOR, dash=DASHED)
        sheet.text((x + place[0], start + place[1]), words, anchor=anchor, symbol=False)
    return sheet
