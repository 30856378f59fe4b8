"""Pictures of trajectories, by matplotlib.

    figure = omnisim.plots.story(trajectory)  # or several: story([a, b]), story({"slow": a, "fast": b})
    figure.savefig("story.png")

Every view takes trajectories, `study` what `sweep` has found, `fit_paths` and `fit_residuals` what `fit` has, and
returns a Figure of pyplot; PlotError says what they do not have to show.
"""

from omnisim.pictures.plots.bearing_loads import bearings
from omnisim.pictures.plots.drive import drives
from omnisim.pictures.plots.fits import fit_paths, fit_residuals
from omnisim.pictures.plots.floor import path
from omnisim.pictures.plots.motion import contact, energy, forces, odometry, ride, slip
from omnisim.pictures.plots.overview import story
from omnisim.pictures.plots.paper import trackings
from omnisim.pictures.plots.roller_maps import rollers
from omnisim.pictures.plots.spectra import ripple
from omnisim.pictures.plots.studies import study
from omnisim.pictures.plots.style import PlotError

_ALL = (story, path, drives, contact, slip, forces, ride, rollers, ripple, odometry, energy, bearings, trackings)
VIEWS = {view.__name__: view for view in _ALL}
__all__ = [  # in full: tools that check types read it
    "VIEWS", "PlotError", "bearings", "contact", "drives", "energy", "fit_paths", "fit_residuals", "forces", "odometry",
    "path", "ride", "ripple", "rollers", "slip", "story", "study", "trackings",
]  # fmt: skip
