"""The command `python -m bench`."""

from bench.run import main

main()
