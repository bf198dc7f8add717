"""It cannot draw."""

from rune_tui.layout.rules import VisualizerRule


class Shown:
    """It cannot draw."""

    rule = VisualizerRule(meaning="nothing")
    whole_cells = True

    @classmethod
    def from_spec(cls, spec):
        return cls()


    def source(self, robot, state):
        return None


VISUALIZERS = {"visualizeNothing": Shown}
