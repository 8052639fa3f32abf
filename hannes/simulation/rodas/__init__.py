"""A compiled stiff integrator behind scipy's interface: `solve_ivp(..., method=Rodas)`."""
