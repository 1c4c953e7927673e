"""The C++ reference: its sources, its build, its calls through ctypes."""
