"""Speed and accuracy, measured: `python -m bench`; the rules stand in README.md."""
