"""Sketches of ground: a slope, and where rollers touch bumps and steps; docs/sketches.py draws them."""
# ruff: noqa: RUF001  (Greek letters are meant)

import math

from docs.sketch_sheet import COOL, DASHED, FLOOR, INK, PALE, WARM, Sheet


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
