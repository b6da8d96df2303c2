"""Plants of the protocol, one file each."""

import os

# MuJoCo decides at its first import how it would draw, which loads a windowing library and starts a
# process to ask for its version. A bridge draws nothing; ``lexstack_sim.render`` decides by itself.
os.environ.setdefault("MUJOCO_GL", "off")
