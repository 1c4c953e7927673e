"""The past of a delay equation, within the step that is being taken."""
