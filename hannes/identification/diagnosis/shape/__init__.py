"""The shape of what is missing where nothing can be named: a generic disturbance with its band."""
