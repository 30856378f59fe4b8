"""What a study has found, for people."""

from collections import Counter

import numpy as np

from omnisim.base.formatting import aligned, visible
from omnisim.results.layout import COMPLETE
from omnisim.scene.scene import load_text
from omnisim.studies.result import NOT_RUN, StudyResult

KINDS_OF_FAILURE = 5  # that are told


def about(found: StudyResult) -> str:
    """What a file holds: the study, what varies in it, and its findings."""
    varied = [name for name, one in found.variables.items() if one.coordinate and name not in ("run", "seed")]
    lines, _ = findings(found)
    return aligned({"study": title(found), "varied": ", ".join(varied)} | lines)


def title(found: StudyResult) -> str:
    """How many runs of which scene, and the kind of the design."""
    a = found.attributes
    return f"{a['runs']} runs of {visible(load_text(a['scene']).config.title) or 'a scene'} ({a['design']})"


def findings(found: StudyResult) -> tuple[dict[str, str], list[int]]:
    """Lines by title, how many runs are complete, the range of every measure, failures; and the runs that they name."""
    status = found["status"].ravel()
    named: list[int] = []
    lines = {"complete": f"{np.sum(status == COMPLETE)} of {found.attributes['finished']} that have ended"}
    for name in found.measures:
        values = found[name].ravel()
        if np.isfinite(values).any():
            least, most = int(np.nanargmin(values)), int(np.nanargmax(values))
            units = found.variables[name].units
            lines[name] = f"{values[least]:.6g} (run {least}) to {values[most]:.6g} {units} (run {most})"
            named.append(most)
    failed = Counter(reason(text) for text in status if text not in (COMPLETE, NOT_RUN))
    for why, count in failed.most_common(KINDS_OF_FAILURE):
        run = next(i for i, text in enumerate(status) if reason(text) == why)
        lines[f"{count} not"] = f"{status[run]} (run {run})"
        named.append(run)
    return lines, list(dict.fromkeys(named))


def reason(status: str) -> str:
    """Why a run ended early, without its numbers."""
    return status.partition(":")[0].partition(" at t")[0]
