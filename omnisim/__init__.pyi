"""Types of the public names, which __init__.py finds on first use."""

from omnisim.base.trajectory_file import TrajectoryError as TrajectoryError
from omnisim.exports import formats as export
from omnisim.fitting.fitting import fit as fit
from omnisim.fitting.logs import FitError as FitError
from omnisim.pictures import plots as plots
from omnisim.pictures import viewer as viewer
from omnisim.results import comparison as analysis
from omnisim.results import report as report
from omnisim.results.trajectory import Trajectory as Trajectory
from omnisim.results.trajectory import open_trajectory as open_trajectory
from omnisim.run.loop import Loop as Loop
from omnisim.run.simulation import simulate as simulate
from omnisim.scene.scene import Scene as Scene
from omnisim.scene.scene import SceneError as SceneError
from omnisim.scene.scene import load as load
from omnisim.scene.scene import load_text as load_text
from omnisim.studies.many import simulate_many as simulate_many
from omnisim.studies.result import open_study as open_study
from omnisim.studies.sweep import sweep as sweep

__version__: str
__all__ = [
    "FitError",
    "Loop",
    "Scene",
    "SceneError",
    "Trajectory",
    "TrajectoryError",
    "__version__",
    "analysis",
    "export",
    "fit",
    "load",
    "load_text",
    "open_study",
    "open_trajectory",
    "plots",
    "report",
    "simulate",
    "simulate_many",
    "sweep",
    "viewer",
]
