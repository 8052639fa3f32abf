"""Parts of the benchmark `grip`: objects that are held, pulled and shaken; estimates of force."""
