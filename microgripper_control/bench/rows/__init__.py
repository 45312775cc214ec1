"""One row of the table a file; each has a `ROW`."""
