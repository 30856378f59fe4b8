"""The version that is installed."""

from importlib.metadata import PackageNotFoundError, version

try:
    VERSION = version("omnisim-engine")
except PackageNotFoundError:  # sources that were never installed
    VERSION = "unknown"
