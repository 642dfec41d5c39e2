"""Walking: what a bag from the ground says about the whole robot, on segments that start anew."""
