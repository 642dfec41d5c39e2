"""The commands of `hamr`, one module each; heavy imports stand inside `run`, so that help and `hamr doctor` need almost nothing."""
