"""``python -m fastdyn`` is the command ``fastdyn``."""

import sys

from fastdyn.cli.main import main

sys.exit(main())
