"""Words and numbers as people read and write them: near names, kinds of values, files."""
