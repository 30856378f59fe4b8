"""Types of the public names, which __init__.py finds on first use."""

from omnisim import analysis as analysis
from omnisim import export as export
from omnisim import plots as plots
from omnisim import report as report
from omnisim import viewer as viewer
from omnisim.loop import Loop as Loop
from omnisim.scene import Scene as Scene
from omnisim.scene import SceneError as SceneError
from omnisim.scene import load as load
from omnisim.scene import load_text as load_text
from omnisim.simulation import simulate as simulate
from omnisim.storage import TrajectoryError as TrajectoryError
from omnisim.storage import read as open_trajectory
from omnisim.trajectory import Trajectory as Trajectory

__version__: str
__all__ = [
    "Loop",
    "Scene",
    "SceneError",
    "Trajectory",
    "TrajectoryError",
    "__version__",
    "analysis",
    "export",
    "load",
    "load_text",
    "open_trajectory",
    "plots",
    "report",
    "simulate",
    "viewer",
]
