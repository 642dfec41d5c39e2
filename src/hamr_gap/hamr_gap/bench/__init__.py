"""`hamr gap bench`: hidden effects drawn by a separate program, found blind, and scored."""
