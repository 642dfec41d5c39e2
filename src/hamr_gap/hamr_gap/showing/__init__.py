"""The proof and its pictures: runs on data that nothing has used, the report, the overlay bag, the model with the effect in it."""
