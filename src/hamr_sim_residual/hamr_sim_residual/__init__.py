"""HAMR-simple and the residual model learned from bags; simulator node."""
