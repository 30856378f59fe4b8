"""Many runs of one scene, its keys varied: on all cores of a machine, or of a cluster."""
