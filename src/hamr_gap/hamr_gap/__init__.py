"""Find, name, add, show: where a simulation and measured data disagree, which effect is missing, and the model with it.

`gap` (bags of HAMR) and `plants` (tables of any other machine) are the ways in, `study` is the whole workflow for both. Each folder imports
only those before it: data, fitting, naming, judging, experiments, answers, showing. `walking` does for robots on the ground what these do
for one leg. `bench` hides effects and scores answers, `signatures` draws the pages of the library.
"""
