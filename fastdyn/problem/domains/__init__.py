"""The options `domain` and `nonnegative`: checks, and the functions that keep a solve inside."""
