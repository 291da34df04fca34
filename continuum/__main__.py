"""``python -m continuum`` is the command ``continuum``."""

from continuum.front.cli import main

raise SystemExit(main())
