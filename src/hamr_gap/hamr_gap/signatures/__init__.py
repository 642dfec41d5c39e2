"""A page for every effect of the library, with a picture of what it does: python -m hamr_gap.signatures [--out docs/effects] [NAME ...]."""
