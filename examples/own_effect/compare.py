"""The grasp of grasp.toml with the grease and without: python compare.py

An experiment can be written in Python, too: the last one closes on nothing, half as fast.
"""

from hannes import Experiment, Hand, Reference, load_experiment, observe, simulate


def peak(hand, experiment, channel):
    """Largest value of a channel as it is logged."""
    recording = observe(hand, simulate(hand, experiment))
    return recording[channel].max()


def main():
    """Print what the grease takes away."""
    (asked,) = load_experiment("grasp.toml", trust=True)  # grease.py may run
    hands = {"with grease": asked.hand, "without": Hand()}
    for name, hand in hands.items():
        print(f"{name}: {peak(hand, asked.experiment, 'force'):.1f} N at most")
    slowly = Experiment("slow closing", 0.6, Reference([[0.0, 0.6], [0.0, 4.6]]))
    for name, hand in hands.items():
        print(f"{name}: {peak(hand, slowly, 'current'):.3f} A at most while closing slowly")


if __name__ == "__main__":
    main()
