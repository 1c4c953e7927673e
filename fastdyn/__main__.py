"""``python -m fastdyn`` is the command ``fastdyn``."""

import sys

from fastdyn.cli import main

sys.exit(main())
