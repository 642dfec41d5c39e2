"""What may be said: how probable names are, how sure sizes, where the gap is, whether noise is all that is left; `analyse` does it all."""
