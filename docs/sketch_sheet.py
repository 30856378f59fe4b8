"""A sheet to sketch on, written as SVG."""

import math

INK, PALE, WARM, COOL, FLOOR = "#263238", "#b0bec5", "#c62828", "#1565c0", "#90a4ae"
DASHED = "5 4"
Point = tuple[float, float]


class Sheet:
    """An SVG of so many pixels; points are in units from a middle, y up."""

    def __init__(self, width: int, height: int, scale: float, middle: Point) -> None:
        self.size, self.scale, self.middle, self.parts = (width, height), scale, middle, []

    def at(self, x: float, y: float) -> Point:
        return self.middle[0] + self.scale * x, self.middle[1] - self.scale * y

    def line(self, *points: Point, colour: str = INK, width: float = 1.5, dash: str = "", fill: str = "none",
             closed: bool = False, tip: bool = False) -> None:  # fmt: skip
        """Through points; closed, filled, or with an arrow's tip at its end."""
        places = " ".join(f"{x:.1f},{y:.1f}" for x, y in (self.at(*point) for point in points))
        dashes = f' stroke-dasharray="{dash}"' if dash else ""
        kind = "polygon" if closed else "polyline"
        self.parts.append(f'<{kind} points="{places}" fill="{fill}" stroke="{colour}" stroke-width="{width}"{dashes}/>')
        if tip:
            self._tip(points[-2], points[-1], colour)

    def arrow(self, start: Point, by: Point, colour: str = INK, width: float = 2.0) -> None:
        end = (start[0] + by[0], start[1] + by[1])
        self.line(start, end, colour=colour, width=width, tip=True)

    def circle(self, centre: Point, radius: float, colour: str = INK, fill: str = "none", width: float = 1.5,
               dash: str = "") -> None:  # fmt: skip
        (x, y), dashes = self.at(*centre), f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{self.scale * radius:.1f}" fill="{fill}" '
                          f'stroke="{colour}" stroke-width="{width}"{dashes}/>')  # fmt: skip

    def dot(self, place: Point, colour: str = INK) -> None:
        self.circle(place, 3.5 / self.scale, colour, colour)

    def arc(self, centre: Point, radius: float, start: float, end: float, colour: str = INK) -> None:
        """Of angles in degrees, counterclockwise from x, with a tip at its end."""
        angles = [math.radians(start + (end - start) * i / 24) for i in range(25)]
        points = [(centre[0] + radius * math.cos(a), centre[1] + radius * math.sin(a)) for a in angles]
        self.line(*points, colour=colour, tip=True)

    def text(self, place: Point, words: str, colour: str = INK, anchor: str = "middle", symbol: bool = True,
             size: int = 17) -> None:  # fmt: skip
        """A symbol with its index after an underscore, in italics; or words."""
        (x, y), (head, _, index) = self.at(*place), words.partition("_") if symbol else (words, "", "")
        face = 'font-family="serif" font-style="italic"' if symbol else 'font-family="sans-serif"'
        below = f'<tspan dy="4" font-size="{0.7 * size:.0f}">{index}</tspan>' if index else ""
        self.parts.append(f'<text x="{x:.1f}" y="{y + 0.3 * size:.1f}" {face} font-size="{size if symbol else 13}" '
                          f'fill="{colour}" text-anchor="{anchor}">{head}{below}</text>')  # fmt: skip

    def floor(self, left: float, right: float, y: float = 0.0) -> None:
        self.line((left, y), (right, y), colour=FLOOR, width=3)

    def svg(self) -> str:
        width, height = self.size
        head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}">'
        )
        paper = f'<rect width="{width}" height="{height}" rx="6" fill="white"/>'
        return "\n".join([head, paper, *self.parts, "</svg>", ""])

    def _tip(self, start: Point, end: Point, colour: str) -> None:
        (x0, y0), (x1, y1) = self.at(*start), self.at(*end)
        length = math.hypot(x1 - x0, y1 - y0)
        ux, uy = (x1 - x0) / length, (y1 - y0) / length
        wings = [(x1 - 10 * ux + side * 4 * uy, y1 - 10 * uy - side * 4 * ux) for side in (1, -1)]
        places = " ".join(f"{x:.1f},{y:.1f}" for x, y in [(x1 + ux, y1 + uy), *wings])
        self.parts.append(f'<polygon points="{places}" fill="{colour}"/>')
