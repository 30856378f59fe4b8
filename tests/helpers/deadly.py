"""A task that kills its process; in a file of its own, from which other processes import it."""

import os
import signal

from omnisim.studies.task import Task


class Deadly(Task):
    """Dies of run 11."""

    def __call__(self, runs):
        if 11 in runs:
            os.kill(os.getpid(), signal.SIGKILL)
        return super().__call__(runs)
