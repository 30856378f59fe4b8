"""What a run returns, and where it goes: datasets, files, tables, comparisons, reports."""
