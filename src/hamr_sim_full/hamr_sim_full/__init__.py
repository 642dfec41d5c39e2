"""HAMR-full: four spherical five-bar transmissions with piezo actuators; the compiled kernel and the MuJoCo model."""
