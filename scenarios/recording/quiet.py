"""rerun's own log, which would colour lines of ours on standard error: off before rerun is loaded.

A file that cannot be written is reported by `Recorder.fault`, in one line and once. A user who sets
`RUST_LOG` gets rerun's log as asked.
"""

import os

os.environ.setdefault("RUST_LOG", "off")
