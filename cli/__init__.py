"""The command `omnisim`: parse, call one function, print."""
