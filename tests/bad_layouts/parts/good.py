"""An extension."""

from rune_tui.layout.rules import VisualizerRule


class Shown:
    """An extension."""

    rule = VisualizerRule(meaning="nothing")
    whole_cells = True

    @classmethod
    def from_spec(cls, spec):
        return cls()

    def draw(self, canvas, robot, state):
        pass

    def source(self, robot, state):
        return None


VISUALIZERS = {"visualizeNothing": Shown}
