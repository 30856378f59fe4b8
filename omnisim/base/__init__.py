"""What every room stands on: compiled functions and their cache, vectors, records, files, text, methods."""
