"""Switch for rerun's own log, which must be off before rerun is loaded.

rerun's coloured lines would mix with ours on standard error. A file that cannot be written is
reported by `Recorder.fault` instead, in one line and once. A user who sets `RUST_LOG` gets rerun's
log as asked.
"""

import os

os.environ.setdefault("RUST_LOG", "off")
