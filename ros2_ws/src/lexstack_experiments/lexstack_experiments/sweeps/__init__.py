"""Many runs of one kind over grids, random values and seeds: on all cores, or on a cluster.

``sweep_file`` is what the user writes, ``kinds`` has what a run can be, ``execution`` spreads runs
over processes and machines by joblib, ``storage`` keeps what they leave, ``summary`` judges it.
"""
