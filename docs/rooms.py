"""Draws docs/pages/pictures/rooms.svg from the imports as they are: python -m docs.rooms

An arrow leads from a room to one it imports from; those that follow from others are left out.
"""

import re
from pathlib import Path

HERE = Path(__file__).parent
PICTURE = HERE / "pages/pictures/rooms.svg"
PACKAGE = HERE.parent / "omnisim"
IMPORT = re.compile(r"^\s*(?:from|import) omnisim\.(\w+)", re.MULTILINE)
# Rooms by column (of 4 halves) and floor; who imports stands above.
PLACES = {
    "gym": (0, 7),
    "exports": (2, 9),
    "pictures": (2, 8),
    "fitting": (2, 7),
    "studies": (0, 6),
    "run": (0, 5),
    "native": (2, 6),
    "results": (0, 4),
    "march": (0, 3),
    "cad": (2, 3),
    "dynamics": (1, 2),
    "scene": (0, 1),
    "contact": (2, 1),
    "base": (1, 0),
}
SAID = {
    "gym": "environments that learn",
    "fitting": "machines fitted to logs",
    "studies": "many runs, measured",
    "native": "libraries of C, FMUs",
    "run": "simulate, Loop, step search",
    "exports": "tables, ROS 2 recordings",
    "pictures": "plots, 3-D page",
    "results": "trajectory, files, tables",
    "march": "steps, events, modes",
    "cad": "meshes, MJCF, URDF",
    "dynamics": "y' = f(t, y)",
    "scene": "TOML to a checked scene",
    "contact": "where, how fast, what force",
    "base": "kernels, vectors, files",
}
WIDTH, HEIGHT, COLUMN, FLOOR = 230, 48, 140, 88  # of a box; from one to the next
MARGIN = 16


def imports() -> dict[str, set[str]]:
    """From which other rooms each room imports."""
    rooms = [path.parent.name for path in sorted(PACKAGE.glob("*/__init__.py"))]
    sources = {room: [path.read_text(encoding="utf-8") for path in (PACKAGE / room).rglob("*.py")] for room in rooms}
    return {room: {found for text in sources[room] for found in IMPORT.findall(text)} - {room} for room in rooms}


def reduced(arrows: dict[str, set[str]]) -> dict[str, set[str]]:
    """The arrows that do not follow from others; without circles, which tests/test_imports.py forbids."""

    def below(room: str) -> set[str]:
        return arrows[room].union(*map(below, arrows[room]))

    return {room: ends - set().union(*map(below, ends)) for room, ends in arrows.items()}


def corner(room: str) -> tuple[int, int]:
    """Upper left one of a box."""
    column, floor = PLACES[room]
    top = max(floor for _, floor in PLACES.values())
    return MARGIN + column * COLUMN, MARGIN + (top - floor) * FLOOR


def picture() -> str:
    """The SVG."""
    width = 2 * MARGIN + 2 * COLUMN + WIDTH
    height = 2 * MARGIN + max(floor for _, floor in PLACES.values()) * FLOOR + HEIGHT
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}"'
        ' font-family="sans-serif" role="img">',
        "<title>The rooms of omnisim and who imports from whom</title>",
        '<defs><marker id="tip" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="7" markerHeight="7" orient="auto">'
        '<path d="M0 1 L10 5 L0 9 z" fill="#555"/></marker></defs>',
        f'<rect width="{width}" height="{height}" fill="white"/>',
    ]
    for room, ends in sorted(reduced(imports()).items()):
        parts += [arrow(room, end) for end in sorted(ends)]
    parts += [box(room) for room in PLACES]
    return "\n".join([*parts, "</svg>"]) + "\n"


def arrow(room: str, end: str) -> str:
    (x_0, y_0), (x_1, y_1) = corner(room), corner(end)
    lean = (x_1 > x_0) - (x_1 < x_0)  # to which side: the arrow leaves and arrives off the middle
    x_0, x_1 = x_0 + WIDTH // 2 + lean * WIDTH // 4, x_1 + WIDTH // 2 - lean * WIDTH // 4
    return f'<path d="M{x_0} {y_0 + HEIGHT} L{x_1} {y_1}" stroke="#555" fill="none" marker-end="url(#tip)"/>'


def box(room: str) -> str:
    x, y = corner(room)
    middle = x + WIDTH // 2
    return (
        f'<rect x="{x}" y="{y}" width="{WIDTH}" height="{HEIGHT}" rx="6" fill="#eef3f7" stroke="#0072B2"/>'
        f'<text x="{middle}" y="{y + 20}" text-anchor="middle" font-size="15" font-weight="bold">{room}</text>'
        f'<text x="{middle}" y="{y + 38}" text-anchor="middle" font-size="12" fill="#444">{SAID[room]}</text>'
    )


if __name__ == "__main__":
    PICTURE.write_text(picture(), encoding="utf-8")
