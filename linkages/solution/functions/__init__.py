"""The equations of motion and their flow as functions, for own analyses."""
