"""Algorithm 1 of Zhang et al. and what it needs: plain arrays, rods by RK4, what rods owe a plate. numpy alone."""
