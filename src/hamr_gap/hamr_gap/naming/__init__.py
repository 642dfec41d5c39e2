"""Which effects are missing: all of the library at all places, screened, fitted, exchanged, dropped, and compared in blocks."""
