"""Position reference at the output shaft: straight lines between knots."""

from hannes.core.kernels.jit import kernel


@kernel
def interpolate(time, knots):
    """Value at `time` of the line through `knots`, shape (2, n): times [s], values [rad].

    Held before the first and after the last knot; of two knots at one time the later one counts.
    """
    last = knots.shape[1] - 1
    if time < knots[0, 0]:
        return knots[1, 0]
    if time >= knots[0, last]:
        return knots[1, last]
    low, high = 0, last
    while high - low > 1:
        middle = (low + high) // 2
        if knots[0, middle] <= time:
            low = middle
        else:
            high = middle
    part = (time - knots[0, low]) / (knots[0, high] - knots[0, low])
    return knots[1, low] + part * (knots[1, high] - knots[1, low])
