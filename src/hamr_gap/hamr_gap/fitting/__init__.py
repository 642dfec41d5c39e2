"""A machine under a record: simulated in lanes, re-tuned, weighed. An effect is a few free numbers here, whichever it may be."""
