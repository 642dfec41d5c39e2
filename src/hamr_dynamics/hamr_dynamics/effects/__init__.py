"""The library of effects: each module beside this one that defines EFFECT is an effect; adding one is adding a file."""
