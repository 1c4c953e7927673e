"""The pictures of `fastdyn.analysis`; each takes a result."""
