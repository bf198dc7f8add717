"""Nobody knows its message."""

from rune_tui.layout.rules import VisualizerRule


class Shown:
    """Nobody knows its message."""

    rule = VisualizerRule(meaning="nothing", message="X_Heading")
    whole_cells = True

    @classmethod
    def from_spec(cls, spec):
        return cls()

    def draw(self, canvas, robot, state):
        pass

    def source(self, robot, state):
        return None


VISUALIZERS = {"visualizeNothing": Shown}
