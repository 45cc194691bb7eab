"""``python -m softlimb.cli``, for where the command is not on the path."""

from softlimb.cli import main

raise SystemExit(main())
