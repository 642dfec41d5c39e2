"""Find, name, add, show: where a simulation and measured data disagree, which effect is missing, and the model with it."""
