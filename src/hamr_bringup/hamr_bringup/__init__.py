"""Launch files, parameters, demo and the hamr command."""
