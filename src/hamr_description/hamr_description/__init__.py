"""The one definition of the robot: numbers, names, rates, units; builds the URDF and both MJCF models."""
