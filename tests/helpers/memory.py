"""Memory of this process."""

import os
from pathlib import Path


def resident() -> float:
    """What of it is in memory, MB."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6
